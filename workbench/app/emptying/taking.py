"""A plan carried out against the truth: what the hand closes on, and what it meets."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Policy
from workbench.model.derived.by_tcp import by_taking
from workbench.model.part import Grasp
from workbench.model.plan import ArmPlan, LegName, Plan
from workbench.model.scan import Detection
from workbench.perception.matching.pose_error import pose_error
from workbench.planning.collision.hands import closed_press
from workbench.planning.collision.motion import path_contact
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.kinematics.quickness import hand_acceleration

STRAIGHT_WITHIN, STRAIGHT_TURN = 0.002, float(np.deg2rad(3.0))
"""[m], [rad] A part that lies further from where the plan has it is gripped crooked."""

BETWEEN_FINGERS_WITHIN = 0.01
"""[m] A part that lies further from where the plan has it is not between the fingers."""


@dataclass(frozen=True, slots=True, eq=False)
class Taking:
    """Result of one arm's pick in the simulated pile.

    Attributes:
        number: index of the true part between the fingers; None: no part.
        is_straight: whether the part lies as planned.
        way: true poses `T_world_part` along the lift.
        touches: number of linear motions with a collision.
        is_turned: whether the part lies as planned except for its roll.
        is_held: whether the hand holds the part in spite of a wrong pose.
        slips: whether the part is heavier than the grip can hold.
    """

    number: int | None
    is_straight: bool
    way: tuple[pin.SE3, ...]
    touches: int
    is_turned: bool = False
    is_held: bool = False
    slips: bool = False


def in_turn(plan: Plan) -> Iterator[ArmPlan]:
    """What the arms do, in the order in which they lift their parts."""
    for step in plan.sequence:
        for arm, name in step.runs:
            if name == "extract":
                yield plan.arm(arm)


def carried_out(
    cell: Cell, truth: Sequence[Detection], arm_plan: ArmPlan, meant: Detection
) -> Taking:
    """One arm's part of a plan in the bin as it truly is.

    Args:
        cell: that the plan was made for.
        truth: how the parts lie as the arm begins.
        arm_plan: what it does.
        meant: the part that it goes to, as it was found.
    """
    part, cell = meant.part, by_taking(cell, arm_plan)
    world = World(cell, tuple(truth), policy=_without_margins(cell))
    chain = world.chains[arm_plan.arm]
    q_grasp = np.asarray(arm_plan.leg("approach").q[-1])
    T_world_tcp = chain.pose(q_grasp)
    number, is_straight = _between_fingers(cell, truth, part, T_world_tcp * arm_plan.T_tcp_part)
    moving = frozenset({arm_plan.arm})
    comes = LegPhase(
        moving,
        {arm_plan.arm: arm_plan.leg("approach").opening},
        targets={} if number is None else {arm_plan.arm: number},
        straight=moving,
    )
    touches = _meets(world, arm_plan, "approach", comes)
    if number is None:
        return Taking(None, False, (), touches)
    T_tcp_part = T_world_tcp.actInv(truth[number].T_world_part)
    extract = arm_plan.leg("extract")
    lifts = LegPhase(
        moving,
        {arm_plan.arm: extract.opening},
        held={arm_plan.arm: (number, T_tcp_part)},
        straight=moving,
    )
    touches += _meets(world, arm_plan, "extract", lifts)
    way = tuple(chain.pose(q) * T_tcp_part for q in np.asarray(extract.q))
    T_world_part, lies = T_world_tcp * arm_plan.T_tcp_part, truth[number].T_world_part
    distance, turn = pose_error(
        cell.part(part), lies, T_world_part, roll_known=False, roll_axis=meant.roll_axis
    )
    is_turned = not is_straight and distance <= STRAIGHT_WITHIN and turn <= STRAIGHT_TURN
    is_held = is_turned and _is_held(cell, part, arm_plan, T_tcp_part)
    slips = (is_straight or is_held) and _slips(cell, part, arm_plan, T_tcp_part)
    return Taking(number, is_straight, way, touches, is_turned, is_held, slips)


def failure(taking: Taking, meant: Detection) -> str:
    """What kind of failure (`FAILURES`) a pick is, empty where it went as planned.

    Where nobody has said that the roll is known, any will do in which the hand holds the part.

    Args:
        taking: what became of it.
        meant: the part as it was found.
    """
    if taking.number is None:
        return "missed"
    held = "slipped" if taking.slips else ""
    if taking.is_straight:
        return held
    if not taking.is_turned or meant.roll_known:
        return "crooked"
    return held if taking.is_held else "turned"


def _is_held(cell: Cell, part: str, arm_plan: ArmPlan, T_tcp_part: pin.SE3) -> bool:
    """Whether a hand that closes as planned holds a part that lies otherwise in it."""
    tool = cell.arm(arm_plan.arm).tool
    checker = GraspChecker(cell.part(part), tool)
    extract, T_part_tcp = arm_plan.leg("extract"), T_tcp_part.inverse()
    gap, _ = checker.clearance(T_part_tcp, extract.opening)
    if not tool.fingers:
        grasp = Grasp("", T_part_tcp, 0.0, 0.0)
        return abs(gap) <= tool.press and not checker.seal_findings(grasp)
    hold = checker.hold(T_part_tcp, arm_plan.leg("approach").opening)
    if hold is None:
        return False
    loose = abs(hold.width - extract.opening) / 2 + abs(hold.offset)
    return gap >= -closed_press(tool, checker.part) and loose <= tool.press


def _slips(cell: Cell, part: str, arm_plan: ArmPlan, T_tcp_part: pin.SE3) -> bool:
    """Whether a part weighs more than the hand holds as it moves; False where nobody can say."""
    arm = cell.arm(arm_plan.arm)
    if arm.tool.force is None or cell.part(part).friction is None:
        return False  # before anything is prepared for nothing
    checker = GraspChecker(cell.part(part), arm.tool, hand_acceleration(cell, arm))
    firm = checker.firmness(T_tcp_part.inverse(), arm_plan.leg("approach").opening)
    return firm is not None and not firm.is_enough


def _without_margins(cell: Cell) -> Policy:
    """The policy by which only what really meets counts."""
    return replace(cell.policy, margin=0.0, near_margin=0.0, self_margin=0.0)


def _between_fingers(
    cell: Cell, truth: Sequence[Detection], part: str, T_world_part: pin.SE3
) -> tuple[int | None, bool]:
    """The part of a kind that lies where the hand closes, and whether as it should."""
    errors = {
        number: pose_error(cell.part(part), detection.T_world_part, T_world_part)
        for number, detection in enumerate(truth)
        if detection.part == part
    }
    near = [
        number for number, (distance, _) in errors.items() if distance <= BETWEEN_FINGERS_WITHIN
    ]
    if not near:
        return None, False
    best = min(near, key=lambda number: (errors[number][1] > STRAIGHT_TURN, errors[number]))
    distance, turn = errors[best]
    return best, distance <= STRAIGHT_WITHIN and turn <= STRAIGHT_TURN


def _meets(world: World, arm_plan: ArmPlan, leg: LegName, phase: LegPhase) -> int:
    """1 when something meets on a straight leg that is not meant to, else 0."""
    path, columns = np.asarray(arm_plan.leg(leg).q), world.kinematics.columns[arm_plan.arm]
    world.enter(phase)
    if leg == "extract":
        world.allow_start_contacts(world.configuration({arm_plan.arm: path[0]}))
    base = world.configuration({})
    return int(path_contact(world, columns, base, path) is not None)

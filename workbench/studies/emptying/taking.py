"""A plan carried out against the truth: what the hand closes on, and what it meets."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Policy
from workbench.model.plan import ArmPlan, LegName, Plan
from workbench.model.scan import Detection
from workbench.perception.localization.pose_error import pose_error
from workbench.planning.collision.motion import path_contact
from workbench.planning.collision.pairing import Phase
from workbench.planning.collision.world import World

NEAR, TURNED = 0.002, float(np.deg2rad(3.0))
"""[m], [rad] A part that lies further from where the plan has it is gripped crooked."""

BESIDE = 0.01
"""[m] A part that lies further from where the plan has it is not between the fingers."""


@dataclass(frozen=True, slots=True, eq=False)
class Taking:
    """What an arm's part of a plan comes to.

    `number` is the true part that the hand closes on, None when there is none, and `is_straight`
    whether it lies there as planned.  `way` are the true poses in the world through which it is
    lifted.  `touches` counts the straight legs on which something meets.
    """

    number: int | None
    is_straight: bool
    way: tuple[pin.SE3, ...]
    touches: int


def in_turn(plan: Plan) -> Iterator[ArmPlan]:
    """What the arms do, in the order in which they lift their parts."""
    for step in plan.sequence:
        for arm, name in step.runs:
            if name == "extract":
                yield plan.arm(arm)


def carried_out(cell: Cell, truth: Sequence[Detection], arm_plan: ArmPlan, part: str) -> Taking:
    """One arm's part of a plan in the bin as it truly is.

    Args:
        cell: that the plan was made for.
        truth: how the parts lie as the arm begins.
        arm_plan: what it does.
        part: the kind of part that it goes to.
    """
    world = World(cell, tuple(truth), policy=_without_margins(cell))
    chain = world.chains[arm_plan.arm]
    q_grasp = np.asarray(arm_plan.leg("approach").q[-1])
    T_world_tcp = chain.pose(q_grasp)
    number, is_straight = _between_fingers(cell, truth, part, T_world_tcp * arm_plan.T_tcp_part)
    moving = frozenset({arm_plan.arm})
    comes = Phase(
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
    lifts = Phase(
        moving,
        {arm_plan.arm: extract.opening},
        held={arm_plan.arm: (number, T_tcp_part)},
        straight=moving,
    )
    touches += _meets(world, arm_plan, "extract", lifts)
    way = tuple(chain.pose(q) * T_tcp_part for q in np.asarray(extract.q))
    return Taking(number, is_straight, way, touches)


def _without_margins(cell: Cell) -> Policy:
    """The policy by which only what really meets counts."""
    return replace(cell.policy, margin=0.0, near_margin=0.0, self_margin=0.0)


def _between_fingers(
    cell: Cell, truth: Sequence[Detection], part: str, T_world_part: pin.SE3
) -> tuple[int | None, bool]:
    """The part of a kind that lies where the hand closes, and whether as it should."""
    errors = {
        number: pose_error(cell.part(part), one.T_world_part, T_world_part)
        for number, one in enumerate(truth)
        if one.part == part
    }
    near = [number for number, (distance, _) in errors.items() if distance <= BESIDE]
    if not near:
        return None, False
    best = min(near, key=lambda number: (errors[number][1] > TURNED, errors[number]))
    distance, turn = errors[best]
    return best, distance <= NEAR and turn <= TURNED


def _meets(world: World, arm_plan: ArmPlan, leg: LegName, phase: Phase) -> int:
    """1 when something meets on a straight leg that is not meant to, else 0."""
    path, columns = np.asarray(arm_plan.leg(leg).q), world.kinematics.columns[arm_plan.arm]
    world.enter(phase)
    if leg == "extract":
        world.allow_start_contacts(world.configuration({arm_plan.arm: path[0]}))
    base = world.configuration({})
    return int(path_contact(world, columns, base, path, world.policy.zone) is not None)

"""A plan as a row of stages: what moves, what is true meanwhile, and every way it may be done.

A leg has one stage or two.  Approach: the way there, then the fingers close.  Extract: the first
millimetres, in which the part comes off what it lies on, then the rest.  Place: the way there, then
the fingers open.  Home: as long as the hand is about the part it has let go of, then the rest.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.motion import SLOT_LEGS
from workbench.model.plan import ArmPlan, Leg, LegName, Plan
from workbench.model.tools.slots import standing_name
from workbench.proof.claims.motion import sweep_change, sweep_path
from workbench.proof.claims.table import Situation
from workbench.proof.engine.robot import Tree
from workbench.proof.engine.sets import Sets

INTO_SLOT: frozenset[LegName] = frozenset({"stow", "dock"})
"""Those of them that end in the slot; the others begin there."""

NEAR_MARGIN_LEGS: frozenset[LegName] = frozenset(
    (*SLOT_LEGS, "approach", "extract", "stir", "lift")
)
"""Legs on which tool and held part keep `near_margin`: straight to a part and with it, among the
parts, and at the slot of a tool; the place leg is linear but keeps `margin`."""


FIRST_LEGS: frozenset[LegName] = frozenset({"reach", "view", "undock"})
"""Legs of an arm before which nobody knows where its fingers are."""


@dataclass(frozen=True, slots=True, eq=False)
class LegStage:
    """Part of a leg: `sets` are all configurations it may pass.

    `comes_off`: a lifted part may begin in touch with its bed here; `leaves`: the hand may begin
    in touch with the part that it has let go of; `rises`: the hand goes straight up with what it
    may hold.
    """

    sets: Sets
    now: Situation
    comes_off: bool = False
    leaves: bool = False
    rises: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class MovingArm:
    """An arm on a leg: `path` (m, n) [rad, m] are its waypoints with the fingers' places."""

    plan: ArmPlan
    arm: Arm
    leg: Leg
    path: Floats
    fingers_after: float


@dataclass(frozen=True, slots=True, eq=False)
class MovingStep:
    """Legs that run at once; `base` (nq,) [rad, m] has all else where it stands.

    `waiting` are the arms that have not moved yet: their fingers are closed in `base`, and may be
    anywhere, see `waiting_fingers`.  `held` and `placed`: numbers of parts that are in a hand, or
    where it has put them, as these legs begin.
    """

    moving: tuple[MovingArm, ...]
    waiting: tuple[Arm, ...]
    base: Floats
    held: Mapping[int, ArmPlan]
    placed: Mapping[int, ArmPlan]


def steps_of(cell: Cell, tree: Tree, plan: Plan) -> Iterator[MovingStep]:
    """The steps of a plan in their order."""
    q = tree.rest.copy()
    held: dict[int, ArmPlan] = {}
    placed: dict[int, ArmPlan] = {}
    waiting = list(cell.arms)
    for step in plan.sequence:
        moving = tuple(_moving(cell, plan.arm(arm), name) for arm, name in step.runs)
        waiting = [
            arm for arm in waiting if all(arm is not arm_motion.arm for arm_motion in moving)
        ]
        yield MovingStep(moving, tuple(waiting), q.copy(), dict(held), dict(placed))
        for arm_motion in moving:
            q[tree.columns[arm_motion.arm.name]] = _whole(
                arm_motion.arm, arm_motion.leg.q[-1], arm_motion.fingers_after
            )
            number, name = arm_motion.plan.detection, arm_motion.leg.name
            if name == "approach":
                held[number] = arm_motion.plan
            elif name == "place":
                placed[number] = held.pop(number)


def find_carried(
    cell: Cell, tree: Tree, plan: Plan, step: MovingStep
) -> dict[int, tuple[int, pin.SE3]]:
    """Parts in a hand or put down during a step: detection -> joint, and `T_joint_part`."""
    where: dict[int, tuple[int, pin.SE3]] = {}
    for number, arm_plan in step.held.items():
        arm = cell.arm(arm_plan.arm)
        joint, T_joint_flange = tree.flange(arm)
        T_flange_part = arm.tool.T_flange_tcp * in_hand(cell, tree, plan, arm_plan)
        where[number] = joint, T_joint_flange * T_flange_part
    for number, arm_plan in step.placed.items():
        where[number] = 0, put_at(cell, tree, plan, arm_plan)
    return where


def in_hand(cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan) -> pin.SE3:
    """`T_tcp_part` as the hand takes the part where it was found, whatever the plan states."""
    q_grasp = np.asarray(arm_plan.leg("approach").q[-1])
    T_world_part = plan.detections[arm_plan.detection].T_world_part
    return tcp(tree, tree.rest, cell.arm(arm_plan.arm), q_grasp).actInv(T_world_part)


def put_at(cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan) -> pin.SE3:
    """`T_world_part` where the hand lets go of the part, whatever the plan states."""
    q_place = np.asarray(arm_plan.leg("place").q[-1])
    T_world_tcp = tcp(tree, tree.rest, cell.arm(arm_plan.arm), q_place)
    return T_world_tcp * in_hand(cell, tree, plan, arm_plan)


def stages_of(
    cell: Cell, tree: Tree, step: MovingStep, arm_motion: MovingArm, cleared_at: int
) -> Iterator[LegStage]:
    """The stages of one leg.

    Args:
        cell: as it is.
        tree: of its robot.
        step: that the leg belongs to.
        arm_motion: the leg.
        cleared_at: on the way home, the waypoint from which on the hand has left the part.
    """
    name, now = arm_motion.leg.name, situation_of(tree, step, arm_motion)
    sets = _way_of(cell, tree, arm_motion)
    if name == "extract":
        first, rest = _cut(sets, *_find_release(tree, step, arm_motion, cell.policy.release))
        yield LegStage(first, now, comes_off=True)
        yield LegStage(rest, now)
    elif name == "home":
        has_cleared = np.arange(len(arm_motion.path)) >= cleared_at
        yield LegStage(sets.after(~has_cleared), now, leaves=True)
        yield LegStage(sets.after(has_cleared), now)
    else:
        yield LegStage(sets, now, rises=name == "lift")
    if name in ("approach", "place") and arm_motion.arm.tool.fingers:
        fingers = np.zeros(tree.model.nq, bool)
        fingers[tree.columns[arm_motion.arm.name][len(arm_motion.arm.joints) :]] = True
        fingers_move = replace(now, moves=fingers, fingers_move_at=arm_motion.plan.detection)
        yield LegStage(fingers_of(tree, arm_motion), fingers_move)


def situation_of(tree: Tree, step: MovingStep, *ones: MovingArm) -> Situation:
    """What is true while arms are on their legs; what only one leg allows, for one arm alone."""
    moves = np.zeros(tree.model.nq, bool)
    for arm_motion in ones:
        moves[tree.columns[arm_motion.arm.name][: len(arm_motion.arm.joints)]] = True
    now = Situation(
        moves,
        {number: plan.arm for number, plan in step.held.items()},
        {number: plan.arm for number, plan in step.placed.items()},
    )
    if len(ones) != 1:
        return now
    (arm_motion,) = ones
    return replace(
        now,
        near_arm=arm_motion.arm.name if arm_motion.leg.name in NEAR_MARGIN_LEGS else "",
        target=arm_motion.plan.detection if arm_motion.leg.name == "approach" else -1,
        placed_now=_placed_now(arm_motion),
        stirs=arm_motion.arm.name if arm_motion.leg.name in ("stir", "lift") else "",
        slot=_fixtures_at_slot(arm_motion) if arm_motion.leg.name in SLOT_LEGS else frozenset(),
    )


def _placed_now(arm_motion: MovingArm) -> int:
    """The detection that an arm brings to its seat; -1 on other legs, and over a station."""
    is_seating = arm_motion.leg.name == "place" and not arm_motion.plan.station
    return arm_motion.plan.detection if is_seating else -1


def _fixtures_at_slot(arm_motion: MovingArm) -> frozenset[str]:
    """What an arm may touch at the slot of the tool that the plan of its stretch names."""
    arm, tool = arm_motion.arm, arm_motion.plan.tool
    holds = {slot.fixture for slot in arm.tool_slots if slot.tool == tool and slot.fixture}
    return frozenset({standing_name(arm, tool), *holds})


def course_of(cell: Cell, tree: Tree, arm_motion: MovingArm) -> Sets:
    """All configurations of a leg, fingers included, for what does not depend on its stages."""
    sets = _way_of(cell, tree, arm_motion)
    if arm_motion.fingers_after == arm_motion.leg.opening:
        return sets
    return sets.with_others(fingers_of(tree, arm_motion))


def _way_of(cell: Cell, tree: Tree, arm_motion: MovingArm) -> Sets:
    """The way of a leg; before the first one the fingers may be anywhere in their stroke."""
    columns, arm = tree.columns[arm_motion.arm.name], arm_motion.arm
    sets = sweep_path(columns, arm_motion.path, cell.controller.motion, cell.policy.zone)
    if arm_motion.leg.name not in FIRST_LEGS or not arm.tool.fingers:
        return sets
    closed, wide = (_whole(arm, arm_motion.leg.q[0], opening) for opening in arm.tool.stroke)
    return sets.with_others(sweep_change(columns, closed, wide, 0))


def waiting_fingers(tree: Tree, step: MovingStep) -> tuple[Sets, ...]:
    """Where fingers may be of arms that have not moved yet: anywhere in their stroke.

    The last plan left them open, or a person moved them.  One block of sets, or none.
    """
    some = [arm for arm in step.waiting if arm.tool.fingers]
    if not some:
        return ()
    columns = np.concatenate([tree.columns[arm.name][len(arm.joints) :] for arm in some])
    counts = [len(arm.tool.fingers) for arm in some]
    closed, wide = np.repeat([arm.tool.stroke for arm in some], counts, axis=0).T / 2
    return (sweep_change(columns, closed, wide, 0),)


def fingers_of(tree: Tree, arm_motion: MovingArm) -> Sets:
    """The way of the fingers when a leg has ended."""
    after = _whole(arm_motion.arm, arm_motion.leg.q[-1], arm_motion.fingers_after)
    return sweep_change(
        tree.columns[arm_motion.arm.name], arm_motion.path[-1], after, len(arm_motion.path) - 2
    )


def path_at(arm_motion: MovingArm, times: Floats) -> Floats:
    """Where an arm is (k, n) [rad, m] at times (k,) [s] of its leg, and after it."""
    return np.stack(
        [np.interp(times, arm_motion.leg.t, column) for column in arm_motion.path.T], axis=1
    )


def _find_release(
    tree: Tree, step: MovingStep, arm_motion: MovingArm, least: float
) -> tuple[int, Floats]:
    """The segment in which a lifted part has come `least` [m] far, and where in it (n,)."""
    places = np.array(
        [tcp(tree, step.base, arm_motion.arm, q).translation for q in arm_motion.path]
    )
    far = np.linalg.norm(places - places[0], axis=1)
    beyond = np.flatnonzero(far >= least)
    if len(beyond) == 0:
        return len(arm_motion.path) - 1, arm_motion.path[-1]
    k = int(beyond[0]) - 1
    share = (least - far[k]) / (far[k + 1] - far[k])
    return k, arm_motion.path[k] + share * (arm_motion.path[k + 1] - arm_motion.path[k])


def _cut(sets: Sets, segment: int, q: Floats) -> tuple[Sets, Sets]:
    """Sets of a leg up to a configuration (n,) in one of its segments, and from there on."""
    is_later = np.arange(len(sets.at)) >= segment
    before, after = sets.after(~is_later), sets.after(is_later)
    if len(after.at):
        corners = after.corners.copy()
        start = corners[0, 0].copy()
        corners[0, 0] = q
        after = replace(after, corners=corners)
        before = before.with_others(sweep_change(sets.columns, start, q, segment))
    return before, after


def tcp(tree: Tree, base: Floats, arm: Arm, values: Floats) -> pin.SE3:
    """`T_world_tcp` of an arm at its joints, followed or not by its fingers (n,) [rad, m]."""
    q = base.copy()
    q[tree.columns[arm.name][: len(values)]] = values
    pin.forwardKinematics(tree.model, tree.data, q)
    joint, T_joint_flange = tree.flange(arm)
    return tree.data.oMi[joint] * T_joint_flange * arm.tool.T_flange_tcp


def _moving(cell: Cell, plan: ArmPlan, name: LegName) -> MovingArm:
    arm, leg = cell.arm(plan.arm), plan.leg(name)
    after = leg.opening
    if name == "approach":
        after = plan.leg("extract").opening
    elif name == "place":
        after = plan.leg("home").opening
    path = np.stack([_whole(arm, q, leg.opening) for q in leg.q])
    return MovingArm(plan, arm, leg, path, after)


def _whole(arm: Arm, q: Floats, opening: float) -> Floats:
    """The joints (n,) of an arm followed by its fingers: each has half of the opening [m]."""
    return np.concatenate([q, np.full(len(arm.tool.fingers), opening / 2)])

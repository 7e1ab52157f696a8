"""Whether a plan is still valid: its threshold, its pallets, and the robot at its start."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.app.core.state import State
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
from workbench.model.plan import Plan
from workbench.model.tools.held_body import HeldAmount, with_held

LEAST_MOVED = 0.001
"""[m] Allowed distance of the robot from the start of a plan without a margin, for rounding."""


SAME_THRESHOLD = 0.0005
"""[m] Thresholds are typed in whole millimetres."""


def stale_because(state: State, plan: Plan, joints: Mapping[str, float]) -> Message | None:
    """Why a plan is no longer valid; None while it is valid.

    A new scan or cell is not checked here: it has already removed the plan.
    """
    return (
        other_threshold(state) or other_pallets(state, plan) or moved_away(state.cell, plan, joints)
    )


def other_pallets(state: State, plan: Plan) -> Message | None:
    """Why a pallet differs from the plan's; None when all parts of the plan's pallets are there."""
    for box in plan.obstacles:
        T = box.T_world_put
        if T is not None and not any(
            detection.part == box.part
            and detection.score > 0
            and detection.T_world_part.isApprox(T, 1e-6)
            for detection in state.placed
        ):
            return Refusal.PALLET_CHANGED()
    return None


def other_threshold(state: State) -> Message | None:
    """Why the wanted threshold differs from that of the plan; None when it does not."""
    planned, wanted = state.planned_threshold, state.wanted_threshold
    if planned is None or wanted is None or abs(planned - wanted) < SAME_THRESHOLD:
        return None
    return Refusal.OTHER_THRESHOLD(planned=planned, wanted=wanted)


def moved_away(cell: Cell, plan: Plan, joints: Mapping[str, float]) -> Message | None:
    """Why the robot is not at the start of the plan; None when it is.

    No point of an arm may be further from its start than the policy's margin.  The start keeps this
    margin to everything, so the robot touches nothing on the way there.  For a plan that begins by
    lifting a held part, `near_margin` counts, and the held part, too.  Joints without a report are
    not compared.  A robot that gets only poses moves by its own program, from anywhere.

    Args:
        cell: the cell; arms without a part in the plan must be at home.
        plan: the plan to be sent.
        joints: reported positions, name -> [rad].
    """
    if cell.controller.motion.sends_poses:
        return None
    if plan.is_drop_plan:
        cell = _as_it_starts(cell, plan)
    for arm in cell.arms:
        off = shift_of(cell, arm, start_of(cell, plan, arm.name), joints)
        if not math.isfinite(off.worst):
            return Refusal.JOINT_UNKNOWN(axis=off.axis, arm=arm.name, value=str(off.worst))
        if off.shift > off.allowed:
            return Refusal.ROBOT_MOVED(
                axis=off.axis, arm=arm.name, off=off.worst, away=off.shift, allowed=off.allowed
            )
    return None


@lru_cache(maxsize=4)
def _as_it_starts(cell: Cell, plan: Plan) -> Cell:
    """The cell with what a hand may hold, and the margins at the start of a plan."""
    arm_plan = plan.arms[0]
    if arm_plan.held not in set(HeldAmount):
        return cell
    holding = with_held(cell, arm_plan.arm, HeldAmount(arm_plan.held))
    if all(leg.name != "lift" for leg in arm_plan.legs):
        return holding
    near = min(cell.policy.near_margin, cell.policy.margin)
    return replace(holding, policy=replace(cell.policy, margin=near))


class Shift(NamedTuple):
    """Bound [m] for the distance of an arm's points from their places, and the allowed distance.

    `worst` [rad, m] is the largest error of an axis, `axis` its number from 1.  If the report of a
    joint is not a number, `worst` is that value.
    """

    shift: float
    allowed: float
    worst: float
    axis: int


def shift_of(cell: Cell, arm: Arm, q: Floats, joints: Mapping[str, float]) -> Shift:
    """The distance of an arm from `q` (n,) [rad, m]; joints without a report do not count.

    Args:
        cell: the cell of the arm.
        arm: the arm.
        q: its expected configuration, chain order.
        joints: reported positions, name -> [rad, m].
    """
    allowed, levers = max(cell.policy.margin, LEAST_MOVED), _levers(cell, arm)
    shift, worst, worst_axis = 0.0, 0.0, 0
    for axis, place in enumerate(arm.axis_order):
        reported = joints.get(arm.joints[place])
        if reported is None:
            continue
        if not math.isfinite(reported):
            return Shift(math.inf, allowed, reported, axis + 1)
        off = float(abs(reported - q[place]))
        shift += off * levers[place]
        if off > worst:
            worst, worst_axis = off, axis + 1
    return Shift(shift, allowed, worst, worst_axis)


@lru_cache(maxsize=16)
def _levers(cell: Cell, arm: Arm) -> tuple[float, ...]:
    """Largest motion of any point by each joint of an arm, in chain order [m/rad, m/m]."""
    tools = {other.flange: other.tool.reach for other in cell.arms}
    if (carrier := cell.scanner.on_arm) is not None:
        flange = cell.arm(carrier.arm).flange
        tools[flange] = max(tools[flange], carrier.reach)
    joints = [cell.robot.joint(name) for name in arm.joints]
    return tuple(
        1.0 if joint.kind == "prismatic" else cell.robot.reach(joint.child, tools)
        for joint in joints
    )


def start_of(cell: Cell, plan: Plan, arm: str) -> Floats:
    """The configuration (n,) [rad] of an arm at the start of the plan."""
    for step in plan.sequence:
        for name, leg in step.runs:
            if name == arm:
                return np.asarray(plan.arm(arm).leg(leg).q[0])
    return cell.arm(arm).home


def left_on_station(plans: Sequence[Plan]) -> Message | None:
    """Why plans are not a complete row: a part would stay on a station; None when none does."""
    for number, plan in enumerate(plans):
        after = plans[number + 1] if number + 1 < len(plans) else None
        taken = [] if after is None else [after.detections[arm.detection] for arm in after.picks]
        if plan.stations and sum(detection.T_world_found is not None for detection in taken) < len(
            plan.stations
        ):
            return Refusal.LEFT_ON_STATION(plan=number + 1, station=plan.stations[0])
    return None


def lacks_reports(state: State) -> Message | None:
    """Why the robot's pose between two plans of the row would be unknown; else None."""
    motion = state.cell.controller.motion
    if not state.row or motion.reports_progress:
        return None
    return Refusal.ROW_NEEDS_REPORTS(link=motion.link)

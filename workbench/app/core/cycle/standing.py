"""Whether a plan still stands: its threshold, its pallets, and the robot where it starts."""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from workbench.app.core.state import State
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.plan import Plan

LEAST_MOVED = 0.001
"""[m] So far the robot may be from where a plan starts also where no margin is kept: it rounds."""


SAME_THRESHOLD = 0.0005
"""[m] Thresholds are typed in whole millimetres."""


def stale_because(state: State, plan: Plan, joints: Mapping[str, float]) -> str:
    """What has made a plan stale, and by how much; empty when it still stands.

    Another scan or cell is not looked for: with that the plan would be gone.
    """
    return (
        other_threshold(state) or other_pallets(state, plan) or moved_away(state.cell, plan, joints)
    )


def other_pallets(state: State, plan: Plan) -> str:
    """Why a pallet is not as a plan counts on; empty when every part that it knows lies there."""
    for box in plan.obstacles:
        T = box.T_world_put
        if T is not None and not any(
            detection.part == box.part
            and detection.score > 0
            and detection.T_world_part.isApprox(T, 1e-6)
            for detection in state.placed
        ):
            return (
                "a part that the plan counts on does not lie on the pallet any more, or nobody "
                "knows whether it does; make a new plan"
            )
    return ""


def other_threshold(state: State) -> str:
    """Why the threshold wanted is no longer that of the plan; empty when it is."""
    planned, wanted = state.planned_threshold, state.wanted_threshold
    if planned is None or wanted is None or abs(planned - wanted) < SAME_THRESHOLD:
        return ""
    return (
        f"the plan was made with a threshold of {planned * 1000:.0f} mm, "
        f"now it is {wanted * 1000:.0f} mm; make a new plan"
    )


def moved_away(cell: Cell, plan: Plan, joints: Mapping[str, float]) -> str:
    """By how much the robot does not stand where the plan starts; empty when it does.

    No point of an arm may be further from there than the policy's margin, which the plan's start
    keeps to everything: on its way there the robot touches nothing.  Joints that are not reported
    are not compared.

    Args:
        cell: whose arms; those without a part in the plan have to be at home.
        plan: that would be sent.
        joints: name -> [rad], as the controller reports.
    """
    allowed = max(cell.policy.margin, LEAST_MOVED)
    for arm in cell.arms:
        q, levers = start_of(cell, plan, arm.name), _levers(cell, arm)
        shift, worst, where = 0.0, 0.0, ""
        for axis, place in enumerate(arm.axis_order):
            reported = joints.get(arm.joints[place])
            if reported is None:
                continue
            name = f"axis {axis + 1} of the {arm.name} arm"
            if not math.isfinite(reported):
                return f"nobody knows where the robot stands: {name} is reported at {reported}"
            off = float(abs(reported - q[place]))
            shift += off * levers[place]
            if off > worst:
                worst, where = off, name
        if shift > allowed:
            return (
                f"the robot has moved: {where} stands {np.rad2deg(worst):.2f} degrees from where "
                f"the plan starts, so that a point of the arm may be {shift * 1000:.1f} mm away; "
                f"{allowed * 1000:g} are allowed (margin_mm); bring it back"
            )
    return ""


@lru_cache(maxsize=16)
def _levers(cell: Cell, arm: Arm) -> tuple[float, ...]:
    """How far each joint of an arm, in chain order, moves any point at most [m/rad, m/m]."""
    tools = {other.flange: other.tool.reach for other in cell.arms}
    joints = [cell.robot.joint(name) for name in arm.joints]
    return tuple(
        1.0 if joint.kind == "prismatic" else cell.robot.reach(joint.child, tools)
        for joint in joints
    )


def start_of(cell: Cell, plan: Plan, arm: str) -> Floats:
    """The configuration (n,) [rad] in which an arm has to stand when the plan begins."""
    for step in plan.sequence:
        for name, leg in step.runs:
            if name == arm:
                return np.asarray(plan.arm(arm).leg(leg).q[0])
    return cell.arm(arm).home


def left_on_station(plans: Sequence[Plan]) -> str:
    """Why plans are no whole row, as a part would stay on a station; empty when none does."""
    for number, plan in enumerate(plans):
        after = plans[number + 1] if number + 1 < len(plans) else None
        taken = [] if after is None else [after.detections[arm.detection] for arm in after.arms]
        if plan.stations and sum(detection.T_world_found is not None for detection in taken) < len(
            plan.stations
        ):
            return (
                f"plan {number + 1} puts a part on station {plan.stations[0]}, and no plan that "
                "follows takes it from there"
            )
    return ""


def lacks_reports(state: State) -> str:
    """Why nobody could know, between two plans of the row, how it stands; else empty."""
    motion = state.cell.controller.motion
    if not state.row or motion.reports_progress:
        return ""
    return (
        f"the robot link {motion.link} does not tell what became of each part, so one plan can be "
        "sent at a time; shorten the row to one plan"
    )

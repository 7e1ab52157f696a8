"""The proof: a second look at a finished plan, on exactly what will be sent.

It builds its own world from the cell and the plan, takes nothing from the planner, and walks
the curves that the controller may follow (`motion`).  What it finds against the plan is
listed; a plan is approved only when there is nothing.
"""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.plan import LEG_NAMES, ArmPlan, Finding, Guarantee, Leg, LegName, Plan, Proof
from workbench.planning.collision.legs import (
    HOLDING,
    STRAIGHT,
    grips,
    hand_turns,
    may_open,
    stretches,
)
from workbench.planning.collision.motion import RESOLUTION
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.proving.walk import walk

IN_HAND_DISTANCE, IN_HAND_ANGLE = 0.001, np.deg2rad(1.0)
"""[m, rad] How far the part in the hand may be from where the detection and the grasp put it, and
the hand from the place."""

SAME = 1e-9
"""[rad] Where configurations travel as they are, so far one leg may begin from the end of another.
"""

SIGHT = 0.1
"""[m] Clearances are measured up to here."""

FAR_SIGHT = 0.4
"""[m] Distances between the arms are measured up to here."""


def prove(cell: Cell, plan: Plan, *, resolution: float = RESOLUTION) -> Proof:
    """Check everything that can be checked about a plan without asking who made it.

    Args:
        cell: the cell as it is now.
        plan: as planned, or as read from a file.
        resolution: [m] see `motion`; smaller is slower and never admits more.

    Returns:
        A proof; `holds` is True when there is no finding.
    """
    findings = list(form_findings(cell, plan))
    can_walk = not findings
    if can_walk:
        findings = [
            finding
            for arm_plan in plan.arms
            for leg in arm_plan.legs
            for finding in _leg_values(cell, cell.arm(arm_plan.arm), leg)
        ]
    clearances: list[tuple[str, str, Floats]] = []
    apart: list[tuple[str, str, Floats]] = []
    nearest: Finding | None = None
    clearance, checks = SIGHT, 0
    if can_walk:
        world = World(cell, plan.detections, plan.obstacles, by_coal=True)
        for stretch in stretches(plan):
            walked = walk(world, stretch, plan.guarantee, resolution, SIGHT, FAR_SIGHT)
            if walked.finding is not None:
                findings.append(walked.finding)
            clearances += walked.clearances
            apart += walked.apart
            closest = walked.closest
            if closest is None or closest.distance is None or closest.leg in STRAIGHT:
                continue
            if closest.distance < clearance:
                clearance, nearest = closest.distance, closest
        checks = world.checks
    return Proof(
        plan_digest=plan.digest,
        cell_digest=cell.digest,
        scan_digest=plan.scan_digest,
        checks=checks,
        resolution=resolution,
        zone=cell.zone,
        clearance=clearance,
        nearest=nearest,
        findings=tuple(findings),
        clearances=tuple(clearances),
        apart=tuple(apart),
    )


def form_findings(cell: Cell, plan: Plan) -> Iterator[Finding]:
    """What must be right before the plan can be walked through at all."""
    if plan.cell_digest != cell.digest:
        yield Finding("the plan was made for another cell, or the cell has changed since")
        return
    taken = [arm.detection for arm in plan.arms]
    names = [arm.arm for arm in plan.arms]
    known = {arm.name for arm in cell.arms}
    parts = {part.name for part in cell.parts}
    if not plan.arms:
        yield Finding("the plan moves no arm")
    if len(set(taken)) != len(taken) or len(set(names)) != len(names):
        yield Finding("an arm or a part is used twice")
    for detection in plan.detections:
        if detection.part not in parts:
            yield Finding(f"the cell knows no part {detection.part!r}")
            return
    for arm_plan in plan.arms:
        if arm_plan.arm not in known:
            yield Finding(f"the cell has no arm {arm_plan.arm!r}")
        elif not 0 <= arm_plan.detection < len(plan.detections):
            yield Finding(f"there is no detection {arm_plan.detection}", arm_plan.arm)
        else:
            yield from _arm_form(cell, plan, arm_plan)
    yield from _sequence(plan)


def _sequence(plan: Plan) -> Iterator[Finding]:
    runs = [run for step in plan.sequence for run in step.runs]
    for arm in plan.arms:
        if [leg for name, leg in runs if name == arm.arm] != [leg.name for leg in arm.legs]:
            yield Finding("the sequence is not every leg once, in order", arm.arm)
    if any(name not in {arm.arm for arm in plan.arms} for name, _ in runs):
        yield Finding("the sequence moves an arm that the plan does not")
    for step in plan.sequence:
        if not step.runs:
            yield Finding("a step of the sequence moves no arm")
        if len({name for name, _ in step.runs}) != len(step.runs) or len(step.runs) > 2:
            yield Finding("a step of the sequence moves an arm twice, or more than two arms")
    if plan.guarantee is Guarantee.ONE_AT_A_TIME and (
        any(len(step.runs) != 1 for step in plan.sequence)
        or [name for name, _ in runs] != [arm.arm for arm in plan.arms for _ in arm.legs]
    ):
        yield Finding("the sequence does not move one arm after the other")


def _arm_form(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> Iterator[Finding]:
    arm, name = cell.arm(arm_plan.arm), arm_plan.arm
    if arm_plan.joints != arm.joints:
        yield Finding(f"joints are {arm_plan.joints}, those of the arm {arm.joints}", name)
        return
    if tuple(leg.name for leg in arm_plan.legs) != LEG_NAMES:
        yield Finding(f"the legs are not {', '.join(LEG_NAMES)}", name)
        return
    shapes = [finding for leg in arm_plan.legs for finding in _leg_shape(arm, leg)]
    if shapes:
        yield from shapes
        return
    ends = [arm.home, *(leg.q[-1] for leg in arm_plan.legs)]
    starts = [*(leg.q[0] for leg in arm_plan.legs), arm.home]
    same = max(cell.controller.motion.quantum, SAME)
    for leg_name, end, start in zip((*LEG_NAMES, "home"), ends, starts, strict=True):
        if np.shape(end) != np.shape(start) or np.abs(end - start).max() > same:
            yield Finding("does not start where the arm stands", name, leg_name)
            return
    T_world_part = plan.detections[arm_plan.detection].T_world_part
    grasps = {g.name: g for g in cell.part(plan.detections[arm_plan.detection].part).grasps}
    grasp = grasps.get(arm_plan.grasp)
    if grasp is None:
        yield Finding(f"the part has no grasp {arm_plan.grasp!r}", name)
        return
    T_tcp_grasp = arm_plan.T_tcp_part * grasp.T_part_tcp
    if not any(_same(T_tcp_grasp, T_tcp_hand.inverse()) for T_tcp_hand in grips(arm, grasp)):
        yield Finding(f"the part is not in the hand as grasp {grasp.name} takes it", name)
    for leg in arm_plan.legs:
        is_holding = leg.name in HOLDING
        if not is_holding and may_open(arm, grasp, leg.opening, cell.policy.least_air):
            continue
        wanted = grasp.grip if is_holding else grasp.opening
        if abs(leg.opening - wanted) > 1e-6:
            problem = f"fingers at {leg.opening * 1e3:.1f} mm, the grasp says {wanted * 1e3:.1f} mm"
            yield Finding(problem, name, leg.name)
    chain = chain_of(cell, arm)
    T_world_tcp = chain.pose(np.asarray(arm_plan.leg("approach").q[-1]))
    if not _same(T_world_tcp * arm_plan.T_tcp_part, T_world_part):
        yield Finding("the part is not where the hand closes", name, "approach")
    T_world_end = chain.pose(np.asarray(arm_plan.leg("place").q[-1]))
    places = (T * turn for T in arm.Ts_world_place for turn in hand_turns(arm))
    if not any(_same(T_world_end, T_world_place) for T_world_place in places):
        yield Finding("the hand opens where the arm has no place", name, "place")


def _same(T: pin.SE3, other: pin.SE3) -> bool:
    """Whether two poses agree as far as a hand has to."""
    difference = T.actInv(other)
    off = float(np.linalg.norm(difference.translation))
    turn = float(np.linalg.norm(pin.log3(difference.rotation)))
    return off <= IN_HAND_DISTANCE and turn <= IN_HAND_ANGLE


def _leg_shape(arm: Arm, leg: Leg) -> Iterator[Finding]:
    q, t = np.asarray(leg.q), np.asarray(leg.t)
    if q.ndim != 2 or q.shape[1] != len(arm.joints) or t.shape != (len(q),) or len(q) < 2:
        problem = f"has waypoints of shape {q.shape} and times of shape {t.shape}"
        yield Finding(problem, arm.name, leg.name)
    elif not (np.all(np.isfinite(q)) and np.all(np.isfinite(t))):
        yield Finding("holds a value that is not a finite number", arm.name, leg.name)


def _leg_values(cell: Cell, arm: Arm, leg: Leg) -> Iterator[Finding]:
    """What is wrong with a leg's values, whatever stands around the robot."""
    name: LegName = leg.name
    lower, upper, velocity = cell.robot.limits(arm.joints)
    q, t = np.asarray(leg.q), np.asarray(leg.t)
    outside = np.argwhere((q < lower - 1e-9) | (q > upper + 1e-9))
    if len(outside):
        row, joint = outside[0]
        yield Finding(
            f"joint {arm.joints[joint]} at {np.rad2deg(q[row, joint]):.2f} deg is outside "
            f"{np.rad2deg(lower[joint]):.2f} to {np.rad2deg(upper[joint]):.2f} deg",
            arm.name,
            name,
            int(row),
        )
    if not cell.controller.motion.is_sendable(q):
        yield Finding("holds a configuration finer than what can be sent", arm.name, name)
    low, high = arm.tool.stroke
    if arm.tool.fingers and not low <= leg.opening <= high:
        yield Finding(
            f"finger opening {leg.opening * 1e3:.1f} mm is outside the stroke", arm.name, name
        )
    if leg.holding != (name in HOLDING):
        yield Finding("says wrongly whether the part is in the hand", arm.name, name)
    if np.any(np.diff(t) <= 0):
        yield Finding("has times that do not increase", arm.name, name)
    # A rounded corner is shorter than its waypoints make it look, never by more than its zone.
    elif np.any(
        np.abs(np.diff(q, axis=0)) / np.diff(t)[:, None] > velocity * 1.001 / (1.0 - cell.zone)
    ):
        yield Finding("is faster than the joints may turn", arm.name, name)

"""Whether an arm takes its part by a grasp of the cell, as authored, and puts it at a place."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.derived.assembling import assembled_kinds
from workbench.model.derived.policies import LEAST_AIR
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.messages.message import Message
from workbench.model.messages.proofs import ProofText
from workbench.model.part import Grasp, Part
from workbench.model.plan import ArmPlan, Leg, Plan, Violation
from workbench.proof.claims.form import HOLDING
from workbench.proof.claims.grasps.straight import part_reach, straight_violations
from workbench.proof.claims.places.assembled import assembly_violations
from workbench.proof.claims.places.placed_poses import lying_violations
from workbench.proof.claims.places.standing import standing_violations
from workbench.proof.claims.stages import in_hand, tcp
from workbench.proof.claims.tolerances import (
    GRASPED,
    OPENING,
    PLACED,
    STATED,
    displacement,
)
from workbench.proof.engine.robot import Tree


def grasp_violations(cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Check regions, permission, openings, grasp pose, straight legs and place of one arm."""
    arm, part = cell.arm(arm_plan.arm), cell.part(plan.detections[arm_plan.detection].part)
    grasp = _grasp_of(part, arm_plan)
    if grasp is None:
        yield Violation(ProofText.NO_GRASP(grasp=arm_plan.grasp), arm.name)
        return
    found = plan.detections[arm_plan.detection]
    if found.T_world_found is None and not cell.bin.gives(part, found.T_world_part):
        yield Violation(ProofText.OUTSIDE_REGIONS(), arm.name)
    yield from _check_permission(arm, grasp)
    yield from _openings(cell, arm, part, grasp, arm_plan)
    points, T_tcp_part = np.asarray(part.mesh.points), in_hand(cell, tree, plan, arm_plan)
    if displacement(points, arm_plan.T_tcp_part, T_tcp_part) > STATED:
        yield Violation(ProofText.NOT_AT_HAND(), arm.name, "approach")
    if not _takes(arm, grasp, points, T_tcp_part):
        yield Violation(ProofText.NOT_IN_HAND(grasp=grasp.name), arm.name)
    turn = found.T_world_part.rotation @ grasp.T_part_tcp.rotation
    ways = {
        "approach": turn @ grasp.approach * grasp.approach_length,
        "extract": None,
        "place": None,
    }
    if grasp.retreat is not None:
        ways["extract"] = turn @ grasp.retreat * grasp.retreat_length
    reach = part_reach(cell, tree, plan, arm_plan)
    for name, way in ways.items():
        q = np.asarray(arm_plan.leg(name).q)
        yield from straight_violations(tree, arm, name, q, way, reach=reach)
    if arm_plan.station:
        yield from standing_violations(cell, tree, plan, arm_plan)
    elif found.part in assembled_kinds(cell):
        yield from assembly_violations(cell, tree, plan, arm_plan)
    else:
        yield from _place_violations(cell, tree, plan, arm_plan, T_tcp_part)


def _grasp_of(part: Part, arm_plan: ArmPlan) -> Grasp | None:
    """By what a plan takes a part: its library's grasp, or the grip found where that permits it.

    Whether a found grip holds is asked by `rolls.roll_violations`.
    """
    found = arm_plan.found
    if found is None:
        return next((g for g in part.grasps if g.name == arm_plan.grasp), None)
    if not part.library.searches:
        return None
    return Grasp(arm_plan.grasp, found.T_part_tcp, found.opening, found.grip)


def _check_permission(arm: Arm, grasp: Grasp) -> Iterator[Violation]:
    """Whether an arm may use a grasp at all."""
    if not grasp.is_enabled:
        yield Violation(ProofText.GRASP_DISABLED(grasp=grasp.name), arm.name)
    if grasp.arms and arm.name not in grasp.arms:
        yield Violation(ProofText.GRASP_FOR_ARMS(grasp=grasp.name, arms=grasp.arms), arm.name)
    if grasp.tool and grasp.tool != arm.tool.name:
        yield Violation(ProofText.GRASP_FOR_TOOL(grasp=grasp.name, tool=grasp.tool), arm.name)
    if grasp.tcp and grasp.tcp != arm.tool.tcp:
        yield Violation(ProofText.GRASP_FOR_TCP(grasp=grasp.name, tcp=grasp.tcp), arm.name)


def _openings(
    cell: Cell, arm: Arm, part: Part, grasp: Grasp, arm_plan: ArmPlan
) -> Iterator[Violation]:
    """Whether the fingers are open as the grasp states, on every leg."""
    least = _least_opening(cell, arm, part, grasp)
    for leg in arm_plan.legs:
        if leg.name in HOLDING and abs(leg.opening - grasp.grip) > OPENING:
            yield Violation(_opening(leg, grasp.grip), arm.name, leg.name)
        elif leg.name not in HOLDING and not (
            least - OPENING <= leg.opening <= grasp.opening + OPENING
        ):
            yield Violation(_opening(leg, grasp.opening), arm.name, leg.name)
    if abs(arm_plan.leg("reach").opening - arm_plan.leg("approach").opening) > OPENING:
        # Nothing is looked at between two legs.
        yield Violation(ProofText.OPENING_CHANGES(), arm.name, "approach")


def _place_violations(
    cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan, T_tcp_part: pin.SE3
) -> Iterator[Violation]:
    """Whether the hand lets go at a place of the arm, by the hand's pose or by the part's."""
    arm, found = cell.arm(arm_plan.arm), plan.detections[arm_plan.detection]
    part, q = cell.part(found.part), np.asarray(arm_plan.leg("place").q)
    T_put = tcp(tree, tree.rest, arm, q[-1])
    in_tcp = _act(T_tcp_part, np.asarray(part.mesh.points))
    places = (T * half for T in arm.Ts_world_place for half in _halves(arm))
    if not any(displacement(in_tcp, T_put, T) <= PLACED for T in places):
        came = T_put.translation - tcp(tree, tree.rest, arm, q[0]).translation
        yield from lying_violations(arm, part, found, T_put * T_tcp_part, came)


def pair_violations(cell: Cell, plan: Plan) -> Iterator[Violation]:
    """Whether two arms may take parts of one kind by these two grasps, in this order."""
    for number, first in enumerate(plan.arms):
        for second in plan.arms[number + 1 :]:
            kinds = [plan.detections[arm_plan.detection].part for arm_plan in (first, second)]
            library = cell.part(kinds[0]).library
            if kinds[0] == kinds[1] and not library.allows(first.grasp, second.grasp):
                yield Violation(ProofText.NO_PAIR(first=first.grasp, second=second.grasp))


def _opening(leg: Leg, wanted: float) -> Message:
    return ProofText.OPENING(opening=leg.opening, wanted=wanted)


def _least_opening(cell: Cell, arm: Arm, part: Part, grasp: Grasp) -> float:
    """How far open [m] fingers arrive at least: as the grasp states, or less by the policy."""
    air = cell.policy.least_air
    if air is None and cell.policy.as_needed:
        air = LEAST_AIR
    if air is None or not arm.tool.fingers:
        return grasp.opening
    return min(grasp.opening, grasp.grip + 2 * (air + (part.tolerance or 0.0)))


def _halves(arm: Arm) -> tuple[pin.SE3, ...]:
    """Turns of a hand that change nothing: two fingers can change places."""
    half = pose_from_rpy((0, 0, 0), (0, 0, np.pi))
    return (pin.SE3.Identity(), half) if len(arm.tool.fingers) == 2 else (pin.SE3.Identity(),)


def _takes(arm: Arm, grasp: Grasp, points: Floats, T_tcp_part: pin.SE3) -> bool:
    """Whether a hand takes a part, of points (n, 3) [m], as its grasp states.

    The grasp permits T_part_tcp = T_grasp * slide(x) * tilt(y) * turn(z), each within its range.
    """
    for half in _halves(arm):
        off = grasp.T_part_tcp.actInv((half.actInv(T_tcp_part)).inverse())
        R = off.rotation
        slide = np.clip(off.translation[0], -grasp.slide, grasp.slide)
        tilt = np.clip(np.arctan2(R[0, 2], R[2, 2]), -grasp.tilt, grasp.tilt)
        turn = np.arctan2(R[1, 0], R[1, 1])
        turn = np.clip(turn, -grasp.free_rotation, grasp.free_rotation)
        tilted = pose_from_rpy((slide, 0.0, 0.0), (0.0, tilt, 0.0))
        permitted = grasp.T_part_tcp * tilted * pose_from_rpy((0, 0, 0), (0.0, 0.0, turn)) * half
        if displacement(points, T_tcp_part, permitted.inverse()) <= GRASPED:
            return True
    return False


def _act(T: pin.SE3, points: Floats) -> Floats:
    return points @ T.rotation.T + T.translation

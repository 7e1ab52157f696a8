"""The proof: everything about a plan is checked anew, in the scene as it is known, or refused."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from workbench.model.cell import Cell
from workbench.model.messages.message import FoundPart
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import SpeedBound
from workbench.model.plan import Plan, Proof, Violation
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.proof.claims.form import (
    at_stated_tcps,
    form_violations,
    joint_limit_violations,
    opening_and_time_violations,
)
from workbench.proof.claims.grasps.at_slot import slot_violations
from workbench.proof.claims.grasps.dropped import held_violations
from workbench.proof.claims.grasps.loads import load_violations
from workbench.proof.claims.grasps.rolls import roll_violations
from workbench.proof.claims.grasps.taking import grasp_violations, pair_violations
from workbench.proof.claims.grasps.upright import upright_violations
from workbench.proof.claims.places.assembled import sight_violations
from workbench.proof.claims.places.layers import kept_box, pallet_violations
from workbench.proof.claims.places.standing import standing_after
from workbench.proof.claims.scene import filled_bin, turned_pieces
from workbench.proof.claims.stages import put_at
from workbench.proof.claims.timing.pace import pace_violations
from workbench.proof.claims.timing.point_speed import speed_claims
from workbench.proof.claims.tool_change import by_stretches
from workbench.proof.claims.walk import Walk, Walked
from workbench.proof.engine.robot import tree_of
from workbench.proof.engine.search import SIGHT
from workbench.proof.engine.shapes import gap_of

RESOLUTION = 0.0005
"""[m] Tolerance of a distance below its margin; see `search`."""


def prove(
    cell: Cell,
    scene: Scene,
    plan: Plan,
    *,
    resolution: float = RESOLUTION,
    stated: Proof | None = None,
) -> Proof:
    """Check a plan, whoever has made it.

    Structure and joint limits come first.  If one is violated, all other checks are left out, and
    the proof states no clearance.

    Args:
        cell: as it is now.
        scene: what is known to be in the bin; what the plan says of it is compared.
        plan: as planned, or as read from a file.
        resolution: [m] see `search`; smaller is slower and never admits more.
        stated: a proof of the same plan.  That a leg comes nearer than it states is a violation;
            how near it comes is not searched for, which takes less time.  The result repeats
            `clearance` and `nearest` of this proof, and leaves `apart` empty.

    Returns:
        A proof; `holds` is True when there is no violation.
    """
    violations = list(form_violations(cell, scene, plan))
    found: list[_Claims] = []
    if not violations:
        # Joints that turn a hundred times would be followed for hours.
        violations += [
            violation
            for arm_plan in plan.arms
            for leg in arm_plan.legs
            for violation in joint_limit_violations(cell, cell.arm(arm_plan.arm), leg)
        ]
    if not violations:
        stretches = [(at_stated_tcps(each, part), part) for each, part in by_stretches(cell, plan)]
        found = [_claims(each, scene, part, resolution, stated) for each, part in stretches]
        begins = at_stated_tcps(cell, plan)
        violations += [f for arm in plan.arms for f in load_violations(begins, plan, arm)]
        violations += [violation for claims in found for violation in claims.violations]
    nearest = min((claims.walked for claims in found), key=lambda w: w.clearance, default=None)
    return Proof(
        plan_digest=plan.digest,
        cell_digest=cell.digest,
        scan_digest=plan.scan_digest,
        checks=sum(claims.walked.looks for claims in found),
        resolution=resolution,
        zone=cell.zone,
        clearance=SIGHT if nearest is None else nearest.clearance,
        nearest=None if nearest is None else nearest.nearest,
        violations=tuple(violations),
        clearances=tuple(each for claims in found for each in claims.walked.clearances),
        apart=tuple(each for claims in found for each in claims.walked.apart),
        speeds=tuple(bound for claims in found for bound in claims.speeds),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Claims:
    """What was found on a stretch of a plan."""

    violations: tuple[Violation, ...]
    walked: Walked
    speeds: tuple[SpeedBound, ...]


def _claims(
    cell: Cell, scene: Scene, plan: Plan, resolution: float, stated: Proof | None
) -> _Claims:
    """What is found on a stretch of a plan whose form is right; see `prove`."""
    tree, picks = tree_of(cell), plan.picks
    legs = [(cell.arm(arm.arm), leg) for arm in plan.arms for leg in arm.legs]
    violations = [f for arm, leg in legs for f in opening_and_time_violations(cell, arm, leg)]
    too_fast = list(pace_violations(cell, plan))
    points_too_fast, speeds = speed_claims(cell, tree, plan)
    # Of joints that are too fast already, points are too.
    violations += too_fast or points_too_fast
    violations += slot_violations(cell, tree, plan)
    violations += held_violations(cell, tree, plan)
    violations += [f for pick in picks for f in grasp_violations(cell, tree, plan, pick)]
    violations += [f for pick in picks for f in sight_violations(cell, scene, plan, pick)]
    violations += [f for pick in picks for f in roll_violations(cell, tree, plan, pick)]
    violations += [f for pick in picks for f in upright_violations(cell, tree, plan, pick)]
    violations += pair_violations(cell, plan)
    violations += [f for pick in picks for f in pallet_violations(cell, tree, scene, plan, pick)]
    walked = Walk(cell, tree, plan, resolution, stated).result()
    return _Claims((*violations, *walked.violations), walked, speeds)


def scene_after(cell: Cell, plan: Plan) -> Scene:
    """What is in the bin and at the places once a proven plan was carried out.

    The parts taken are gone from the bin.  Each is in the way where the hand has let go of it,
    unless the arm passes parts on.  One that is put on a station is a part, which stands there.
    A plan that takes a scanner to its view takes none.
    A plan onto a station replaces all parts of the bin by one box if any of them may have moved
    (`may_have_moved`).  Any other plan keeps the remaining detections unchanged.

    Args:
        cell: as it is now.
        plan: in whose scene it holds that nothing moves but what is taken, or that puts a part on
            a station.
    """
    tree, taken = tree_of(cell), {arm_plan.detection for arm_plan in plan.picks}
    boxes: list[Obstacle] = []
    stand: list[Detection] = []
    for arm_plan in plan.picks:
        arm, found = cell.arm(arm_plan.arm), plan.detections[arm_plan.detection]
        if arm_plan.station:
            stand.append(standing_after(cell, tree, plan, arm_plan))
        elif not arm.passes_parts_on:
            known = (*plan.obstacles, *boxes)
            boxes.append(kept_box(cell, known, found, put_at(cell, tree, plan, arm_plan)))
    rest = tuple(
        detection for number, detection in enumerate(plan.detections) if number not in taken
    )
    is_sure = cell.policy.pair_gap > 0 and may_have_moved(cell, plan) is None
    if stand and rest and not is_sure:
        boxes.append(_full_bin(cell, plan.detections))
        rest = tuple(found for found in rest if found.T_world_found is not None)
    return Scene(plan.scan_digest, (*rest, *stand), (*plan.obstacles, *boxes))


def may_have_moved(cell: Cell, plan: Plan) -> Violation | None:
    """A part that stays, and may lie otherwise once the plan was carried out; None for none.

    Those are parts nearer to a taken one than the policy's `pair_gap`: from then on the scan does
    not say where they are.
    """
    taken = {arm.detection: arm.arm for arm in plan.picks}
    pieces = [turned_pieces(cell.part(detection.part), detection) for detection in plan.detections]
    for number, stays in product(taken, range(len(plan.detections))):
        if stays in taken:
            continue
        for moved, standing in product(pieces[number], pieces[stays]):
            gap = min(gap_of(a, b, cell.policy.pair_gap) for a, b in product(moved, standing))
            if gap < cell.policy.pair_gap:
                pair = (f"part-{number + 1}", f"part-{stays + 1}")
                problem = ProofText.MAY_MOVE(stays=FoundPart(stays), taken=FoundPart(number))
                return Violation(problem, taken[number], "extract", None, pair, gap)
    return None


def _full_bin(cell: Cell, parts: Sequence[Detection]) -> Obstacle:
    """A box that holds parts of the bin however they come to lie."""
    T_bin_world, high = cell.bin.T_world_bin.inverse(), float(cell.bin.size[2])
    for part in parts:
        points, T = cell.part(part.part).mesh.points, T_bin_world * part.T_world_part
        if part.T_world_found is None:
            high = max(high, float((points @ T.rotation[2] + T.translation[2]).max()))
    return filled_bin(cell, high, {part.part for part in parts})

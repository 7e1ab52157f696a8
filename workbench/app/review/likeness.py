"""How alike two results of the same task are: to the last digit, within tolerances, or not.

A result that is computed again on another make of processor may differ in its last digits:
libraries choose their instructions by the processor, and these round differently.  What is
tolerated here is below what any later stage looks at; whatever is more is named.
"""

import enum
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.calibration import BallScan, PlateObservation
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.messages.message import plain
from workbench.model.plan import Plan, PlanResult, Proof
from workbench.model.prediction import EmptiedPile, Emptying
from workbench.model.scan import Detection, Scan
from workbench.perception.matching.pose_error import pose_error
from workbench.proof.claims.prove import prove

OTHER_STEP = float(np.deg2rad(0.015))
"""[rad] A value between two hundredths of a degree, as controllers take them, may be rounded to
either: only what is farther apart is another way."""

MOVED = 2e-5
"""Tolerance of points, positions and clearances [m]: a tenth of a fine scanner's resolution."""

MOST_TURNED = float(np.deg2rad(0.02))
"""Tolerance of part rotations [rad]."""

ELSEWHERE = 0.001
"""Share of a scan's points that may lie elsewhere or be missing: at an edge a ray that passes by
meets the surface behind it."""

SCORED = 0.001
"""Tolerance of scores and of shares of a surface."""

SMALLEST_SHOWN = 0.001
"""[mm, degrees] What is less is reported as this."""


class Likeness(enum.StrEnum):
    """How alike two results are."""

    EQUAL = "equal"
    WITHIN = "the same within"
    OTHER = "another result"


@dataclass(frozen=True, slots=True)
class Resemblance:
    """How alike two results are, and the whole of it in words."""

    likeness: Likeness
    says: str


EQUAL = Resemblance(Likeness.EQUAL, "equal")


def resemblance(cell: Cell, kept: object, again: object) -> Resemblance:
    """Compare a result that was recorded with the one that was computed again.

    Args:
        cell: in which both were computed.
        kept: scan, detections, observation or planning as recorded.
        again: the same task's result of now.
    """
    match kept, again:
        case Scan(), Scan():
            return _scans(kept, again)
        case tuple(), tuple():
            return _parts(cell, kept, again)
        case PlateObservation(), PlateObservation():
            return _balls(kept, again) if kept.arm == again.arm else _other("")
        case BallScan(), BallScan():
            return _balls(kept, again)
        case PlanResult(), PlanResult():
            return _plannings(cell, kept, again)
        case Emptying(), Emptying():
            return _emptyings(kept, again)
        case _:
            return EQUAL if digest_of(kept) == digest_of(again) else _other("")


def _other(says: str) -> Resemblance:
    return Resemblance(Likeness.OTHER, ": ".join(filter(None, (Likeness.OTHER, says))))


def _within(says: str) -> Resemblance:
    return Resemblance(Likeness.WITHIN, f"{Likeness.WITHIN} {says}")


def _scans(kept: Scan, again: Scan) -> Resemblance:
    if kept.digest == again.digest:
        return EQUAL
    if kept.resolution != again.resolution or (kept.pixels is None) != (again.pixels is None):
        return _other("of another resolution")
    if digest_of(kept.T_world_scanner) != digest_of(again.T_world_scanner):
        return _other("taken from elsewhere")
    count = max(len(kept.points), len(again.points))
    if kept.pixels is None or again.pixels is None:
        if len(kept.points) != len(again.points):
            return _other(f"{len(again.points):,} points instead of {len(kept.points):,}")
        apart = np.linalg.norm(kept.points - again.points, axis=1)
        alone = 0
    else:
        _, kept_index, other = np.intersect1d(kept.pixels, again.pixels, return_indices=True)
        apart = np.linalg.norm(kept.points[kept_index] - again.points[other], axis=1)
        alone = len(kept.points) + len(again.points) - 2 * len(kept_index)
    is_near = apart <= MOVED
    elsewhere = alone + int(np.count_nonzero(~is_near))
    differ = alone + int(np.count_nonzero(apart))
    if elsewhere > ELSEWHERE * count:
        return _other(f"{elsewhere:,} of {count:,} points lie elsewhere")
    largest = float(apart[is_near].max(initial=0.0))
    says = f"{_millimetres(largest)}; {differ:,} of {count:,} points differ"
    return _within(says + (f", {elsewhere:,} of them lie elsewhere" if elsewhere else ""))


def _parts(cell: Cell, kept: tuple[Detection, ...], again: tuple[Detection, ...]) -> Resemblance:
    if digest_of(kept) == digest_of(again):
        return EQUAL
    if len(kept) != len(again):
        return _other(f"{len(again)} parts instead of {len(kept)}")
    left = list(again)
    worst, turned = 0.0, 0.0
    for number, detection in enumerate(kept, start=1):
        errors = [
            (*_pose_error(cell, detection, other), k)
            for k, other in enumerate(left)
            if other.part == detection.part
        ]
        if not errors:
            return _other(f"part {number}, a {detection.part}, is another one")
        distance, turn, k = min(errors)
        if problem := _part_problem(detection, left.pop(k), distance, turn):
            return _other(f"part {number} {problem}")
        worst, turned = max(worst, distance), max(turned, turn)
    return _within(f"{_millimetres(worst)} and {_degrees(turned)}")


def _pose_error(cell: Cell, detection: Detection, other: Detection) -> tuple[float, float]:
    roll_known = detection.roll_known and other.roll_known
    return pose_error(
        cell.part(detection.part),
        detection.T_world_part,
        other.T_world_part,
        roll_known=roll_known,
        roll_axis=detection.roll_axis if other.roll_known else other.roll_axis,
    )


def _part_problem(detection: Detection, other: Detection, distance: float, turn: float) -> str:
    """How two detections differ; empty within tolerances."""
    if distance > MOVED or turn > MOST_TURNED:
        return f"lies {_millimetres(distance)} and {_degrees(turn)} elsewhere"
    if detection.roll_known != other.roll_known:
        return f"has its roll {'unknown' if detection.roll_known else 'known'} now"
    if max(abs(detection.score - other.score), abs(detection.visible - other.visible)) > SCORED:
        return f"has a score of {other.score:.3f} instead of {detection.score:.3f}"
    return ""


def _balls(kept: PlateObservation | BallScan, again: PlateObservation | BallScan) -> Resemblance:
    if digest_of(kept) == digest_of(again):
        return EQUAL
    if kept.balls.shape != again.balls.shape:
        return _other("")
    apart = float(np.linalg.norm(kept.balls - again.balls, axis=1).max())
    same_place = (kept.name, *kept.q) == (again.name, *again.q)
    if apart > MOVED or not same_place:
        return _other(f"a ball lies {_millimetres(apart)} elsewhere" if same_place else "")
    return _within(_millimetres(apart))


def _emptyings(kept: Emptying, again: Emptying) -> Resemblance:
    """What was measured by the clock is never the same, and no part of the result."""

    def timeless(pile: EmptiedPile) -> EmptiedPile:
        left = tuple(replace(stays, reason=plain("")) for stays in pile.left)
        return replace(pile, planning=(), stages=(), finding=0.0, beside=(), left=left)

    if len(kept.piles) != len(again.piles):
        return _other(f"{len(again.piles)} piles instead of {len(kept.piles)}")
    for pile, other in zip(kept.piles, again.piles, strict=True):
        if timeless(pile) != timeless(other):
            what = f", {pile.task.change}" if pile.task.change else ""
            return _other(
                f"seed {pile.task.seed}{what}: {other.taken} of {other.parts} parts taken instead "
                f"of {pile.taken}, or others"
            )
    return EQUAL


def _plannings(cell: Cell, kept: PlanResult, again: PlanResult) -> Resemblance:
    if digest_of(_unsaid(kept)) == digest_of(_unsaid(again)):
        return EQUAL
    verdicts = _other_verdicts(kept, again)
    if kept.plan is None or again.plan is None:
        if kept.plan is not again.plan:
            return _other("no plan now" if again.plan is None else "a plan now")
        if verdicts or kept.verdict.reason is not again.verdict.reason:
            return _other(verdicts or f"{again.verdict} instead of {kept.verdict}")
        return _within("rounding: every candidate has the same verdict, and there is no plan")
    proof = prove(cell, kept.plan.scene, kept.plan)
    says = f"the recorded plan is {'' if proof.holds else 'NOT '}proven here too"
    problem = verdicts or _other_plan(kept.plan, again.plan) or _other_proof(kept.proof, proof)
    if problem or not proof.holds:
        return _other("; ".join(filter(None, (problem, says))))
    return _within(f"{_degrees(_joints_apart(kept.plan, again.plan))} in every joint; {says}")


def _unsaid(result: PlanResult) -> tuple[object, ...]:
    """What a planning has brought, without its remarks, which another version may word anew."""
    plan, proof = result.plan, result.proof
    if proof is not None:
        # A violation is told from others by its place.
        proof = replace(
            proof,
            plan_digest="",
            nearest=None if proof.nearest is None else replace(proof.nearest, problem=plain("")),
            violations=tuple(
                replace(violation, problem=plain("")) for violation in proof.violations
            ),
        )
    return (
        [
            replace(candidate, verdict=replace(candidate.verdict, note=None))
            for candidate in result.candidates
        ],
        None if plan is None else replace(plan, note="").digest,
        None if proof is None else proof.digest,
        replace(result.verdict, note=None),
    )


def _other_verdicts(kept: PlanResult, again: PlanResult) -> str:
    if len(kept.candidates) != len(again.candidates):
        return f"{len(again.candidates)} candidates instead of {len(kept.candidates)}"
    differ = sum(
        candidate.verdict.reason is not other.verdict.reason
        for candidate, other in zip(kept.candidates, again.candidates, strict=True)
    )
    return f"{differ} of {len(kept.candidates)} candidates with another verdict" if differ else ""


def _other_plan(kept: Plan, again: Plan) -> str:
    """What makes it another plan, in words; empty when only digits differ."""
    if kept.strategy != again.strategy or kept.guarantee is not again.guarantee:
        return f"{again.strategy}, {again.guarantee} instead of {kept.strategy}, {kept.guarantee}"
    ours, theirs = (
        [(arm.arm, arm.detection, arm.grasp, arm.tcp) for arm in plan.arms]
        for plan in (kept, again)
    )
    if ours != theirs:
        return "other picks"
    for arm, other in zip(kept.arms, again.arms, strict=True):
        for leg, now in zip(arm.legs, other.legs, strict=True):
            if leg.q.shape != now.q.shape or np.abs(leg.q - now.q).max() > OTHER_STEP:
                return f"another way for the {arm.arm} arm, {leg.name}"
    return ""


def _other_proof(kept: Proof | None, again: Proof) -> str:
    """What makes the proof of the same plan another one; empty when only digits differ."""
    if kept is None or abs(kept.clearance - again.clearance) <= MOVED:
        return ""
    return (
        f"the recorded plan has a clearance of {_millimetres(again.clearance)} instead of "
        f"{_millimetres(kept.clearance)}"
    )


def _joints_apart(kept: Plan, again: Plan) -> float:
    """The most that a joint differs in any waypoint [rad]."""
    return max(
        float(np.abs(leg.q - now.q).max())
        for arm, other in zip(kept.arms, again.arms, strict=True)
        for leg, now in zip(arm.legs, other.legs, strict=True)
    )


def _millimetres(metres: float) -> str:
    return f"{_short(metres * 1000)} mm"


def _degrees(radians: float) -> str:
    return f"{_short(float(np.rad2deg(radians)))} degrees"


def _short(value: float) -> str:
    return f"{max(value, SMALLEST_SHOWN):.2g}" if value < 10 else f"{value:.0f}"

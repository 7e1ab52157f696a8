"""Whether a scanner has drifted, and its pose from all measurements.

A bin can be moved by people.  So it never says that the scanner has drifted: fixtures do, which
belong to the robot's world, and parts that the robot has put down.  What is known of the pose (the
covariance of the calibration, what has changed since, what parts say) is put together by its
information.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtr

from workbench.model.geometry import Bools, Floats, own
from workbench.perception.calibration.drift import (
    CHANCE,
    DAY,
    MOST_DAYS,
    PARTS_LABEL,
    DriftEstimate,
    DriftHistory,
    courses,
    estimated,
)
from workbench.perception.calibration.things import ThingSighting

FEWEST_PARTS = 4
"""Parts put down by which a pose is refined."""

POSE_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
"""Shifts along the world's axes, and turns about them, as controllers show them."""


@dataclass(frozen=True, slots=True, eq=False)
class Drift:
    """Drift of the scanner since its calibration, from recorded scans.

    Attributes:
        courses: apparent motion by each thing, day by day.
        drifted: names of the things that show a drift.
        is_bin_off: whether only the bin has moved, so that the scanner may not have.
        open: directions that nothing except the bin measures.
        moved: correction of the scanner's pose at the bin's middle (6,) [m, rad]; None: no drift.
        covariance: covariance of the corrected pose (6, 6); None: no drift.
        parts: number of placed parts that a scan showed again.
    """

    courses: tuple[DriftHistory, ...]
    drifted: tuple[str, ...]
    is_bin_off: bool
    open: tuple[str, ...]
    moved: Floats | None
    covariance: Floats | None
    parts: int

    def __post_init__(self) -> None:
        if self.moved is not None and self.covariance is not None:
            own(self, "moved", "covariance")


def drift_of(sightings: Sequence[ThingSighting], prior: Floats, distance: float) -> Drift:
    """What all sightings since the calibration say together.

    Args:
        sightings: of one place of bin, fixtures and scanner in the cell.
        prior: (6, 6) [m, rad] covariance of the scanner's pose by its calibration, at the bin's
            middle.
        distance: [m] from there to the scanner.
    """
    drifts = courses(sightings)
    fixed = [course for course in drifts if course.kind == "fixture"]
    steady = [course for course in fixed if _is_steady(course, fixed)]
    has_drifted = any(course.is_significant.any() for course in steady)
    put_down = _select_recent(
        [sighting for sighting in sightings if sighting.kind == "part"], has_drifted
    )
    by_parts = estimate_from_parts(put_down) if len(put_down) >= FEWEST_PARTS else None
    drifted = [course.thing for course in steady if course.is_significant.any()]
    others = list(steady)
    if by_parts is not None:
        others += [_as_change(by_parts, course) for course in drifts if course.kind == "part"]
        if _is_off(by_parts, prior).any():
            drifted.append(PARTS_LABEL)
    seen = np.zeros(6, bool)
    for course in others:
        seen |= np.isfinite(course.change)
    is_bin_off = any(
        (course.is_significant & (~seen | _disagree(course, other))).any()
        for course in drifts
        if course.kind == "bin"
        for other in others or [course]
    )
    left = tuple(name for name, is_seen in zip(POSE_DIRECTIONS, seen, strict=True) if not is_seen)
    moved = covariance = None
    if has_drifted or by_parts is not None:
        moved, covariance = _combine(prior, steady if has_drifted else [], by_parts, distance)
    return Drift(drifts, tuple(drifted), is_bin_off, left, moved, covariance, len(put_down))


def _select_recent(put_down: list[ThingSighting], has_drifted: bool) -> list[ThingSighting]:
    """Those of the last days, where what was before is of a scanner that hung elsewhere."""
    if not has_drifted or not put_down:
        return put_down
    days = sorted({sighting.at // DAY for sighting in put_down})[-MOST_DAYS:]
    return [sighting for sighting in put_down if sighting.at // DAY >= days[0]]


def estimate_from_parts(put_down: Sequence[ThingSighting]) -> DriftEstimate:
    """The motion of the scanner that parts tell, as sure as they agree.

    A part that has slipped in the hand is seen as exactly as one that has not; some may be from
    before a drift had ended.  So how far the estimate goes when one of them is left out counts as
    well (the jackknife, Tukey 1958).

    Args:
        put_down: at least `FEWEST_PARTS`.
    """
    found, count = estimated(put_down), len(put_down)
    values, axes = np.linalg.eigh(found.information)
    is_held = values > values[-1] * 1e-12
    axes = axes[:, is_held]
    ways = [estimated([*put_down[:k], *put_down[k + 1 :]]).moved for k in range(count)]
    off = (np.array(ways) - found.moved) @ axes
    # Of few parts it is not known well how far they differ, as of few days.
    spread = off.T @ off * (count - 1) / count * (count - 1) / (count - 3)
    covariance = np.diag(1 / values[is_held]) + spread
    information = axes @ np.linalg.inv(covariance) @ axes.T
    return replace(found, information=(information + information.T) / 2)


def _is_off(found: DriftEstimate, prior: Floats) -> Bools:
    """Where parts say of the scanner's pose what neither calibration nor chance explains."""
    variance = np.diag(prior) + np.diag(np.linalg.pinv(found.information, hermitian=True))
    odds = 2 * stdtr(max(found.count - 2, 1), -np.abs(found.moved) / np.sqrt(variance))
    return np.asarray((odds < CHANCE / 6) & found.is_known)


def _as_change(found: DriftEstimate, course: DriftHistory) -> DriftHistory:
    """The course of parts, with what they say of the scanner's pose as its change."""
    spread = np.sqrt(np.diag(np.linalg.pinv(found.information, hermitian=True)))
    unknown = np.where(found.is_known, 0.0, np.nan)
    return replace(
        course,
        change=found.moved + unknown,
        deviation=spread + unknown,
        freedom=max(found.count - 2, 1) + unknown,
    )


def _is_steady(course: DriftHistory, fixed: Sequence[DriftHistory]) -> bool:
    """Whether in no direction as many fixtures disagree with one as agree with it, or more.

    What was pushed disagrees with the others; of two that disagree, either may have been pushed.
    """
    against = np.array([_disagree(course, other) for other in fixed])
    known = np.array([np.isfinite(course.change + other.change) for other in fixed])
    disagree, agree = against.sum(axis=0), (known & ~against).sum(axis=0)
    return bool(np.all((disagree == 0) | (agree > disagree)))


def _disagree(course: DriftHistory, other: DriftHistory) -> Bools:
    """Where (6,) two things say of the scanner what cannot both be so (Welch 1947)."""
    spread = np.hypot(course.deviation, other.deviation)
    odds = 2 * stdtr(
        np.fmin(course.freedom, other.freedom),
        -np.abs(course.change - other.change) / np.maximum(spread, 1e-12),
    )
    return np.asarray(odds < CHANCE / 6)


def _combine(
    prior: Floats, changes: Sequence[DriftHistory], by_parts: DriftEstimate | None, distance: float
) -> tuple[Floats, Floats]:
    """The motion (6,) of the scanner and its covariance (6, 6) from all measurements.

    Along unmeasured directions the scanner may have moved as far as along the measured ones.  Where
    it has rotated about some point of its mount, the bin may appear shifted by that.
    """
    start, variance = np.zeros(6), np.zeros(6)
    if changes:
        weights = np.zeros(6)
        for change in changes:
            # Of few days the deviation is not known well: that of Student's distribution is larger.
            wider = change.freedom / np.maximum(change.freedom - 2, 0.5)
            weight = np.nan_to_num(1 / np.maximum(wider * change.deviation**2, 1e-16))
            weights += weight
            start += weight * np.nan_to_num(change.change)
        is_seen = weights > 0
        start = np.where(is_seen, start / np.maximum(weights, 1e-300), 0.0)
        turn = np.abs(start[3:]).max()
        largest = np.repeat([np.hypot(np.abs(start[:3]).max(), turn * distance), turn], 3)
        variance = np.where(is_seen, 1 / np.maximum(weights, 1e-300), largest**2)
    information = np.linalg.inv(prior + np.diag(variance))
    pulls = information @ start
    if by_parts is not None:
        information = information + by_parts.information
        pulls = pulls + by_parts.information @ by_parts.moved
    covariance = np.linalg.inv(information)
    covariance = (covariance + covariance.T) / 2
    return covariance @ pulls, covariance

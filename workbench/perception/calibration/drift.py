"""Drift of the scanner's pose, measured on things at known places, and the refined pose.

Each day is one measurement: scans of one day are not independent, as nothing may have moved between
them.  For things that stand still, a two-sample test (Student 1908) compares the first days since
the calibration with the last ones, along six directions.  Placed parts are compared with the poses
at which the robot placed them: they show the scanner's pose itself, not only its change.

All motions (6,) [m, rad] are those of the scanner from its pose in the cell.  They are along and
about the world's axes at the bin's middle, as in `things`.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from workbench.model.geometry import Bools, Floats, Ints, frozen, own, put
from workbench.perception.calibration.things import Kind, ThingSighting

DAY = 86400.0
"""[s] Days are those of UTC."""

FEWEST_DAYS, MOST_DAYS = 2, 7
"""Days at the beginning and at the end that are compared: all, up to a week."""

NOW = 3
"""Days at both ends by which the change is stated: what drifts goes on within a week."""

CHANCE = 0.01
"""With which a drift is reported though there is none, all directions and things together."""

ARM = 0.15
"""[m] Lever arm by which a rotation is compared with a shift."""

SCALE = np.repeat([1.0, 1 / ARM], 3)
"""[no unit, 1/m] By it motions have one unit."""

LEAST_DEVIATION = 3e-5 / np.repeat([1.0, ARM], 3)
"""[m, rad] Deviation of every comparison that no number of days takes out.  In simulation a bin
that is moved beside a table moves the table's fit by a fifth of that; nothing real is so flat."""

PARTS_LABEL = "parts put down"
"""What all parts together are called."""

UNSEEN = 1e-4
"""Information along a direction over that along the best one, below which it is not known."""

LEAK = 0.02
"""Share of a direction that may be among what is not known, for it to count as known."""


@dataclass(frozen=True, slots=True, eq=False)
class DriftHistory:
    """Apparent motion of the scanner by one thing, day by day.

    Attributes:
        days: days since the epoch (n,), no unit.
        moved: apparent motion of the scanner (n, 6) [m, rad]; NaN along unmeasured directions.
        change: change from the first three days to the last three (6,) [m, rad]; NaN: unknown.
        deviation: standard deviation of `change` (6,) [m, rad].
        freedom: degrees of freedom of `deviation` (6,).
        is_significant: whether first and last week differ by more than chance (6,).
    """

    thing: str
    kind: Kind
    days: Ints
    moved: Floats
    change: Floats
    deviation: Floats
    freedom: Floats
    is_significant: Bools

    def __post_init__(self) -> None:
        own(self, "moved", "change", "deviation", "freedom")
        put(
            self,
            days=frozen(self.days, np.int64),
            is_significant=frozen(self.is_significant, np.bool_),
        )


@dataclass(frozen=True, slots=True, eq=False)
class DriftEstimate:
    """A motion (6,) [m, rad] of the scanner and its information (6, 6) [1/m2, 1/rad2].

    Both are zero along unknown directions; `count` is the number of sightings.
    """

    moved: Floats
    information: Floats
    count: int

    @property
    def is_known(self) -> Bools:
        """Along which of the six directions it says something."""
        return known(self.information)


def known(information: Floats) -> Bools:
    """Which of the six directions an information (6, 6) [1/m2, 1/rad2] determines by itself."""
    values, axes = np.linalg.eigh(information * np.outer(SCALE, SCALE))
    if values[-1] <= 0:
        return np.zeros(6, bool)
    lost = axes[:, values < UNSEEN * values[-1]]
    return np.asarray((lost**2).sum(axis=1) < LEAK**2)


def estimated(sightings: Sequence[ThingSighting]) -> DriftEstimate:
    """The motion of the scanner by least squares over sightings, with its information.

    Their own information says how directions compare; how large their errors are is taken from
    what they leave over, where there are enough of them.
    """
    sums, pulls = np.zeros((6, 6)), np.zeros(6)
    for sighting in sightings:
        pull = sighting.slopes.T @ sighting.information
        sums, pulls = sums + pull @ sighting.slopes, pulls + pull @ sighting.off
    values, axes = np.linalg.eigh(sums * np.outer(SCALE, SCALE))
    is_held = values > UNSEEN * max(values[-1], 1e-300)
    axes = axes[:, is_held] * SCALE[:, None]
    moved = axes @ ((axes.T @ pulls) / values[is_held])
    left = numbers = 0.0
    for sighting in sightings:
        off = sighting.off - sighting.slopes @ moved
        left += off @ sighting.information @ off
        numbers += np.linalg.matrix_rank(sighting.information, hermitian=True)
    freedom = numbers - np.count_nonzero(is_held)
    spread = max(1.0, left / freedom) if freedom > 0 else 1.0
    back = axes / SCALE[:, None] ** 2
    return DriftEstimate(moved, (back * values[is_held]) @ back.T / spread, len(sightings))


def courses(sightings: Sequence[ThingSighting]) -> tuple[DriftHistory, ...]:
    """Each thing day after day, what stands still first; parts are one thing, whichever they are.

    Args:
        sightings: since the calibration, of one place of bin and fixtures.
    """
    by_thing: defaultdict[tuple[str, Kind], list[ThingSighting]] = defaultdict(list)
    for sighting in sightings:
        by_thing[
            (PARTS_LABEL if sighting.kind == "part" else sighting.thing, sighting.kind)
        ].append(sighting)
    tests = 6 * max(1, sum(kind != "part" for _, kind in by_thing))
    order = sorted(
        by_thing, key=lambda thing: (("bin", "fixture", "part").index(thing[1]), thing[0])
    )
    return tuple(_course(*key, by_thing[key], CHANCE / tests) for key in order)


def _course(
    thing: str, kind: Kind, sightings: Sequence[ThingSighting], chance: float
) -> DriftHistory:
    by_day: defaultdict[int, list[ThingSighting]] = defaultdict(list)
    for sighting in sightings:
        by_day[int(sighting.at // DAY)].append(sighting)
    days = np.array(sorted(by_day))
    moved = np.full((len(days), 6), np.nan)
    for row, day in enumerate(days.tolist()):
        found = estimated(by_day[day])
        moved[row, found.is_known] = found.moved[found.is_known]
    change, deviation, freedom, odds = (np.full(6, np.nan) for _ in range(4))
    for axis in range(6):
        values = moved[np.isfinite(moved[:, axis]), axis]
        size = min(MOST_DAYS, len(values) // 2)
        if size < FEWEST_DAYS:
            continue
        first, last = values[:size], values[-size:]
        variance, now = first.var(ddof=1) + last.var(ddof=1), min(NOW, size)
        freedom[axis] = 2 * size - 2
        away = abs(last.mean() - first.mean()) / np.hypot(
            np.sqrt(variance / size), LEAST_DEVIATION[axis]
        )
        odds[axis] = 2 * stdtr(freedom[axis], -away)
        change[axis] = last[-now:].mean() - first[:now].mean()
        deviation[axis] = np.hypot(np.sqrt(variance / now), LEAST_DEVIATION[axis])
    is_significant = np.asarray(odds < chance)  # not where nothing is compared
    return DriftHistory(thing, kind, days, moved, change, deviation, freedom, is_significant)

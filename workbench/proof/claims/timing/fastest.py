"""Compiled: how fast a curve can be followed, and whether its waypoints can be passed on time.

A curve q(s) is given by its slope q' at marks, between which it changes linearly; s grows by 1 from
waypoint to waypoint.  Let x be the square of the speed ds/dt at a mark, linear in s between marks.
Then the acceleration of a joint, q' x' / 2 + q'' x, is linear in s.  So limits that hold at both
ends of a piece hold in all of it.  The joint's speed is q' sqrt(x).  So a piece allows the pairs
(x before, x after) of a convex polygon, which contains (0, 0).

The faster of two motions at each mark is a motion, too.  So there is a fastest motion, and none
passes from one waypoint to the next in less time.  Between given speeds at two waypoints, mixtures
of the fastest and the slowest motion give every duration between theirs.
"""

from typing import cast

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.proof.engine.compiled import njit_in_place

SOONEST = 0.001
"""[s] From a waypoint to an equal one."""

LIMIT_HALVINGS, SPEED_HALVINGS = 45, 20
"""Of an interval in which a limit is searched for, and in which a speed is."""

ROUNDING_SHARE = 1e-9
"""Share of a squared speed that rounding may decide."""

SHARES_TRIED = np.array([1.0, 0.97, 0.93, 0.85, 0.75, 0.64, 0.5, 0.36, 0.2, 0.1, 0.03, 0.0])
"""Of the fastest squared speed at a waypoint, which are tried where simpler ways find nothing."""

BEFORE, AFTER = cast(bool, np.True_), cast(bool, np.False_)
"""Arguments with a type of their own: numba compiles a function anew for each plain one."""


@njit_in_place
def _room(
    before: Floats, after: Floats, width: float, acceleration: Floats, x: float, is_before: bool
) -> tuple[float, float]:  # pragma: no cover (compiled)
    """The least and the largest x at one end of a piece, of which x at the other end is known.

    The slopes (n,) are those at its two ends.  The least is above the largest where there is none.
    """
    least, largest = 0.0, np.inf
    for j in range(len(before)):
        bend = (after[j] - before[j]) / width
        for end in range(2):
            push = (after[j] if end else before[j]) / (2.0 * width)
            first, second = (-push, push + bend) if end else (bend - push, push)
            known, open_ = (first, second) if is_before else (second, first)
            if abs(open_) < ROUNDING_SHARE * SOONEST**2 * acceleration[j]:
                if abs(known * x) > acceleration[j] * (1.0 + ROUNDING_SHARE):
                    return 1.0, 0.0
                continue
            highest = (acceleration[j] - known * x) / open_
            lowest = (-acceleration[j] - known * x) / open_
            least, largest = max(least, min(highest, lowest)), min(largest, max(highest, lowest))
    return least, largest


@njit_in_place
def _most(
    before: Floats,
    after: Floats,
    width: float,
    acceleration: Floats,
    most: float,
    lower: float,
    upper: float,
) -> float:  # pragma: no cover (compiled)
    """The largest x, up to `most`, before a piece that leads to one from `lower` to `upper`.

    -1 where there is none.
    """
    least, largest = _room(before, after, width, acceleration, most, BEFORE)
    if max(least, lower) <= min(largest, upper):
        return most
    # Where it leads to either end, or, with `lower` 0, from standing still, is known to be one.
    low = 0.0 if lower == 0.0 else -1.0
    for x in (lower, upper):
        least, largest = _room(before, after, width, acceleration, x, AFTER)
        if least <= min(largest, most):
            low = max(low, min(largest, most))
    if low < 0.0:
        return low
    # Mostly it is that; else it is looked for.
    high, middle = most, low * (1.0 + ROUNDING_SHARE)
    for _ in range(LIMIT_HALVINGS):
        if high <= low * (1.0 + ROUNDING_SHARE):
            break
        least, largest = _room(before, after, width, acceleration, middle, BEFORE)
        if max(least, lower) <= min(largest, upper):
            low = middle
        else:
            high = middle
        middle = (low + high) / 2.0
    return low


@njit(cache=True)
def ceilings(slopes: Floats, velocity: Floats) -> Floats:  # pragma: no cover (compiled)
    """The squared speeds (k,) [1/s2] at marks that the speeds of the joints allow.

    In a piece of which one end is steep and the other fast, a joint would be faster in between than
    at either: the steeper end counts for both.
    """
    most = np.full(len(slopes), SOONEST**-2)
    for k in range(len(slopes) - 1):
        for j in range(len(velocity)):
            steep = max(abs(slopes[k, j]), abs(slopes[k + 1, j]))
            if steep > 0.0:
                limit = (velocity[j] / steep) ** 2
                most[k], most[k + 1] = min(most[k], limit), min(most[k + 1], limit)
    return most


@njit(cache=True)
def fastest(
    slopes: Floats, widths: Floats, velocity: Floats, acceleration: Floats
) -> Floats:  # pragma: no cover (compiled)
    """The squared speeds (k,) [1/s2] at marks of the fastest motion from rest to rest.

    Args:
        slopes: q' (k, n) [rad, m] at the marks.
        widths: of the pieces between them (k - 1,).
        velocity: largest joint speeds (n,) [rad/s, m/s].
        acceleration: largest joint accelerations (n,) [rad/s2, m/s2].
    """
    x = ceilings(slopes, velocity)
    last = len(widths)
    x[last] = 0.0
    for k in range(last - 1, -1, -1):
        x[k] = _most(slopes[k], slopes[k + 1], widths[k], acceleration, x[k], 0.0, x[k + 1])
    x[0] = 0.0
    for k in range(last):
        _, largest = _room(slopes[k], slopes[k + 1], widths[k], acceleration, x[k], BEFORE)
        x[k + 1] = max(min(x[k + 1], largest), 0.0)
    return x


@njit_in_place
def seconds(x: Floats, widths: Floats) -> float:  # pragma: no cover (compiled)
    """How long [s] it takes along marks at squared speeds (k,)."""
    total = 0.0
    for k in range(len(widths)):
        speeds = np.sqrt(x[k]) + np.sqrt(x[k + 1])
        if speeds == 0.0:
            return np.inf
        total += 2.0 * widths[k] / speeds
    return total


@njit(cache=True)
def _between(
    slopes: Floats, widths: Floats, acceleration: Floats, most: Floats, start: float, end: float
) -> tuple[float, float]:  # pragma: no cover (compiled)
    """The least and the longest time [s] from a squared speed to another; (inf, 0) for none.

    `most` (k,) are the squared speeds that may not be exceeded.
    """
    last = len(widths)
    lower, upper = np.zeros(last + 1), np.zeros(last + 1)
    lower[last] = upper[last] = end
    for k in range(last - 1, -1, -1):
        low, high = _room(slopes[k], slopes[k + 1], widths[k], acceleration, lower[k + 1], AFTER)
        upper[k] = _most(
            slopes[k], slopes[k + 1], widths[k], acceleration, most[k], lower[k + 1], upper[k + 1]
        )
        lower[k] = low if low <= min(high, upper[k]) else upper[k]
        if upper[k] < 0.0:
            return np.inf, 0.0
    if start < lower[0] * (1.0 - ROUNDING_SHARE) or start > upper[0] * (1.0 + ROUNDING_SHARE):
        return np.inf, 0.0
    quick, slow = np.zeros(last + 1), np.zeros(last + 1)
    quick[0] = slow[0] = min(max(start, lower[0]), upper[0])
    for k in range(last):
        _, largest = _room(slopes[k], slopes[k + 1], widths[k], acceleration, quick[k], BEFORE)
        quick[k + 1] = max(min(largest, upper[k + 1]), lower[k + 1])
        least, _ = _room(slopes[k], slopes[k + 1], widths[k], acceleration, slow[k], BEFORE)
        slow[k + 1] = min(max(least, lower[k + 1]), upper[k + 1])
    return seconds(quick, widths), seconds(slow, widths)


@njit(cache=True)
def _onward(
    slopes: Floats,
    widths: Floats,
    acceleration: Floats,
    most: Floats,
    start: float,
    end: float,
    planned: float,
    halvings: int,
) -> float:  # pragma: no cover (compiled)
    """The largest squared speed, up to `end`, that a segment can end with; -1 for none.

    From `start`, in just the time that is planned [s].  Without `halvings` only `end` is tried.
    """
    low, high = start, end
    quick, slow = _between(slopes, widths, acceleration, most, start, end)
    if halvings and planned > slow * (1.0 + ROUNDING_SHARE):
        # The lower it ends, the longer it may take; no lower than where it only brakes.
        for k in range(len(widths)):
            low, _ = _room(slopes[k], slopes[k + 1], widths[k], acceleration, low, BEFORE)
        low = min(low, end)
        for _ in range(halvings):
            middle = (low + high) / 2.0
            _, slow = _between(slopes, widths, acceleration, most, start, middle)
            if planned <= slow * (1.0 + ROUNDING_SHARE):
                low = middle
            else:
                high = middle
        end = low
        quick, slow = _between(slopes, widths, acceleration, most, start, end)
    if quick <= planned * (1.0 + ROUNDING_SHARE) and planned <= slow * (1.0 + ROUNDING_SHARE):
        return end
    return -1.0


@njit(cache=True)
def find_infeasible_segment(
    slopes: Floats,
    widths: Floats,
    quick: Floats,
    most: Floats,
    acceleration: Floats,
    times: Floats,
) -> int:  # pragma: no cover (compiled)
    """The segment at which the best attempt failed, or -1 if the planned times are feasible.

    What is found is a motion: as fast as can be at each waypoint, or at the pace of the whole leg;
    and slower where a segment takes longer than it could then; or by the speeds of `SHARES_TRIED`,
    in any order.  A motion with other speeds may be missed.

    Args:
        slopes: q' (k, n) [rad, m] at marks, equally many from each waypoint to the next.
        widths: of the pieces between them (k - 1,).
        quick: squared speeds (k,) [1/s2] of the fastest motion, or of one that is hardly slower.
        most: those that the speeds of the joints allow (k,) [1/s2].
        acceleration: largest joint accelerations (n,) [rad/s2, m/s2].
        times: what each segment should take (m,) [s].
    """
    count, pieces = len(times), len(widths) // len(times)
    farthest, pace = 0, min(seconds(quick, widths) / times.sum(), 1.0) ** 2
    for share, halvings in ((1.0, 0), (pace, 0), (1.0, SPEED_HALVINGS), (pace, SPEED_HALVINGS)):
        x = 0.0
        for i in range(count):
            a, b = i * pieces, (i + 1) * pieces
            x = _onward(
                slopes[a : b + 1], widths[a:b], acceleration, most[a : b + 1],
                x, quick[b] * share, times[i], halvings,
            )  # fmt: skip
            if x < 0.0:
                farthest = max(farthest, i)
                break
        if x >= 0.0:
            return -1
    is_open = np.ones(len(SHARES_TRIED), np.bool_)
    for i in range(count):
        a, b = i * pieces, (i + 1) * pieces
        reached = np.zeros(len(SHARES_TRIED), np.bool_)
        for n in range(len(SHARES_TRIED)):
            for m in range(len(SHARES_TRIED)):
                if is_open[m] and not reached[n]:
                    soon, slow = _between(
                        slopes[a : b + 1], widths[a:b], acceleration, most[a : b + 1],
                        quick[a] * SHARES_TRIED[m], quick[b] * SHARES_TRIED[n],
                    )  # fmt: skip
                    reached[n] = soon <= times[i] <= slow
        if not reached.any():
            return max(farthest, i)
        is_open = reached
    return -1

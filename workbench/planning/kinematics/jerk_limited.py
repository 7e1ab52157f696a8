"""When the arm passes each waypoint where its jerk is limited: ways joined by blends in time.

Nothing follows a corner that is rounded by a parabola with finite jerk, unless it stops: q'' jumps
where the parabola begins.  So a corner is rounded in time: all joints go over from the velocity u
of one way to the velocity w of the next by u + (w - u) S(t), an S-curve.  It leaves the one way and
is on the other within the zone.  As S' is symmetric and greatest in the middle: the curve lies
between the corner and the parabola of the same width, for which S' is constant: in what is known to
be free.  Between two blends the arm goes straight, up to a speed and down again by S-curves.

On a way a joint has a share of the parameter's speed, acceleration and jerk, in a blend a share of
S' and S'': limits that hold for these hold everywhere, and nothing is sampled.  Where blends begin
and end there is no acceleration.

Each corner is passed at one share of the full speeds of both ways beside it: the largest from which
the rest can be done (backwards), then the largest that can be reached (forwards).  No other motion
of this kind is faster.

Sources: Biagiotti and Melchiorri, "Trajectory Planning for Automatic Machines and Robots", Springer
2008, chapter 3.4 (S-curves); Paul, "Robot Manipulators", MIT Press 1981, chapter 5 (ways that
blends join).
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.planning.compiled import njit_in_place

STANDSTILL = 0.001
"""[s] No two waypoints are passed in less, be they equal."""

UNLIMITED = 1e18
"""What the parameter may do where no joint moves that has a limit."""

MOST_HALVINGS = 50
"""Of an interval in which a share is searched for."""


@njit(cache=True)
def jerk_limited(
    steps: Floats, velocity: Floats, acceleration: Floats, jerk: Floats, zone: float
) -> Floats:
    """Times (m + 1,) [s] at which the ends of ways are passed, starting at 0, from rest to rest.

    Args:
        steps: the ways (m, n) [rad], from each waypoint to the next.
        velocity: largest joint speeds (n,) [rad/s], already scaled.
        acceleration: largest joint accelerations (n,) [rad/s2].
        jerk: largest joint jerks (n,) [rad/s3]; infinite where there is no limit.
        zone: corner rounding, share of the ways beside it, below 0.5; 0 stops at every waypoint.
    """
    count = len(steps)
    # Full speeds of the parameter, and what its share of these may change by: along a way, and in
    # the corner before each and after the last, in which S takes that share.
    full, along, across = np.empty(count), np.empty((count, 2)), np.full((count + 1, 2), UNLIMITED)
    for k in range(count):
        full[k] = min(_most(steps[k], velocity), 1.0 / STANDSTILL)
        along[k, 0] = _most(steps[k] * full[k], acceleration)
        along[k, 1] = _most(steps[k] * full[k], jerk)
        if k > 0:
            turn = steps[k] * full[k] - steps[k - 1] * full[k - 1]
            across[k, 0], across[k, 1] = _most(turn, acceleration), _most(turn, jerk)
    shares = _within_zones(full, across, zone)
    for k in range(count - 1, 0, -1):
        shares[k] = _fastest(full[k], along[k], across[k], across[k + 1], shares[k], shares[k + 1])
    for k in range(count):
        shares[k + 1] = _fastest(
            full[k], along[k], across[k + 1], across[k], shares[k + 1], shares[k]
        )
    times = np.zeros(count + 1)
    for k in range(count):
        ends = shares[k], shares[k + 1]
        straight = _straight(full[k], across[k], across[k + 1], ends[0], ends[1])
        low, high = max(ends[0], ends[1]), 1.0
        for _ in range(MOST_HALVINGS):
            middle = (low + high) / 2.0
            if _needed_share(full[k], along[k], ends[0], ends[1], middle) <= straight:
                low = middle
            else:
                high = middle
        ramps = _ramp(low - ends[0], along[k]) + _ramp(low - ends[1], along[k])
        steady = max(straight - _needed_share(full[k], along[k], ends[0], ends[1], low), 0.0)
        corners = (_ramp(ends[0], across[k]) + _ramp(ends[1], across[k + 1])) / 2.0
        times[k + 1] = times[k] + corners + ramps + steady / (full[k] * low)
    return times


@njit_in_place
def _most(moves: Floats, limits: Floats) -> float:
    """The largest factor by which `moves` (n,) stay within their limits (n,)."""
    most = UNLIMITED
    for j in range(len(moves)):
        if moves[j] != 0.0:
            most = min(most, limits[j] / abs(moves[j]))
    return most


@njit_in_place
def _ramp(change: float, limits: Floats) -> float:
    """How long [s] an S-curve needs for a change, its slope and curvature within `limits` (2,)."""
    if change * limits[1] >= limits[0] * limits[0]:
        return change / limits[0] + limits[0] / limits[1]
    return 2.0 * np.sqrt(change / limits[1])


@njit_in_place
def _blend_share(full: float, across: Floats, share: float) -> float:
    """How much of a way lies in the blend at one of its ends, which is passed at a share."""
    return full * share * _ramp(share, across) / 2.0


@njit_in_place
def _straight(full: float, here: Floats, there: Floats, share: float, other: float) -> float:
    """How much of a way lies between the blends at its two ends."""
    return 1.0 - _blend_share(full, here, share) - _blend_share(full, there, other)


@njit_in_place
def _needed_share(full: float, along: Floats, begin: float, end: float, peak: float) -> float:
    """How much of a way is needed to get from one share of its full speed by a peak to another."""
    into = (begin + peak) / 2.0 * _ramp(abs(peak - begin), along)
    return full * (into + (end + peak) / 2.0 * _ramp(abs(peak - end), along))


@njit(cache=True)
def _within_zones(full: Floats, across: Floats, zone: float) -> Floats:
    """The largest shares (m + 1,) at which corners are rounded within their zones; 0 at ends."""
    shares = np.zeros(len(across))
    for k in range(1, len(full)):
        quick, low, high = max(full[k - 1], full[k]), 0.0, 1.0
        if _blend_share(quick, across[k], high) <= zone:
            low = high
        for _ in range(MOST_HALVINGS):
            middle = (low + high) / 2.0
            if _blend_share(quick, across[k], middle) <= zone:
                low = middle
            else:
                high = middle
        if zone > 0.0:
            shares[k] = low
    return shares


@njit_in_place
def _fastest(
    full: float, along: Floats, here: Floats, there: Floats, most: float, other: float
) -> float:
    """The largest share, up to `most`, at one end of a way from which the `other` can be got to.

    `here` and `there` (2,) are the limits of the blends at this end and at the other one.
    """
    low, high = min(most, other), most
    if low == high:
        return most
    for trial in range(MOST_HALVINGS):
        middle = high if trial == 0 else (low + high) / 2.0
        straight = _straight(full, here, there, middle, other)
        if _needed_share(full, along, other, middle, middle) <= straight:
            low = middle
            if trial == 0:
                break
        else:
            high = middle
    return low

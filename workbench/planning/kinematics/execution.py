"""When the arm passes each waypoint: the fastest timing of a leg within speed and acceleration.

Time-optimal path parameterization by reachability analysis (Pham and Pham, "A new approach to
time-optimal path parameterization based on reachability analysis", IEEE T-RO 2018); over the curve
that the controller follows, from rest to rest.

The curve q(s) is the polyline with corners rounded by parabolas.  Its grid has a point wherever a
parabola begins or ends: so between two grid points q'' is constant, q' linear, the
acceleration of the parameter constant and its squared speed linear: the acceleration of a joint
q' s'' + q'' (s')^2 is linear as well.  What holds at both ends of a piece, each seen from inside of
it, holds everywhere: limits are kept along the whole curve, not only at the grid.
"""

from collections.abc import Callable

import numpy as np
from numba import njit

from workbench.model.errors import WorkbenchError
from workbench.model.geometry import Floats, Ints
from workbench.planning.compiled import njit_in_place
from workbench.planning.kinematics.jerk_limited import jerk_limited

STRAIGHT_PIECES = 16
"""Of the straight middle between two waypoints: where speeding up may turn into slowing down."""

CORNER_PIECES = 8
"""Of each half of a rounded corner."""

STANDSTILL = 0.001
"""[s] No two waypoints are passed in less, be they equal: times have to increase."""

TURNING_SHARE = 1e-9
"""Share of q'' that q' has where a joint turns back: by less, `u` does not move the joint.  What is
left of q' there is rounding, by which nothing may be divided."""

WITHIN = 1e-9
"""Share of a squared speed that rounding may decide."""


SHARE_MARKS = 33
"""On a way that begins and ends at rest, where the speeds of points are asked."""

Shares = Callable[[Floats, Floats], Floats]
"""Configurations and slopes (k, n) -> the share (k,) of a limit at a parameter of speed 1."""


def compute_times(
    path: Floats,
    velocity: Floats,
    acceleration: Floats,
    zone: float,
    jerk: Floats | None = None,
    shares: Shares | None = None,
) -> Floats:
    """Times (m,) [s] at which the waypoints (m, n) are passed, starting at 0, from rest to rest.

    Args:
        path: waypoints, at least two; from one to an equal one it takes `STANDSTILL`, or longer.
        velocity: largest joint speeds (n,) [rad/s], already scaled.
        acceleration: largest joint accelerations (n,) [rad/s2].
        zone: corner rounding, fraction of the neighbouring segments, below 0.5.
        jerk: largest joint jerks (n,) [rad/s3]; without them acceleration may jump, and corners
            are rounded as above, with them as `jerk_limited` says.
        shares: what else may not exceed 1, such as speeds of points as shares of their limits;
            not beside `jerk`.

    Raises:
        WorkbenchError: the limits are not positive, or `shares` are given beside `jerk`.
    """
    if not (np.all(velocity > 0) and np.all(acceleration > 0)):
        raise WorkbenchError("an arm's speed and acceleration limits must be above zero")
    if jerk is not None:
        if not np.all(jerk > 0):
            raise WorkbenchError("an arm's jerk limits must be above zero")
        if shares is not None:
            raise WorkbenchError("speeds of points are not limited where jerk is")
        return jerk_limited(np.diff(path, axis=0), velocity, acceleration, jerk, zone)
    if zone <= 0.0:  # sharp corners are taken at rest
        steps = np.diff(path, axis=0)
        if shares is not None:
            steps, *limits = _with_shares(path, steps, velocity, acceleration, shares)
            return _stopping(steps, *limits)
        return _stopping(steps, velocity, acceleration)
    slopes, bends, widths, at = _pieces(np.diff(path, axis=0), zone)
    if shares is not None:
        # One more joint, whose speed is at most 1, and which accelerates as it likes.
        ends = _marks(path, slopes, widths)
        more = [shares(ends[:, k], slopes[:, k]) for k in range(2)]
        slopes = np.concatenate([slopes, np.stack(more, axis=1)[:, :, None]], axis=2)
        bends = np.concatenate([bends, np.zeros((len(bends), 1))], axis=1)
        velocity, acceleration = np.append(velocity, 1.0), np.append(acceleration, np.inf)
    speeds = np.sqrt(_squared_speeds(slopes, bends, widths, velocity, acceleration))
    times = np.cumsum(2.0 * widths / (speeds[1:] + speeds[:-1]))
    return np.concatenate([[0.0], times[at]])


def _with_shares(
    path: Floats, steps: Floats, velocity: Floats, acceleration: Floats, shares: Shares
) -> tuple[Floats, Floats, Floats]:
    """Ways (m, n) and limits with one more joint, which is fastest of all where points are."""
    at = np.linspace(0.0, 1.0, SHARE_MARKS)[:, None]
    most = [
        shares(start + at * step, np.tile(step, (SHARE_MARKS, 1))).max()
        for start, step in zip(path, steps, strict=False)
    ]
    more = np.column_stack([steps, most])
    return more, np.append(velocity, 1.0), np.append(acceleration, np.inf)


def _marks(path: Floats, slopes: Floats, widths: Floats) -> Floats:
    """Configurations (k, 2, n) [rad] at both ends of pieces: q' is linear in each."""
    steps = (slopes[:, 0] + slopes[:, 1]) / 2 * widths[:, None]
    ends = path[0] + np.cumsum(steps, axis=0)
    return np.stack([ends - steps, ends], axis=1)


def _stopping(steps: Floats, velocity: Floats, acceleration: Floats) -> Floats:
    """Times (m + 1,) [s] along ways (m, n) with a stop after each: possible on every path.

    All joints move in proportion, so the one that is fast soonest and the one that brakes longest
    hold up all others.
    """
    steps = np.abs(steps)
    # Of a whole way: [s] at full speed, [s2] at full acceleration.
    fast, hard = (steps / velocity).max(axis=1), (steps / acceleration).max(axis=1)
    # Up to speed and down again, or never quite up to speed.
    has_time = fast**2 > hard
    times = np.where(has_time, fast + hard / np.where(has_time, fast, 1.0), 2 * np.sqrt(hard))
    return np.concatenate([[0.0], np.cumsum(np.maximum(times, STANDSTILL))])


def _pieces(steps: Floats, zone: float) -> tuple[Floats, Floats, Floats, Ints]:
    """The rounded polyline of segments `steps` (m, n) in k pieces of constant q''.

    Returns:
        q' at both ends of each piece (k, 2, n), q'' in it (k, n), its width in the parameter (k,);
        and the numbers (m,) of those that end at a waypoint.
    """
    count = len(steps)
    turns = np.diff(steps, axis=0, prepend=steps[:1], append=steps[-1:]) / (2 * zone)
    # Where pieces end in a segment, as parameters from 0 to 1; its first and last corner are sharp.
    corner = np.linspace(0.0, zone, CORNER_PIECES + 1)
    middle = np.linspace(zone, 1.0 - zone, STRAIGHT_PIECES + 1)
    marks = np.concatenate([corner[:-1], middle, (1.0 - corner[::-1])[1:]])
    begins, ends = marks[:-1], marks[1:]
    into = np.maximum(zone - begins, 0.0), np.maximum(zone - ends, 0.0)
    out = np.maximum(begins - 1.0 + zone, 0.0), np.maximum(ends - 1.0 + zone, 0.0)
    before, after = turns[:-1, None, :], turns[1:, None, :]
    slopes = [
        steps[:, None, :] - into[k][:, None] * before + out[k][:, None] * after for k in range(2)
    ]
    rounds_in = (np.arange(len(begins)) < CORNER_PIECES)[:, None]
    rounds_out = (np.arange(len(begins)) >= len(begins) - CORNER_PIECES)[:, None]
    bends = rounds_in * before + rounds_out * after
    n = steps.shape[1]
    return (
        np.ascontiguousarray(np.stack([s.reshape(-1, n) for s in slopes], axis=1)),
        np.ascontiguousarray(bends.reshape(-1, n)),
        np.tile(ends - begins, count),
        np.arange(1, count + 1) * len(begins) - 1,
    )


@njit(cache=True)
def _squared_speeds(
    slopes: Floats, bends: Floats, widths: Floats, velocity: Floats, acceleration: Floats
) -> Floats:
    """The fastest squared speeds (k + 1,) [1/s2] of the parameter where pieces begin and end.

    Below, `x` is such a square and `u` the acceleration: x grows by 2 u for each unit.
    """
    count = len(widths)
    # The largest squared speeds from which the rest of the way can be done.  So it can from all
    # below them: standing still always is possible, and what is possible is convex.
    most = np.zeros(count + 1)
    for k in range(count - 1, -1, -1):
        ceiling = _ceiling(slopes[k], bends[k], widths[k], velocity, acceleration)
        most[k + 1] = min(most[k + 1], ceiling)
        most[k] = _fastest(slopes[k], bends[k], widths[k], acceleration, most[k + 1], ceiling)
    most[0] = 0.0
    for k in range(count):
        x = most[k]
        _, _, u, _ = _between(x, slopes[k], bends[k], widths[k], acceleration, most[k + 1])
        most[k + 1] = min(max(x + 2.0 * widths[k] * u, 0.0), most[k + 1])
    return most


@njit_in_place
def _ceiling(
    slope: Floats, bend: Floats, width: float, velocity: Floats, acceleration: Floats
) -> float:
    """The squared speed that the speeds of the joints allow anywhere on a piece."""
    ceiling = STANDSTILL**-2
    for j in range(len(velocity)):
        steepest = max(abs(slope[0, j]), abs(slope[1, j]))
        if steepest > 0.0:
            ceiling = min(ceiling, (velocity[j] / steepest) ** 2)
        for end in range(2):
            # Where `u` does not move the joint, `_between` says nothing of it.
            push = slope[end, j] + 2.0 * width * end * bend[j]
            if bend[j] != 0.0 and abs(push) <= TURNING_SHARE * abs(bend[j]):
                ceiling = min(ceiling, acceleration[j] / abs(bend[j]))
    return ceiling


@njit_in_place
def _fastest(
    slope: Floats, bend: Floats, width: float, acceleration: Floats, follows: float, ceiling: float
) -> float:
    """The largest squared speed at the beginning of a piece that leads to one within `follows`.

    The room between the least and the largest `u` is a concave function of `x` that is not negative
    at 0: Newton's steps come down to where it vanishes, each by another pair of limits.
    """
    x = ceiling
    for _ in range(4 * len(bend) + 4):
        least, least_slope, most, most_slope = _between(
            x, slope, bend, width, acceleration, follows
        )
        if most >= least:
            return x
        before = x
        x = max(x - (most - least) / (most_slope - least_slope), 0.0)
        if x >= before * (1.0 - WITHIN):
            break
    return x * (1.0 - WITHIN)


@njit_in_place
def _between(
    x: float, slope: Floats, bend: Floats, width: float, acceleration: Floats, follows: float
) -> tuple[float, float, float, float]:
    """The least and the largest `u` at `x`, each with how it changes with `x`."""
    # 0 <= x + 2 u width <= follows
    half = 0.5 / width
    least, least_slope = -x * half, -half
    most, most_slope = (follows - x) * half, -half
    for end in range(2):
        for j in range(len(bend)):
            # At the end of the piece x has become x + 2 u width.
            push = slope[end, j] + 2.0 * width * end * bend[j]
            if push == 0.0 or abs(push) <= TURNING_SHARE * abs(bend[j]):
                continue
            reach, tilt = acceleration[j] / abs(push), -bend[j] / push
            if tilt * x - reach > least:
                least, least_slope = tilt * x - reach, tilt
            if tilt * x + reach < most:
                most, most_slope = tilt * x + reach, tilt
    return least, least_slope, most, most_slope

"""A path's corners moved to where it takes less time, which need not be where it is shorter.

The joint with the longest way decides how long a segment takes.  A corner takes time where a
joint has to change its speed in it by more than it can while it is rounded.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.sweeping.edges import ASK, CLEAR, Edges
from workbench.planning.compiled import njit_in_place
from workbench.planning.planners.asking import RecordedAnswers, asking, look_up, write_row
from workbench.plugins.planner import EdgeCheck

JOINT_STEPS = (0.3, 0.1)
"""[rad] By which one joint of a corner is moved, one after the other."""

PULLS = (1.0, 0.7, 0.4, 0.2)
"""Shares of the way to the straight line past it by which a corner is moved."""

LEAST_GAIN = 0.005
"""[s] By less than this nothing is won."""

EASING_ROUNDS = 2


def ease_corners(
    path: Floats, is_clear: EdgeCheck, velocity: Floats, acceleration: Floats, zone: float
) -> Floats:
    """The same path (m, n) [rad] with its corners where it takes less time, some left out.

    Args:
        path: a polyline whose segments are clear.
        is_clear: says so of one.
        velocity: largest joint speeds (n,) [rad/s].
        acceleration: largest joint accelerations (n,) [rad/s2].
        zone: corner rounding, as a share of the segments beside it; between where a corner's
            rounding begins and where it ends it is straight, too, that the path is clear.
    """
    count, joints = path.shape
    if count < 3:
        return path
    trials = EASING_ROUNDS * (len(PULLS) + 2 * joints * len(JOINT_STEPS)) + 1
    return asking(
        lambda edges, answers: _ease(path, velocity, acceleration, zone, edges, answers),
        is_clear,
        joints,
        3 * trials * count,
    )


@njit_in_place
def _seconds(a: Floats, c: Floats, b: Floats, v: Floats, acc: Floats, zone: float) -> float:
    """What it takes about from a to b (n,) by way of a corner c [s]."""
    into, out = 0.0, 0.0
    for j in range(len(c)):
        into = max(into, abs(c[j] - a[j]) / v[j])
        out = max(out, abs(b[j] - c[j]) / v[j])
    if into == 0.0 or out == 0.0:
        return into + out
    turn = 0.0
    for j in range(len(c)):
        turn = max(turn, abs((b[j] - c[j]) / out - (c[j] - a[j]) / into) / acc[j])
    return into + out + max(0.0, turn - zone * (into + out))


@njit(cache=True)
def _leave_out(path: Floats, k: int) -> Floats:
    """The path (m, n) without its waypoint `k`."""
    kept = np.empty((len(path) - 1, path.shape[1]))
    for row in range(len(kept)):
        write_row(kept, row, path[row if row < k else row + 1])
    return kept


# Part of `_ease`: otherwise all that answers its questions is compiled once more.
@njit(cache=True, inline="always")
def _is_open(
    a: Floats, c: Floats, b: Floats, zone: float, edges: Edges, answers: RecordedAnswers, last: Ints
) -> int:
    """Whether it is clear from a to b (n,) by way of a corner c, and across its rounding.

    Of these three edges that is asked first which was in the way the last time, noted in `last`
    (1,): it mostly is again, and to find that costs far less than to find another one clear.
    """
    for number in range(3):
        edge = (last[0] + number) % 3
        answer = CLEAR
        if edge == 0:
            answer = look_up(a, c, edges, answers)
        elif edge == 1:
            answer = look_up(c, b, edges, answers)
        elif zone > 0.0:
            answer = look_up(c + zone * (a - c), c + zone * (b - c), edges, answers)
        if answer != CLEAR:
            last[0] = edge
            return answer
    return CLEAR


@njit(cache=True)
def _ease(
    path: Floats, v: Floats, acc: Floats, zone: float, edges: Edges, answers: RecordedAnswers
) -> Floats:
    path = path.copy()
    joints, last = path.shape[1], np.zeros(1, np.int64)
    for _ in range(EASING_ROUNDS):
        before = path.copy()
        k = 1
        while k < len(path) - 1:
            a, c, b = path[k - 1], path[k].copy(), path[k + 1]
            answer = look_up(a, b, edges, answers)
            if answer == ASK:
                return path[:0].copy()
            if answer == CLEAR:
                path = _leave_out(path, k)
                continue
            least = _seconds(a, c, b, v, acc, zone)
            for trial in range(len(PULLS) + 2 * joints * len(JOINT_STEPS)):
                if trial < len(PULLS):
                    into, out = _seconds(a, a, c, v, acc, zone), _seconds(c, c, b, v, acc, zone)
                    onto = a + (b - a) * (into / max(into + out, 1e-9))
                    moved = c + PULLS[trial] * (onto - c)
                else:
                    number = trial - len(PULLS)
                    step = JOINT_STEPS[number // (2 * joints)] * (1.0 - 2.0 * (number % 2))
                    moved = c.copy()
                    moved[number // 2 % joints] += step
                seconds = _seconds(a, moved, b, v, acc, zone)
                if seconds > least - LEAST_GAIN:
                    continue
                answer = _is_open(a, moved, b, zone, edges, answers, last)
                if answer == ASK:
                    return path[:0].copy()
                if answer == CLEAR:
                    c, least = moved, seconds
            write_row(path, k, c)
            k += 1
        if len(path) == len(before) and np.all(path == before):
            break  # the next round would ask the same
    return path

"""Two arms, each on a way of its own at any speed: checked in one compiled piece.

The same halving as of one curve in `sweep`, over two parameters: how far each arm has come.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.sweeping.edges import Edges
from workbench.planning.collision.sweeping.look import ANY, FIRST, IS_CLEAR, TOO_LONG, look_at
from workbench.planning.compiled import njit_in_place


@njit(cache=True)
def ways_met(first: Floats, second: Floats, most: int, edges: Edges) -> tuple[int, Ints, int]:
    """Check two chains of curves for collisions, each curve of the one with each of the other.

    Args:
        first: control points (k, 3, n) [rad] of the curves of one arm.
        second: those (l, 3, m) [rad] of the other.
        most: largest number of states to check without a result.
        edges: joints of the first arm, then of the second (n + m,), and the pairs to check.

    Returns:
        A pair that touches at `edges.scratch.q`, `IS_CLEAR` if there is none, or `TOO_LONG` after
        `most` states; the curves (2,) of that state; the number of checked states.
    """
    ways, n = (first, second), first.shape[2]
    scratch, count, curves = edges.scratch, len(edges.groups.order), np.zeros(2, np.int64)
    if count > len(scratch.open_pairs):
        return TOO_LONG, curves, 0
    for k in range(count):
        scratch.open_pairs[k] = -1 - edges.groups.order[k]
    # Where arms meet they mostly do so where a way begins or ends.
    for ends in range(4):
        for arm in range(2):
            share = float((ends // 2, ends % 2)[arm] * len(ways[arm]))
            curves[arm], _ = _put(ways[arm], share, share, n * arm, edges)
        found, _, _ = _look(FIRST, count, count, edges)
        if found != IS_CLEAR:
            return found, curves, ends + 1
    # How far each arm has come, from and to, in curves: what waits to be looked at.
    shares = np.empty((2 * most + 3, 2, 2))
    begins, sizes = np.empty(len(shares), np.int64), np.empty(len(shares), np.int64)
    for arm in range(2):
        shares[0, arm, 0], shares[0, arm, 1] = 0.0, len(ways[arm])
    begins[0], sizes[0] = 0, count
    used, last, at, spans = count, 1, 0, np.empty(2)
    while at < last:
        for arm in range(2):
            a, b = shares[at, arm, 0], shares[at, arm, 1]
            curves[arm], spans[arm] = _put(ways[arm], a, b, n * arm, edges)
        found, kept, furthest = _look(begins[at], sizes[at], used, edges)
        at += 1
        if found != IS_CLEAR:
            return found, curves, at + 4
        if kept > used and furthest > edges.resolution:
            if at > most:
                return TOO_LONG, curves, at + 4
            longer = 0 if spans[0] >= spans[1] else 1
            middle = _middle(shares[at - 1, longer, 0], shares[at - 1, longer, 1])
            for half in range(2):
                for arm in range(2):
                    for k in range(2):
                        shares[last + half, arm, k] = shares[at - 1, arm, k]
                shares[last + half, longer, 1 - half] = middle
                begins[last + half], sizes[last + half] = used, kept - used
            last, used = last + 2, kept
    return IS_CLEAR, curves, at + 4


@njit_in_place
def _look(begin: int, asked: int, used: int, edges: Edges) -> tuple[int, int, float]:
    return look_at(
        begin, asked, used, edges.margins, edges.commons, edges.model, edges.groups, edges.scratch,
        ANY,
    )  # fmt: skip


@njit_in_place
def _middle(begin: float, end: float) -> float:
    """The middle of a piece of a chain: of more than one curve, between two of them."""
    middle = (begin + end) / 2
    return np.floor(middle) if end - begin > 1.0 else middle


@njit(cache=True)
def _put(way: Floats, begin: float, end: float, first: int, edges: Edges) -> tuple[int, float]:
    """Put an arm into the middle of a piece of its way (k, 3, n) [rad].

    Args:
        way: control points of its curves.
        begin: where the piece begins, in curves.
        end: where it ends: on the same curve, or between two.
        first: number of the arm's first joint among those of the edges.
        edges: whose scratch is written to.

    Returns:
        The number of the curve there, and how far any joint may be from there [rad] at most.
    """
    q, d, columns = edges.scratch.q, edges.scratch.d, edges.columns
    ahead, bent = edges.scratch.ahead, edges.scratch.bent
    middle = _middle(begin, end)
    curve = min(int(middle), len(way) - 1)
    t, most = middle - curve, 0.0
    for i in range(way.shape[2]):
        m = _at(way, curve, i, t, t)
        span = 0.0
        if end - begin > 1.0:
            for k in range(int(begin), int(end)):
                for j in range(3):
                    span = max(span, abs(way[k, j, i] - m))
        elif end > begin:
            low, high = begin - curve, end - curve
            for s, u in ((low, low), (low, high), (high, high)):
                span = max(span, abs(_at(way, curve, i, s, u) - m))
        q[columns[first + i]], d[columns[first + i]] = m, span
        # The two go on at any speeds: how they move against each other is not known.
        ahead[columns[first + i]], bent[columns[first + i]] = 0.0, span
        most = max(most, span)
    return curve, most


@njit_in_place
def _at(way: Floats, curve: int, i: int, s: float, u: float) -> float:
    """The control point of joint i between the places s and u on a curve; where equal, the curve.

    Source: L. Ramshaw, "Blossoms are polar forms", Computer Aided Geometric Design, 1989.
    """
    a, b, c = way[curve, 0, i], way[curve, 1, i], way[curve, 2, i]
    return (1 - s) * (1 - u) * a + (s * (1 - u) + u * (1 - s)) * b + s * u * c

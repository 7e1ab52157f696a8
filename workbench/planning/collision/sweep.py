"""The continuous check of a chain of curves in one compiled piece, for the planner.

The same halving as in `motion`, with distances by `gjk` instead of Coal.  The proof
does not use it: what the planner found is measured again with another library.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.balls import from_balls
from workbench.planning.collision.bounds import Boxes, gather_close, place_bodies
from workbench.planning.collision.gjk import CLEAR, TOUCHES, UNCLEAR, Cores, side
from workbench.planning.kinematics.robot import Tree

LOOSENESS = 0.005
"""[m] By about this much the lower bound of a distance falls short; only a matter of speed."""

MOST_PENDING = 512
"""Halves of curves waiting to be looked at."""

MOST_OPEN = 1 << 14
"""Pairs left open by all looks of a curve."""

IS_CLEAR, TOO_LONG = -1, -2


class Model(NamedTuple):
    """Kinematics, boxes and cores of all bodies, and the pairs of them.

    `first` and `second` (k,) are indices of bodies: the two of each pair.
    """

    tree: Tree
    boxes: Boxes
    first: Ints
    second: Ints
    cores: Cores


@njit(cache=True)
def _halve(pending: Floats, at: int, last: int) -> None:
    """Put both halves of the curve at `at` behind the last one pending."""
    for i in range(pending.shape[2]):
        a, b, e = pending[at, 0, i], pending[at, 1, i], pending[at, 2, i]
        m = (a + 2.0 * b + e) / 4.0
        pending[last, 0, i], pending[last, 1, i], pending[last, 2, i] = a, (a + b) / 2, m
        pending[last + 1, 0, i], pending[last + 1, 1, i] = m, (b + e) / 2
        pending[last + 1, 2, i] = e


@njit(cache=True)
def swept(
    points: Floats,
    columns: Ints,
    base: Floats,
    resolution: float,
    among: Ints,
    margins: Floats,
    commons: Ints,
    model: Model,
) -> tuple[int, int, Floats, int]:
    """Go through a chain of curves, one after the other, until a pair touches.

    Args:
        points: their control points (k, 3, n).
        columns: places of the n joints in the whole configuration.
        base: whole configuration (nq,) of the others.
        resolution: [m] see `motion`.
        among: pairs that are looked at; see `bounds.close_pairs`, as the next two.
        margins: see there.
        commons: see there.
        model: of what moves.

    Returns:
        How many curves are clear; the pair that touches on the next one with the configuration
        (n,) there, or `IS_CLEAR` when there is no next one, or `TOO_LONG` when that takes more
        room than there is; and how many states were looked at.
    """
    tree, boxes, first, second, cores = model
    n, nq = len(columns), len(base)
    q, d = base.copy(), np.zeros(nq)
    joints, bodies = len(tree.parents), len(boxes.joint)
    R_j, p_j, z_j = np.empty((joints, 3, 3)), np.empty((joints, 3)), np.empty((joints, 3))
    R, c, travel = np.empty((bodies, 3, 3)), np.empty((bodies, 3)), np.empty(bodies)
    pairs = np.empty(len(among), np.int64)
    moves, lower = np.empty(len(among)), np.empty(len(among))
    pending = np.empty((MOST_PENDING, 3, n))
    begins, sizes = np.empty(MOST_PENDING, np.int64), np.empty(MOST_PENDING, np.int64)
    open_pairs, others = np.empty(MOST_OPEN, np.int64), np.empty(len(among), np.int64)
    W, middle = np.empty((5, 3)), np.empty(n)
    looks = 0
    if len(among) > MOST_OPEN:
        return 0, TOO_LONG, middle, looks
    # Loops, here and below: numba takes seconds to compile the assignment of an array to a slice.
    for k in range(len(among)):
        open_pairs[k] = among[k]
    for curve in range(len(points)):
        for k in range(3):
            for i in range(n):
                pending[0, k, i] = points[curve, k, i]
        begins[0], sizes[0] = 0, len(among)
        used, last, at = len(among), 1, 0
        while at < last:
            for i in range(n):
                p0_, p1_, p2_ = pending[at, 0, i], pending[at, 1, i], pending[at, 2, i]
                m = (p0_ + 2.0 * p1_ + p2_) / 4.0
                middle[i] = m
                q[columns[i]] = m
                d[columns[i]] = max(abs(p0_ - m), abs(p2_ - m))
            place_bodies(tree, boxes, q, d, R_j, p_j, z_j, R, c, travel)
            looks += 1
            # Pairs of a ball have a formula: they are looked at first, and most often meet first.
            touching, rest, kept, furthest = from_balls(
                tree, boxes, d, first, second, open_pairs, int(begins[at]), int(sizes[at]), margins,
                commons, cores, p_j, z_j, R, c, travel, others, used,
            )  # fmt: skip
            if touching >= 0:
                return curve, touching, middle, looks
            if kept < 0:
                return curve, TOO_LONG, middle, looks
            found = gather_close(
                tree, boxes, d, first, second, others, rest, margins, commons, 0.0, p_j, z_j, R, c,
                travel, pairs, moves, lower,
            )  # fmt: skip
            for k in range(found):
                pair, move = pairs[k], moves[k]
                needed = margins[pair]
                # Clear now, and too far to go to be cleared by measuring: not worth it.
                answer = UNCLEAR
                if not needed <= lower[k] < needed + move / 2 - LOOSENESS:
                    answer = side(
                        int(first[pair]), int(second[pair]), R, c, cores, float(needed),
                        float(needed + move), W,
                    )  # fmt: skip
                if answer == TOUCHES:
                    return curve, int(pair), middle, looks
                if answer == CLEAR:
                    continue
                if kept >= MOST_OPEN:
                    return curve, TOO_LONG, middle, looks
                open_pairs[kept] = pair
                kept += 1
                furthest = max(furthest, move)
            if kept > used and furthest > resolution:
                if last + 2 > MOST_PENDING:
                    return curve, TOO_LONG, middle, looks
                _halve(pending, at, last)
                begins[last], sizes[last] = used, kept - used
                begins[last + 1], sizes[last + 1] = used, kept - used
                last, used = last + 2, kept
            at += 1
    return len(points), IS_CLEAR, middle, looks

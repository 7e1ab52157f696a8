"""Pairs of which one body is a ball: how far apart they are has a formula.

The distance of a point from a ball, a box or an upright cylinder, less the ball's radius: exact, so
that there is nothing to bound and nothing to search.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.bounds import Boxes, travel_from
from workbench.planning.collision.gjk import BALL, BOX, CYLINDER, Cores
from workbench.planning.kinematics.robot import Tree


@njit(cache=True)
def ball_gap(a: int, b: int, R: Floats, c: Floats, half: Floats, cores: Cores) -> float:
    """Distance [m] of the ball a from body b; where they overlap, not above zero.

    Args:
        a: a ball.
        b: a ball, a box or a cylinder.
        R: rotations (b, 3, 3) of all bodies.
        c: centres (b, 3) of all bodies [m].
        half: half sizes (b, 3) of their boxes [m].
        cores: of all bodies.
    """
    x, y, z = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
    swell = cores.swell[a] + cores.swell[b]
    if cores.form[b] == BALL:
        return float(np.sqrt(x * x + y * y + z * z) - swell)
    u = R[b, 0, 0] * x + R[b, 1, 0] * y + R[b, 2, 0] * z
    v = R[b, 0, 1] * x + R[b, 1, 1] * y + R[b, 2, 1] * z
    w = R[b, 0, 2] * x + R[b, 1, 2] * y + R[b, 2, 2] * z
    if cores.form[b] == BOX:
        u, v, w = abs(u) - half[b, 0], abs(v) - half[b, 1], abs(w) - half[b, 2]
    else:
        u = np.sqrt(u * u + v * v) - cores.radius[b]
        v, w = -1e9, abs(w) - cores.length[b]
    inside = max(u, v, w)
    if inside <= 0.0:
        return float(inside - swell)
    u, v, w = max(u, 0.0), max(v, 0.0), max(w, 0.0)
    return float(np.sqrt(u * u + v * v + w * w) - swell)


@njit(cache=True)
def from_balls(
    tree: Tree,
    boxes: Boxes,
    d: Floats,
    first: Ints,
    second: Ints,
    open_pairs: Ints,
    begin: int,
    asked: int,
    margins: Floats,
    commons: Ints,
    cores: Cores,
    p_j: Floats,
    z_j: Floats,
    R: Floats,
    c: Floats,
    travel: Floats,
    others: Ints,
    used: int,
) -> tuple[int, int, int, float]:
    """Tell pairs of balls from the others, and look at them; arguments as in `gather_close`.

    Of `open_pairs` (k,) those numbered from `begin` on, `asked` of them, are looked at.  What the
    motion may bring closer than its margin is written behind the first `used`; pairs that have no
    formula go to `others` (k,), in their order.  `p_j`, `z_j` (j, 3) [m], `R`, `c` [m] and `travel`
    [m] are what `place_bodies` has written; `margins` (k,) are in m, `d` (nq,) in rad and m.

    Returns:
        A pair that touches, or -1; how many others there are; how many open pairs are in use, or -1
        when there is no more room; the largest motion bound of those that were kept [m].
    """
    half, radius, form = boxes.half, boxes.radius, cores.form
    rest, kept, furthest = 0, used, 0.0
    for at in range(begin, begin + asked):
        k = open_pairs[at]
        a, b = int(first[k]), int(second[k])
        if form[a] == BALL:
            known = form[b] == BALL or form[b] == BOX or form[b] == CYLINDER
        else:
            known = form[b] == BALL and (form[a] == BOX or form[a] == CYLINDER)
            a, b = b, a
        if not known:
            others[rest] = k
            rest += 1
            continue
        move = travel[a] + travel[b]
        reach = radius[a] + radius[b] + margins[k] + move
        x, y, w = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
        if reach > 0 and x * x + y * y + w * w > reach * reach:
            continue
        apart = ball_gap(a, b, R, c, half, cores)
        if apart < margins[k]:
            return int(k), rest, kept, furthest
        if apart >= margins[k] + move:
            continue
        if commons[k] != 0:
            common = int(commons[k])
            move = travel_from(a, common, tree, boxes, p_j, z_j, c, d)
            move += travel_from(b, common, tree, boxes, p_j, z_j, c, d)
            if apart >= margins[k] + move:
                continue
        if kept >= len(open_pairs):
            return -1, rest, -1, furthest
        open_pairs[kept] = k
        kept += 1
        furthest = max(furthest, move)
    return -1, rest, kept, furthest

"""Compiled bounds: which pairs can possibly be close, and how far a motion can bring them.

Two facts make checking cheap and proofs continuous.

*Distance from below.*  Each body lies in a ball and in an oriented box.  The distance of one
body's ball centre to the other's box, less the ball's radius, never exceeds the true distance.

*Motion from above.*  Move from q to q + d one joint at a time, outermost first.  A point at
distance r from the axis of joint i moves at most |d_i| (r + s), where s is how far the outer
joints have moved it already.  Joints that carry both bodies of a pair change nothing between
them.  (The chain bound of Schwarzer, Saha and Latombe, "Exact collision checking of robot
paths", 2002, tightened by taking r at q.)
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.kinematics.robot import Tree

# The loops below index into whole arrays instead of passing rows: a slice costs an allocation,
# and these run some hundred thousand times for one plan.


@njit(cache=True)
def _joint_poses(
    parents: Ints,
    R0: Floats,
    p0: Floats,
    axes: Floats,
    slides: Floats,
    q: Floats,
    R: Floats,
    p: Floats,
    z: Floats,
) -> None:
    """Write rotation R (j, 3, 3), position p and axis z (j, 3) of all joints in the world."""
    for i in range(3):
        for k in range(3):
            R[0, i, k] = 1.0 if i == k else 0.0
        p[0, i] = 0.0
        z[0, i] = 0.0
    M, T = np.empty((3, 3)), np.empty((3, 3))
    for j in range(1, len(parents)):
        u = parents[j]
        for i in range(3):
            p[j, i] = p[u, i]
            for k in range(3):
                p[j, i] += R[u, i, k] * p0[j, k]
                M[i, k] = (
                    R[u, i, 0] * R0[j, 0, k] + R[u, i, 1] * R0[j, 1, k] + R[u, i, 2] * R0[j, 2, k]
                )
        for i in range(3):
            z[j, i] = M[i, 0] * axes[j, 0] + M[i, 1] * axes[j, 1] + M[i, 2] * axes[j, 2]
        if slides[j] > 0.5:
            for i in range(3):
                p[j, i] += z[j, i] * q[j - 1]
                for k in range(3):
                    R[j, i, k] = M[i, k]
            continue
        x, y, w = axes[j, 0], axes[j, 1], axes[j, 2]
        sin, cos = np.sin(q[j - 1]), np.cos(q[j - 1])
        d = 1.0 - cos
        T[0, 0], T[0, 1], T[0, 2] = cos + x * x * d, x * y * d - w * sin, x * w * d + y * sin
        T[1, 0], T[1, 1], T[1, 2] = y * x * d + w * sin, cos + y * y * d, y * w * d - x * sin
        T[2, 0], T[2, 1], T[2, 2] = w * x * d - y * sin, w * y * d + x * sin, cos + w * w * d
        for i in range(3):
            for k in range(3):
                R[j, i, k] = M[i, 0] * T[0, k] + M[i, 1] * T[1, k] + M[i, 2] * T[2, k]


@njit(cache=True)
def _gap(a: int, b: int, R: Floats, c: Floats, half: Floats, radius: Floats) -> float:
    """Distance from the ball of body a to the box of body b; negative inside."""
    total, inside = 0.0, -1e9
    x, y, w = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
    for i in range(3):
        over = abs(R[b, 0, i] * x + R[b, 1, i] * y + R[b, 2, i] * w) - half[b, i]
        inside = max(inside, over)
        if over > 0:
            total += over * over
    return float((np.sqrt(total) if total > 0 else inside) - radius[a])


@njit(cache=True)
def _box_gap(a: int, b: int, R: Floats, c: Floats, half: Floats) -> float:
    """Largest gap of the boxes of two bodies over 6 face and 9 edge axes: never too large."""
    tx, ty, tz = c[b, 0] - c[a, 0], c[b, 1] - c[a, 1], c[b, 2] - c[a, 2]
    best = -1e9
    for kind in range(15):
        if kind < 3:
            x, y, w = R[a, 0, kind], R[a, 1, kind], R[a, 2, kind]
        elif kind < 6:
            x, y, w = R[b, 0, kind - 3], R[b, 1, kind - 3], R[b, 2, kind - 3]
        else:
            i, j = (kind - 6) // 3, (kind - 6) % 3
            x = R[a, 1, i] * R[b, 2, j] - R[a, 2, i] * R[b, 1, j]
            y = R[a, 2, i] * R[b, 0, j] - R[a, 0, i] * R[b, 2, j]
            w = R[a, 0, i] * R[b, 1, j] - R[a, 1, i] * R[b, 0, j]
            norm = np.sqrt(x * x + y * y + w * w)
            if norm < 1e-6:
                continue
            x, y, w = x / norm, y / norm, w / norm
        reach = 0.0
        for i in range(3):
            reach += abs(R[a, 0, i] * x + R[a, 1, i] * y + R[a, 2, i] * w) * half[a, i]
            reach += abs(R[b, 0, i] * x + R[b, 1, i] * y + R[b, 2, i] * w) * half[b, i]
        best = max(best, abs(tx * x + ty * y + tz * w) - reach)
    return best


@njit(cache=True)
def _travel(
    g: int,
    common: int,
    joint: Ints,
    parents: Ints,
    slides: Floats,
    p: Floats,
    z: Floats,
    c: Floats,
    radius: Floats,
    d: Floats,
) -> float:
    """How far body g can move relative to joint `common` when the joints change by up to d."""
    moved = 0.0
    j = joint[g]
    while j != common and j != 0:
        step = d[j - 1]
        if step > 0.0:
            if slides[j] > 0.5:
                moved += step
            else:
                x, y, w = c[g, 0] - p[j, 0], c[g, 1] - p[j, 1], c[g, 2] - p[j, 2]
                along = x * z[j, 0] + y * z[j, 1] + w * z[j, 2]
                r = np.sqrt(max(x * x + y * y + w * w - along * along, 0.0)) + radius[g]
                moved += step * (r + moved)
        j = parents[j]
    return float(moved)


class Boxes(NamedTuple):
    """The bodies as arrays for compiled code: each lies in an oriented box and in a ball.

    `joint` (b,) carries it; `R` (b, 3, 3) and `c` (b, 3) [m] place the box in that joint's frame;
    `half` (b, 3) [m] are half its sizes; `radius` (b,) [m] is that of the ball around `c`.
    """

    joint: Ints
    R: Floats
    c: Floats
    half: Floats
    radius: Floats


@njit(cache=True)
def travel_from(
    g: int, common: int, tree: Tree, boxes: Boxes, p: Floats, z: Floats, c: Floats, d: Floats
) -> float:
    """How far [m] body g can move relative to joint `common` when joints change by `d` (nq,).

    `p` (j, 3) [m] and `z` (j, 3) are positions and axes of joints, `c` (b, 3) [m] centres of
    bodies, as `place_bodies` has written them.
    """
    return _travel(g, common, boxes.joint, tree.parents, tree.slides, p, z, c, boxes.radius, d)


@njit(cache=True)
def close_pairs(
    tree: Tree,
    boxes: Boxes,
    q: Floats,
    d: Floats,
    first: Ints,
    second: Ints,
    among: Ints,
    margins: Floats,
    commons: Ints,
    extra: float,
) -> tuple[Ints, Floats, Floats]:
    """Pairs, among those asked about, that may come closer than their margin within the motion.

    Args:
        tree: the joints.
        boxes: the bodies.
        q: configuration (nq,).
        d: largest change of each joint (nq,), zero for one state.
        first: per pair its one body.
        second: per pair its other body.
        among: numbers of the pairs to look at.
        margins: per pair the distance to keep [m].
        commons: per pair the deepest joint that carries both bodies.
        extra: report pairs up to this much further away [m].

    Returns:
        Pair numbers, their motion bounds [m] and lower distance bounds [m], nearest first.
    """
    joints, count = len(tree.parents), len(boxes.joint)
    R_j, p_j, z_j = np.empty((joints, 3, 3)), np.empty((joints, 3)), np.empty((joints, 3))
    R, c, travel = np.empty((count, 3, 3)), np.empty((count, 3)), np.empty(count)
    place_bodies(tree, boxes, q, d, R_j, p_j, z_j, R, c, travel)
    pairs = np.empty(len(among), np.int64)
    moves, lower = np.empty(len(among)), np.empty(len(among))
    found = gather_close(
        tree, boxes, d, first, second, among, len(among), margins, commons, extra, p_j, z_j, R, c,
        travel, pairs, moves, lower,
    )  # fmt: skip
    order = np.argsort(lower[:found])
    return pairs[:found][order], moves[:found][order], lower[:found][order]


@njit(cache=True)
def place_bodies(
    tree: Tree,
    boxes: Boxes,
    q: Floats,
    d: Floats,
    R_j: Floats,
    p_j: Floats,
    z_j: Floats,
    R: Floats,
    c: Floats,
    travel: Floats,
) -> None:
    """Write where joints and bodies are at `q`, and how far bodies can move, into the last six.

    `q` and `d` (nq,) [rad, m] as in `close_pairs`.  Of joints `R_j` (j, 3, 3), `p_j` (j, 3) [m] and
    axes `z_j` (j, 3); of bodies `R` (b, 3, 3), centres `c` (b, 3) [m] and `travel` (b,) [m].
    """
    joint, R_g, c_g = boxes.joint, boxes.R, boxes.c
    _joint_poses(tree.parents, tree.R, tree.p, tree.axes, tree.slides, q, R_j, p_j, z_j)
    for g in range(len(joint)):
        j = joint[g]
        for i in range(3):
            c[g, i] = p_j[j, i]
            for k in range(3):
                c[g, i] += R_j[j, i, k] * c_g[g, k]
                R[g, i, k] = (
                    R_j[j, i, 0] * R_g[g, 0, k]
                    + R_j[j, i, 1] * R_g[g, 1, k]
                    + R_j[j, i, 2] * R_g[g, 2, k]
                )
        travel[g] = _travel(g, 0, joint, tree.parents, tree.slides, p_j, z_j, c, boxes.radius, d)


@njit(cache=True)
def gather_close(
    tree: Tree,
    boxes: Boxes,
    d: Floats,
    first: Ints,
    second: Ints,
    among: Ints,
    asked: int,
    margins: Floats,
    commons: Ints,
    extra: float,
    p_j: Floats,
    z_j: Floats,
    R: Floats,
    c: Floats,
    travel: Floats,
    pairs: Ints,
    moves: Floats,
    lower: Floats,
) -> int:
    """Write what `close_pairs` returns, unsorted, into the last three arguments.

    Bodies are where `place_bodies` has them; `pairs` (k,) are indices, `moves` and `lower` (k,)
    are in [m].  The first `asked` numbers of `among` are looked at.  Returns how many pairs were
    written.
    """
    parents, slides = tree.parents, tree.slides
    joint, half, radius = boxes.joint, boxes.half, boxes.radius
    found = 0
    for at in range(asked):
        k = among[at]
        a, b = int(first[k]), int(second[k])
        move = travel[a] + travel[b]
        limit = margins[k] + move + extra
        reach = radius[a] + radius[b] + limit
        x, y, w = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
        if reach > 0 and x * x + y * y + w * w > reach * reach:
            continue
        if commons[k] != 0:
            move = _travel(a, int(commons[k]), joint, parents, slides, p_j, z_j, c, radius, d)
            move += _travel(b, int(commons[k]), joint, parents, slides, p_j, z_j, c, radius, d)
            limit = margins[k] + move + extra
        apart = max(_gap(a, b, R, c, half, radius), _gap(b, a, R, c, half, radius))
        if apart < limit:
            apart = max(apart, _box_gap(a, b, R, c, half))
            if apart < limit:
                pairs[found], moves[found], lower[found] = k, move, apart
                found += 1
    return found


def box_of(points: Floats) -> tuple[Floats, Floats]:
    """Centre (3,) and half sizes (3,) of the axis-aligned box around points (n, 3), all [m]."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, (high - low) / 2

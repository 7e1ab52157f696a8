"""Compiled bounds: which pairs can be close, and how far a motion can bring them.

Three bounds make checks cheap and proofs continuous.

*Distance from below.*  Each body lies in a ball and in an oriented box.  The distance of one
body's ball centre to the other's box, less the ball's radius, never exceeds the true distance.

*Motion from above.*  Move from q to q + d one joint at a time, outermost first.  A point at
distance r from the axis of joint i moves at most |d_i| (r + s).  Here s is the point's motion by
the outer joints.  Joints that carry both bodies of a pair change nothing between
them.  (The chain bound of Schwarzer, Saha and Latombe, "Exact collision checking of robot
paths", 2002, tightened by taking r at q.)

*Along a direction.*  Bodies on two sides of a plane stay apart until one passes through it.  A body
moves towards the plane by its velocity times the path, plus a bound for the change of velocity.
That is far less than the chain bound where a body moves past something.  (Directional motion
bounds as in X. Zhang, S. Redon, M. Lee and Y. J. Kim, "Continuous collision detection for
articulated models using Taylor models and temporal culling", 2007.  Here they are of first order,
with a bound of the rest.)
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.compiled import njit_in_place
from workbench.planning.kinematics.robot import JointTree

# The loops below index into whole arrays instead of passing rows: a slice costs an allocation,
# and these run some hundred thousand times for one plan.


@njit_in_place
def joint_pose(j: int, tree: JointTree, q: Floats, R: Floats, p: Floats, z: Floats) -> None:
    """Write rotation R (j, 3, 3), position p (j, 3) [m] and axis z (j, 3) of one joint.

    In the world; those of the joint before it have to be there; `q` (nq,) is in rad and m.
    """
    R0, p0, axes, u = tree.R, tree.p, tree.axes, tree.parents[j]
    for i in range(3):
        p[j, i] = p[u, i]
        for k in range(3):
            p[j, i] += R[u, i, k] * p0[j, k]
            R[j, i, k] = (
                R[u, i, 0] * R0[j, 0, k] + R[u, i, 1] * R0[j, 1, k] + R[u, i, 2] * R0[j, 2, k]
            )
    for i in range(3):
        z[j, i] = R[j, i, 0] * axes[j, 0] + R[j, i, 1] * axes[j, 1] + R[j, i, 2] * axes[j, 2]
    if tree.slides[j] > 0.5:
        for i in range(3):
            p[j, i] += z[j, i] * q[j - 1]
        return
    x, y, w = axes[j, 0], axes[j, 1], axes[j, 2]
    sin, cos = np.sin(q[j - 1]), np.cos(q[j - 1])
    d = 1.0 - cos
    t00, t01, t02 = cos + x * x * d, x * y * d - w * sin, x * w * d + y * sin
    t10, t11, t12 = y * x * d + w * sin, cos + y * y * d, y * w * d - x * sin
    t20, t21, t22 = w * x * d - y * sin, w * y * d + x * sin, cos + w * w * d
    for i in range(3):
        a, b, e = R[j, i, 0], R[j, i, 1], R[j, i, 2]
        R[j, i, 0] = a * t00 + b * t10 + e * t20
        R[j, i, 1] = a * t01 + b * t11 + e * t21
        R[j, i, 2] = a * t02 + b * t12 + e * t22


@njit_in_place
def ball_to_box(
    x: float, y: float, w: float, radius: float, b: int, R: Floats, c: Floats, half: Floats
) -> float:
    """Distance [m] from a ball at (x, y, w) [m] to the box of body b; negative inside."""
    total, inside = 0.0, -1e9
    x, y, w = x - c[b, 0], y - c[b, 1], w - c[b, 2]
    for i in range(3):
        over = abs(R[b, 0, i] * x + R[b, 1, i] * y + R[b, 2, i] * w) - half[b, i]
        inside = max(inside, over)
        if over > 0:
            total += over * over
    return float((np.sqrt(total) if total > 0 else inside) - radius)


@njit_in_place
def out_of_box(
    x: float, y: float, z: float, b: int, R: Floats, c: Floats, half: Floats
) -> tuple[float, float, float, float]:
    """Way (3 numbers) and distance [m] from the box of body b to (x, y, z) [m]; inside all zero."""
    x, y, z = x - c[b, 0], y - c[b, 1], z - c[b, 2]
    u, v, w, total = 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        along = R[b, 0, i] * x + R[b, 1, i] * y + R[b, 2, i] * z
        over = abs(along) - half[b, i]
        if over > 0.0:
            total += over * over
            over = over if along > 0.0 else -over
            u, v, w = u + over * R[b, 0, i], v + over * R[b, 1, i], w + over * R[b, 2, i]
    return u, v, w, np.sqrt(total)


@njit_in_place
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


@njit_in_place
def lower_bound(
    a: int, b: int, R: Floats, c: Floats, half: Floats, radius: Floats, limit: float
) -> float:
    """A lower bound of the distance [m] of two bodies; the search ends when it reaches `limit`.

    `R` (b, 3, 3) and `c` (b, 3) [m] are the poses of the bodies' boxes, `half` (b, 3) [m] their
    half lengths.  `radius` (b,) [m] is that of the balls around the same centres.
    """
    apart = max(
        ball_to_box(c[a, 0], c[a, 1], c[a, 2], float(radius[a]), b, R, c, half),
        ball_to_box(c[b, 0], c[b, 1], c[b, 2], float(radius[b]), a, R, c, half),
    )
    return apart if apart >= limit else max(apart, _box_gap(a, b, R, c, half))


@njit_in_place
def walk(
    row: int,
    x: float,
    y: float,
    z: float,
    radius: float,
    joint: int,
    tree: JointTree,
    d: Floats,
    p_j: Floats,
    z_j: Floats,
    travel: Floats,
) -> None:
    """Write how far a ball at (x, y, z) [m] on a joint can move, relative to each joint before it.

    `d` (nq,) [rad, m] is how far each joint may move, `p_j` (j, 3) [m] and `z_j` (j, 3) where
    joints are and along what; written is `travel[row]` (j,) [m], the world's being joint 0.
    """
    moved, j = 0.0, joint
    while j != 0:
        step = d[j - 1]
        if step > 0.0:
            if tree.slides[j] > 0.5:
                moved += step
            else:
                u, v, w = x - p_j[j, 0], y - p_j[j, 1], z - p_j[j, 2]
                along = u * z_j[j, 0] + v * z_j[j, 1] + w * z_j[j, 2]
                r = np.sqrt(max(u * u + v * v + w * w - along * along, 0.0)) + radius
                moved += step * (r + moved)
        j = tree.parents[j]
        travel[row, j] = moved


class PairDrift(NamedTuple):
    """Relative motion of two bodies from a state on, seen from the joint that carries both.

    `x`, `y`, `z` [m] are the first-order motion of the first body's centre relative to the second.
    `a_...` and `b_...` [rad] are their first-order rotations.  `rest` [m] bounds the further
    motion of any point towards the other body, `most` [m] how much nearer they can come at all.
    """

    x: float
    y: float
    z: float
    a_x: float
    a_y: float
    a_z: float
    b_x: float
    b_y: float
    b_z: float
    rest: float
    most: float


@njit_in_place
def nearing(
    drift: PairDrift, a: int, b: int, x: float, y: float, z: float, R: Floats, half: Floats
) -> float:
    """How much nearer [m] two bodies can come along the direction (x, y, z), whose length is 1.

    `R` (b, 3, 3) and `half` (b, 3) [m] are those of the boxes of all bodies.
    """
    come = abs(x * drift.x + y * drift.y + z * drift.z) + drift.rest
    come += _swept_by_turn(a, x, y, z, drift.a_x, drift.a_y, drift.a_z, R, half)
    come += _swept_by_turn(b, x, y, z, drift.b_x, drift.b_y, drift.b_z, R, half)
    return min(come, drift.most)


@njit_in_place
def _swept_by_turn(
    g: int, x: float, y: float, z: float, u: float, v: float, w: float, R: Floats, half: Floats
) -> float:
    """How far [m] a body's box comes along (x, y, z) while it turns by (u, v, w) [rad], at most."""
    if u == 0.0 and v == 0.0 and w == 0.0:
        return 0.0
    i, j, k = y * w - z * v, z * u - x * w, x * v - y * u
    far = 0.0
    for m in range(3):
        far += abs(R[g, 0, m] * i + R[g, 1, m] * j + R[g, 2, m] * k) * half[g, m]
    return far


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
def close_pairs(
    tree: JointTree,
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
    R, c = np.empty((count, 3, 3)), np.empty((count, 3))
    travel = np.zeros((count, joints))
    place_bodies(tree, boxes, q, d, R_j, p_j, z_j, R, c, travel)
    pairs = np.empty(len(among), np.int64)
    moves, lower = np.empty(len(among)), np.empty(len(among))
    found = gather_close(
        tree, boxes, d, first, second, among, len(among), margins, commons, extra, p_j, z_j, R, c,
        travel, pairs, moves, lower,
    )  # fmt: skip
    order = np.argsort(lower[:found])
    return pairs[:found][order], moves[:found][order], lower[:found][order]


@njit_in_place
def place_bodies(
    tree: JointTree,
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
    axes `z_j` (j, 3); of bodies `R` (b, 3, 3), centres `c` (b, 3) [m] and `travel` (b, j) [m].
    """
    joint, R_g, c_g = boxes.joint, boxes.R, boxes.c
    for i in range(3):
        for k in range(3):
            R_j[0, i, k] = 1.0 if i == k else 0.0
        p_j[0, i] = 0.0
        z_j[0, i] = 0.0
    for j in range(1, len(tree.parents)):
        joint_pose(j, tree, q, R_j, p_j, z_j)
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
        walk(g, c[g, 0], c[g, 1], c[g, 2], boxes.radius[g], j, tree, d, p_j, z_j, travel)


@njit_in_place
def gather_close(
    tree: JointTree,
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
    are in [m].  The first `asked` numbers of `among` are checked.  Returns how many pairs were
    written.
    """
    half, radius = boxes.half, boxes.radius
    found = 0
    for at in range(asked):
        k = among[at]
        a, b = int(first[k]), int(second[k])
        move = travel[a, 0] + travel[b, 0]
        limit = margins[k] + move + extra
        reach = radius[a] + radius[b] + limit
        x, y, w = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
        if reach > 0 and x * x + y * y + w * w > reach * reach:
            continue
        if commons[k] != 0:
            move = travel[a, commons[k]] + travel[b, commons[k]]
            limit = margins[k] + move + extra
        apart = lower_bound(a, b, R, c, half, radius, float(limit))
        if apart < limit:
            pairs[found], moves[found], lower[found] = k, move, apart
            found += 1
    return found


def box_of(points: Floats) -> tuple[Floats, Floats]:
    """Centre (3,) and half sizes (3,) of the axis-aligned box around points (n, 3), all [m]."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, (high - low) / 2

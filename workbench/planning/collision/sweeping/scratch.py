"""Scratch for one sweep: where joints and bodies are at the state checked.

What does not move along the curves is placed once; of what moves, a body is placed only in a look
that has an open pair of it.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.bounds import Boxes, joint_pose
from workbench.planning.collision.distances.cores import BALL, Cores
from workbench.planning.collision.distances.gjk import ROWS
from workbench.planning.compiled import njit_in_place
from workbench.planning.kinematics.robot import JointTree

MOST_PENDING = 512
"""Halves of curves waiting to be checked."""

MOST_OPEN = 1 << 14
"""Pairs left open by all looks of a curve."""

ALWAYS = 1 << 62
"""The number of a look that never comes: what does not move is where it is."""


class Scratch(NamedTuple):
    """All that a sweep writes to.

    `q` and `d` (nq,) [rad, m] are the state checked and how far each joint may move from it:
    by `ahead` to either side, and by up to `bent` beside that; `middle` (n,) is the same state of
    the joints that move, `moving` (m,) these and what they carry.
    `R_j` (j, 3, 3), `p_j` (j, 3) [m] and `z_j` (j, 3) place joints, `R` (b, 3, 3) and `c` (b, 3)
    [m] bodies; `twist` (j, 6) [m, rad] is how links move by `ahead`, at the world's origin, and
    turn.  `most` (j, j) [m] says how far anything on a joint can move relative to each joint before
    it; `rest` (j, j) [m] by how much more than its `twist` says.  `hub` (j, 4) [m] is a ball in the
    joint's frame around all bodies on it, of radius zero for the world; `hub_c` (j, 3) [m] its
    centre in the world, `hub_most` and `hub_rest` (j, j) [m] are those of the centre alone.
    `normal` (3,) is a direction in which something was found to be apart.
    `placed` (b,) are the numbers of the last looks in which a body was placed, `look` (1,) that of
    the last one.  `pending` (p, 3, n) are curves to be
    checked, with `begins` and `sizes` (p,) of their pairs in `open_pairs` (o,); `W` (15, 3) is
    scratch of `gjk`.
    """

    q: Floats
    d: Floats
    ahead: Floats
    bent: Floats
    middle: Floats
    moving: Ints
    R_j: Floats
    p_j: Floats
    z_j: Floats
    twist: Floats
    most: Floats
    rest: Floats
    hub: Floats
    hub_c: Floats
    hub_most: Floats
    hub_rest: Floats
    R: Floats
    c: Floats
    normal: Floats
    placed: Ints
    look: Ints
    pending: Floats
    begins: Ints
    sizes: Ints
    open_pairs: Ints
    W: Floats


@njit(cache=True)
def scratch_for(
    columns: Ints, base: Floats, tree: JointTree, boxes: Boxes, cores: Cores
) -> Scratch:
    """Scratch to sweep curves of the joints `columns` (n,), others at `base` (nq,) [rad, m]."""
    joints, bodies, nq, n = len(tree.parents), len(boxes.joint), len(base), len(columns)
    is_moving = np.zeros(joints, np.bool_)
    for i in range(n):
        is_moving[columns[i] + 1] = True
    count = 0
    for j in range(1, joints):
        is_moving[j] |= is_moving[tree.parents[j]]
        count += is_moving[j]
    moving = np.empty(count, np.int64)
    for j in range(joints - 1, 0, -1):
        if is_moving[j]:
            count -= 1
            moving[count] = j
    scratch = Scratch(
        base.copy(), np.zeros(nq), np.zeros(nq), np.zeros(nq), np.zeros(n), moving,
        np.zeros((joints, 3, 3)), np.zeros((joints, 3)), np.zeros((joints, 3)),
        np.zeros((joints, 6)), np.zeros((joints, joints)), np.zeros((joints, joints)),
        _hubs(joints, boxes), np.zeros((joints, 3)),
        np.zeros((joints, joints)), np.zeros((joints, joints)),
        np.zeros((bodies, 3, 3)), np.zeros((bodies, 3)), np.zeros(3),
        np.zeros(bodies, np.int64), np.zeros(1, np.int64),
        np.empty((MOST_PENDING, 3, n)), np.empty(MOST_PENDING, np.int64),
        np.empty(MOST_PENDING, np.int64), np.empty(MOST_OPEN, np.int64), np.empty((ROWS, 3)),
    )  # fmt: skip
    for i in range(3):
        scratch.R_j[0, i, i] = 1.0
    for j in range(1, joints):
        joint_pose(j, tree, base, scratch.R_j, scratch.p_j, scratch.z_j)
        _place_hub(j, scratch.R_j, scratch.p_j, scratch.hub, scratch.hub_c)
    for g in range(bodies):
        if cores.form[g] == BALL:
            # It is never turned, but its box has to have sides.
            for i in range(3):
                scratch.R[g, i, i] = 1.0
        if not is_moving[boxes.joint[g]]:
            j, is_ball = boxes.joint[g], cores.form[g] == BALL
            place_body(
                g, j, is_ball, boxes.R, boxes.c, scratch.R_j, scratch.p_j, scratch.R, scratch.c
            )
            scratch.placed[g] = ALWAYS
    return scratch


@njit(cache=True)
def _hubs(joints: int, boxes: Boxes) -> Floats:
    """For each joint a ball around all bodies on it in its frame, centre and radius (j, 4) [m]."""
    low, high = np.full((joints, 3), 1e9), np.full((joints, 3), -1e9)
    for g in range(len(boxes.joint)):
        j = boxes.joint[g]
        for i in range(3):
            low[j, i] = min(low[j, i], boxes.c[g, i] - boxes.radius[g])
            high[j, i] = max(high[j, i], boxes.c[g, i] + boxes.radius[g])
    hub = np.zeros((joints, 4))
    for j in range(1, joints):
        for i in range(3):
            hub[j, i] = (low[j, i] + high[j, i]) / 2
    for g in range(len(boxes.joint)):
        j = boxes.joint[g]
        if j == 0:
            continue
        x, y, z = boxes.c[g, 0] - hub[j, 0], boxes.c[g, 1] - hub[j, 1], boxes.c[g, 2] - hub[j, 2]
        hub[j, 3] = max(hub[j, 3], np.sqrt(x * x + y * y + z * z) + boxes.radius[g])
    return hub


@njit_in_place
def place_joints(tree: JointTree, scratch: Scratch) -> None:
    """Write where the joints that move are at `scratch.q`, and how far their bodies can move."""
    parents, q, R_j, p_j, z_j = tree.parents, scratch.q, scratch.R_j, scratch.p_j, scratch.z_j
    twist, ahead, hub, hub_c = scratch.twist, scratch.ahead, scratch.hub, scratch.hub_c
    for m in range(len(scratch.moving)):
        j = scratch.moving[m]
        joint_pose(j, tree, q, R_j, p_j, z_j)
        _place_hub(j, R_j, p_j, hub, hub_c)
        for i in range(6):
            twist[j, i] = twist[parents[j], i]
        for i in range(3):
            along, k, n = ahead[j - 1] * z_j[j, i], (i + 1) % 3, (i + 2) % 3
            if tree.slides[j] > 0.5:
                twist[j, i] += along
            else:
                twist[j, i] += ahead[j - 1] * (p_j[j, k] * z_j[j, n] - p_j[j, n] * z_j[j, k])
                twist[j, 3 + i] += along
        _walk(j, 0.0, tree, scratch, scratch.hub_most, scratch.hub_rest)
        _walk(j, hub[j, 3], tree, scratch, scratch.most, scratch.rest)


@njit_in_place
def _walk(
    row: int, radius: float, tree: JointTree, scratch: Scratch, most: Floats, rest: Floats
) -> None:
    """Write how far a ball around the hub of a joint can move, relative to each joint before it.

    `most[row]` (j,) [m] is as by `bounds.walk`; `rest[row]` (j,) [m] is what bounds the difference
    to what the `twist` says: what joints turn beside it, and half of all turns squared, each as far
    from its axis as what is further out can bring it.
    """
    p_j, z_j, d, bent, c = scratch.p_j, scratch.z_j, scratch.d, scratch.bent, scratch.hub_c
    moved, beside, j = 0.0, 0.0, row
    while j != 0:
        step = d[j - 1]
        if step > 0.0:
            if tree.slides[j] > 0.5:
                moved += step
                beside += bent[j - 1]
            else:
                u, v, w = c[row, 0] - p_j[j, 0], c[row, 1] - p_j[j, 1], c[row, 2] - p_j[j, 2]
                along = u * z_j[j, 0] + v * z_j[j, 1] + w * z_j[j, 2]
                r = np.sqrt(max(u * u + v * v + w * w - along * along, 0.0)) + radius
                far = step * (r + moved)
                beside += bent[j - 1] * r + step * (moved + far / 2)
                moved += far
        j = tree.parents[j]
        most[row, j], rest[row, j] = moved, beside


@njit_in_place
def _place_hub(j: int, R_j: Floats, p_j: Floats, hub: Floats, hub_c: Floats) -> None:
    for i in range(3):
        hub_c[j, i] = p_j[j, i]
        for k in range(3):
            hub_c[j, i] += R_j[j, i, k] * hub[j, k]


@njit_in_place
def place_body(
    g: int,
    j: int,
    is_ball: bool,
    R_g: Floats,
    c_g: Floats,
    R_j: Floats,
    p_j: Floats,
    R: Floats,
    c: Floats,
) -> None:
    """Write the pose of body g on joint j; a ball is never rotated.

    The result is `R` (b, 3, 3), `c` (b, 3) [m].  It is the joint's pose, `R_j` (j, 3, 3) and `p_j`
    (j, 3) [m], times the body's pose on the joint, `R_g` and `c_g`.
    """
    for i in range(3):
        c[g, i] = p_j[j, i]
        for k in range(3):
            c[g, i] += R_j[j, i, k] * c_g[g, k]
    if not is_ball:
        for i in range(3):
            for k in range(3):
                R[g, i, k] = (
                    R_j[j, i, 0] * R_g[g, 0, k]
                    + R_j[j, i, 1] * R_g[g, 1, k]
                    + R_j[j, i, 2] * R_g[g, 2, k]
                )

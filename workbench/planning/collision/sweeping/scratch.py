"""Scratch for one sweep: where joints and bodies are at the state looked at.

What does not move along the curves is placed once; of what moves, a body is placed only in a look
that has an open pair of it.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.bounds import Boxes, joint_pose, walk
from workbench.planning.collision.gjk import BALL, Cores
from workbench.planning.kinematics.robot import Tree

MOST_PENDING = 512
"""Halves of curves waiting to be looked at."""

MOST_OPEN = 1 << 14
"""Pairs left open by all looks of a curve."""

ALWAYS = 1 << 62
"""The number of a look that never comes: what does not move is where it is."""


class Scratch(NamedTuple):
    """All that a sweep writes to.

    `q` and `d` (nq,) [rad, m] are the state looked at and how far each joint may move from it;
    `middle` (n,) the same state of the joints that move, `moving` (m,) these and what they carry.
    `R_j` (j, 3, 3), `p_j` (j, 3) [m] and `z_j` (j, 3) place joints, `R` (b, 3, 3) and `c` (b, 3)
    [m] bodies.  `hub` (j, 4) [m] is a ball in the joint's frame around all bodies on it, of radius
    zero for the world, `hub_c` (j, 3) [m] its centre in the world; `hubs` (j, j) [m] says how far
    what is in it can move relative to each joint before it, `travel` (b, j) [m] the same of a body
    alone.  `done` (b, 2) are the numbers of the last looks in which the body was placed, and its
    travel worked out; `look` (1,) that of the last look.  `pending` (p, 3, n) are curves to be
    looked at, with `begins` and `sizes` (p,) of their pairs in `open_pairs` (o,); `W` (5, 3) is
    scratch of `gjk`.
    """

    q: Floats
    d: Floats
    middle: Floats
    moving: Ints
    R_j: Floats
    p_j: Floats
    z_j: Floats
    hub: Floats
    hub_c: Floats
    hubs: Floats
    R: Floats
    c: Floats
    travel: Floats
    done: Ints
    look: Ints
    pending: Floats
    begins: Ints
    sizes: Ints
    open_pairs: Ints
    W: Floats


@njit(cache=True)
def scratch_for(columns: Ints, base: Floats, tree: Tree, boxes: Boxes, cores: Cores) -> Scratch:
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
        base.copy(), np.zeros(nq), np.zeros(n), moving,
        np.zeros((joints, 3, 3)), np.zeros((joints, 3)), np.zeros((joints, 3)),
        _hubs(joints, boxes), np.zeros((joints, 3)), np.zeros((joints, joints)),
        np.zeros((bodies, 3, 3)), np.zeros((bodies, 3)), np.zeros((bodies, joints)),
        np.zeros((bodies, 2), np.int64), np.zeros(1, np.int64),
        np.empty((MOST_PENDING, 3, n)), np.empty(MOST_PENDING, np.int64),
        np.empty(MOST_PENDING, np.int64), np.empty(MOST_OPEN, np.int64), np.empty((5, 3)),
    )  # fmt: skip
    for i in range(3):
        scratch.R_j[0, i, i] = 1.0
    for j in range(1, joints):
        joint_pose(j, tree, base, scratch.R_j, scratch.p_j, scratch.z_j)
        _place_hub(j, scratch)
    for g in range(bodies):
        if cores.form[g] == BALL:
            # It is never turned, but its box has to have sides.
            for i in range(3):
                scratch.R[g, i, i] = 1.0
        if not is_moving[boxes.joint[g]]:
            place_body(g, boxes, cores, scratch, ALWAYS)
            scratch.done[g, 1] = ALWAYS
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


@njit(cache=True)
def place_joints(tree: Tree, scratch: Scratch) -> None:
    """Write where the joints that move are at `scratch.q`, and how far their bodies can move."""
    for m in range(len(scratch.moving)):
        j = scratch.moving[m]
        joint_pose(j, tree, scratch.q, scratch.R_j, scratch.p_j, scratch.z_j)
        _place_hub(j, scratch)
        x, y, z = scratch.hub_c[j, 0], scratch.hub_c[j, 1], scratch.hub_c[j, 2]
        walk(
            j,
            x,
            y,
            z,
            float(scratch.hub[j, 3]),
            j,
            tree,
            scratch.d,
            scratch.p_j,
            scratch.z_j,
            scratch.hubs,
        )


@njit(cache=True)
def _place_hub(j: int, scratch: Scratch) -> None:
    for i in range(3):
        scratch.hub_c[j, i] = scratch.p_j[j, i]
        for k in range(3):
            scratch.hub_c[j, i] += scratch.R_j[j, i, k] * scratch.hub[j, k]


@njit(cache=True)
def place_body(g: int, boxes: Boxes, cores: Cores, scratch: Scratch, look: int) -> None:
    """Write where a body is, in the look of that number; a ball is never turned."""
    R_j, p_j, R, c, j = scratch.R_j, scratch.p_j, scratch.R, scratch.c, boxes.joint[g]
    for i in range(3):
        c[g, i] = p_j[j, i]
        for k in range(3):
            c[g, i] += R_j[j, i, k] * boxes.c[g, k]
    if cores.form[g] != BALL:
        for i in range(3):
            for k in range(3):
                R[g, i, k] = (
                    R_j[j, i, 0] * boxes.R[g, 0, k]
                    + R_j[j, i, 1] * boxes.R[g, 1, k]
                    + R_j[j, i, 2] * boxes.R[g, 2, k]
                )
    scratch.done[g, 0] = look


@njit(cache=True)
def walk_body(g: int, tree: Tree, boxes: Boxes, scratch: Scratch, look: int) -> None:
    """Write how far a body can move, in the look of that number."""
    c, radius = scratch.c, boxes.radius[g]
    x, y, z = c[g, 0], c[g, 1], c[g, 2]
    walk(
        g,
        x,
        y,
        z,
        radius,
        boxes.joint[g],
        tree,
        scratch.d,
        scratch.p_j,
        scratch.z_j,
        scratch.travel,
    )
    scratch.done[g, 1] = look

"""Straight joint motions, checked one after the other by compiled code for compiled code.

It says what it cannot tell: bodies that are no convex shapes, and pairs that may stay in touch, are
measured by Coal.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.bounds import Boxes
from workbench.planning.collision.distances.cores import Cores
from workbench.planning.collision.sweeping.groups import Groups, groups_of
from workbench.planning.collision.sweeping.look import ANY, IS_CLEAR, Model
from workbench.planning.collision.sweeping.scratch import Scratch, scratch_for
from workbench.planning.collision.sweeping.sweep import curve_swept
from workbench.planning.kinematics.robot import JointTree

BLOCKED, CLEAR, ASK = 0, 1, -1
"""Answers about an edge: something is in the way, nothing is, or somebody else has to say."""


class Edges(NamedTuple):
    """All that it takes to check edges of the joints `columns` (n,) in one phase of a world.

    `margins` (p,) [m] and `commons` (p,) are of all pairs of the model, and `columns` and `commons`
    are numbers, without a unit; `resolution` is in m.  `is_all` is False where there are pairs
    beside those in `groups`.  What is checked first changes from edge to edge, in `groups`; what
    is answered does not depend on it.
    """

    columns: Ints
    resolution: float
    margins: Floats
    commons: Ints
    is_all: bool
    groups: Groups
    model: Model
    scratch: Scratch


# Part of what calls it: otherwise all of `curve_swept` is compiled once more.
@njit(cache=True, inline="always")
def edge_answer(a: Floats, b: Floats, edges: Edges) -> int:
    """`CLEAR`, `BLOCKED` or `ASK` for the straight motion from a to b (n,) [rad]."""
    pending = edges.scratch.pending
    for i in range(len(edges.columns)):
        pending[0, 0, i], pending[0, 1, i], pending[0, 2, i] = a[i], (a[i] + b[i]) / 2, b[i]
    found, _ = curve_swept(
        edges.columns, edges.resolution, edges.groups, edges.margins, edges.commons, edges.model,
        edges.scratch, ANY,
    )  # fmt: skip
    if found >= 0:
        return BLOCKED
    return CLEAR if found == IS_CLEAR and edges.is_all else ASK


def edges_of(
    model: Model,
    columns: Ints,
    base: Floats,
    resolution: float,
    among: Ints,
    *,
    margins: Floats,
    commons: Ints,
    is_all: bool,
) -> Edges:
    """Edges of the joints `columns` (n,), others at `base` (nq,) [rad, m].

    Args:
        model: of what moves.
        columns: places of the joints in the whole configuration.
        base: whole configuration (nq,).
        resolution: [m] see `motion`.
        among: pairs (k,) that compiled code can distinguish.
        margins: [m] of all pairs (p,).
        commons: per pair (p,) the deepest joint that carries both bodies.
        is_all: whether there are no other pairs to be checked.
    """
    scratch = scratch_for(columns, base, model.tree, model.boxes, model.cores)
    groups = groups_of(among, margins, model.first, model.second, model.boxes.joint)
    return Edges(columns, resolution, margins, commons, is_all, groups, model, scratch)


@cache
def no_edges(count: int) -> Edges:
    """Edges of this many joints of which compiled code knows nothing: every answer is `ASK`."""
    whole, none = np.zeros(0, np.int64), np.zeros((0, 3))
    point, flat = np.zeros((1, 3)), np.zeros(0)
    tree = JointTree(np.zeros(1, np.int64), np.zeros((1, 3, 3)), point, point, np.zeros(1))
    boxes = Boxes(whole, np.zeros((0, 3, 3)), none, none, flat)
    known = np.zeros(0, np.bool_)
    cores = Cores(
        none, whole, whole, flat, flat, flat, known, whole, whole, whole, none, none, flat
    )
    model = Model(tree, boxes, whole, whole, cores)
    scratch = scratch_for(whole, np.zeros(count), tree, boxes, cores)
    scratch = scratch._replace(pending=np.zeros((1, 3, count)), middle=np.zeros(count))
    groups = groups_of(whole, flat, whole, whole, whole)
    return Edges(whole, 0.0, flat, whole, False, groups, model, scratch)

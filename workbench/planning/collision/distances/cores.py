"""Bodies as compiled code searches distances between them: cores, swollen by a radius.

A core is the corners of a convex polyhedron or an upright cylinder: so boxes, cylinders, capsules,
balls and convex meshes are all the same to it.  Where a body goes around pieces, each of them is
such a core, too.
"""

from collections.abc import Mapping
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from workbench.model.geometry import (
    Bools,
    Box,
    Capsule,
    Cylinder,
    Floats,
    Ints,
    Mesh,
    Shape,
    Sphere,
)
from workbench.planning.collision.bodies import extent

OTHER, BALL, BOX, CYLINDER = 0, 1, 2, 3


class Cores(NamedTuple):
    """The cores of all bodies, one after the other.

    `corners` (c, 3) [m] in the body's frame, from its centre; those of body g are `size[g]`
    from `start[g]` on.  A cylinder has none but `radius[g]` and `length[g]` (half of it).
    `swell` (b,) [m] grows every core.  `known` (b,) is False for bodies that are not convex;
    `form` (b,) is `BALL`, `BOX` or `CYLINDER` for these, and `OTHER`.

    After the bodies' own cores come those of their pieces, which are seen from the body's centre
    as well: `pieces[g]` of body g from `first[g]` on.  Around each core n are a box, `middle`
    (n, 3) and `halves` (n, 3) [m] in the body's frame; and a ball of radius `ball` (n,) [m].
    """

    corners: Floats
    start: Ints
    size: Ints
    radius: Floats
    length: Floats
    swell: Floats
    known: Bools
    form: Ints
    first: Ints
    pieces: Ints
    middle: Floats
    halves: Floats
    ball: Floats


def cores_of(shapes: list[Shape], centres: Floats) -> Cores:
    """The cores of shapes, each seen from its centre (3,) [m] in its own frame."""
    pieces = [shape.pieces if isinstance(shape, Mesh) else () for shape in shapes]
    every = [*shapes, *(piece for some in pieces for piece in some)]
    number = np.array([len(some) for some in pieces], dtype=np.int64)
    seen_from = np.concatenate([centres, np.repeat(centres, number, axis=0)])
    cores = [_core_of(shape) for shape in every]
    corners = [points - centre for (points, *_), centre in zip(cores, seen_from, strict=True)]
    count = np.array([len(points) for points in corners], dtype=np.int64)
    numbers = np.array([rest for _, *rest in cores])
    extents = [extent(shape) for shape in every]
    return Cores(
        np.ascontiguousarray(np.vstack(corners)),
        np.cumsum(count) - count,
        count,
        numbers[:, 0].copy(),
        numbers[:, 1].copy(),
        numbers[:, 2].copy(),
        numbers[: len(shapes), 3] > 0,
        np.array([_FORMS.get(type(shape), OTHER) for shape in shapes]),
        len(shapes) + np.cumsum(number) - number,
        number,
        np.array([centre for centre, _, _ in extents]) - seen_from,
        np.array([half for _, half, _ in extents]),
        np.array([radius for _, _, radius in extents]),
    )


_FORMS: Mapping[type, int] = {Sphere: BALL, Box: BOX, Cylinder: CYLINDER}


@lru_cache(maxsize=4096)
def _core_of(shape: Shape) -> tuple[Floats, float, float, float, float]:
    """Corners, radius, half length, swell, and 1 when it is convex, of a shape in its frame."""
    none = np.zeros((0, 3))
    match shape:
        case Box():
            signs = np.array(list(product((-1.0, 1.0), repeat=3)))
            return signs * np.asarray(shape.size) / 2, 0.0, 0.0, 0.0, 1.0
        case Sphere():
            return np.zeros((1, 3)), 0.0, 0.0, shape.radius, 1.0
        case Capsule():
            ends = np.array([[0, 0, -shape.length / 2], [0, 0, shape.length / 2]])
            return ends, 0.0, 0.0, shape.radius, 1.0
        case Cylinder():
            return none, shape.radius, shape.length / 2, 0.0, 1.0
        case Mesh():
            return np.asarray(shape.points), 0.0, 0.0, 0.0, float(shape.is_convex)

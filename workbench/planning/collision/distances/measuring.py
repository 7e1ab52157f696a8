"""The distance of two shapes, measured by Coal; where a shape has pieces, between these."""

from functools import lru_cache
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, Mesh, Shape, pieces_of
from workbench.planning.collision.bodies import coal_shape, extent

REQUEST = coal.DistanceRequest()


class _Pieces(NamedTuple):
    """The pieces of a shape, with the boxes (n, 3) and balls (n,) [m] around them in its frame."""

    geometries: tuple[coal.CollisionGeometry, ...]
    centres: Floats
    halves: Floats
    radii: Floats


@lru_cache(maxsize=4096)
def _pieces(shape: Shape) -> _Pieces:
    pieces = pieces_of(shape)
    centres, halves, radii = zip(*map(extent, pieces), strict=True)
    return _Pieces(
        tuple(map(coal_shape, pieces)), np.array(centres), np.array(halves), np.array(radii)
    )


def has_pieces(shape: Shape) -> bool:
    """Whether a shape goes around pieces that have to be checked."""
    return isinstance(shape, Mesh) and bool(shape.pieces)


def distance(shape: Shape, T: pin.SE3, other: Shape, U: pin.SE3, within: float = np.inf) -> float:
    """The distance [m] of two shapes at poses in a common frame, negative where they overlap.

    Distances beyond `within` are not distinguished.
    """
    a, b = _pieces(shape), _pieces(other)
    at, bt = (
        coal.Transform3s(T.rotation, T.translation),
        coal.Transform3s(U.rotation, U.translation),
    )
    if len(a.radii) == len(b.radii) == 1:
        return _measure(a.geometries[0], at, b.geometries[0], bt)
    seen = T.actInv(U)
    # Of each box of the one how far the balls of the other are, and the other way round.
    there = b.centres @ seen.rotation.T + seen.translation
    here = (a.centres - seen.translation) @ seen.rotation
    from_one = np.abs(there[None] - a.centres[:, None]) - a.halves[:, None]
    from_other = np.abs(here[:, None] - b.centres[None]) - b.halves[None]
    least = np.maximum(
        np.linalg.norm(np.maximum(from_one, 0.0), axis=2) - b.radii,
        np.linalg.norm(np.maximum(from_other, 0.0), axis=2) - a.radii[:, None],
    )
    best = within
    for k in np.argsort(least, axis=None):
        i, j = divmod(int(k), len(b.radii))
        if least[i, j] >= best:
            break
        best = min(best, _measure(a.geometries[i], at, b.geometries[j], bt))
    return best


def _measure(
    geometry: coal.CollisionGeometry,
    T: coal.Transform3s,
    other: coal.CollisionGeometry,
    U: coal.Transform3s,
) -> float:
    return float(coal.distance(geometry, T, other, U, REQUEST, coal.DistanceResult()))

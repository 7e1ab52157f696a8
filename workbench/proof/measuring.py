"""The distance of two shapes, measured by Coal; where a shape has pieces, between these."""

from dataclasses import dataclass
from functools import lru_cache

import coal
import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, Mesh, Shape, pieces_of
from workbench.proof.bodies import coal_shape, hull

Placed = tuple[Shape, pin.SE3]
"""A shape and its pose in the world."""


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """The pieces of a shape; around each a box (n, 3) and a ball (n,) [m] in the shape's frame."""

    shapes: tuple[coal.CollisionGeometry, ...]
    centres: Floats
    halves: Floats
    radii: Floats


@lru_cache(maxsize=4096)
def _pieces(shape: Shape) -> _Pieces:
    pieces = pieces_of(shape)
    hulls = [hull(piece) for piece in pieces]
    return _Pieces(
        tuple(coal_shape(piece) for piece in pieces),
        np.array([one.centre for one in hulls]),
        np.array([one.half for one in hulls]),
        np.array([one.radius for one in hulls]),
    )


def is_divided(shape: Shape) -> bool:
    """Whether a shape only goes around pieces."""
    return isinstance(shape, Mesh) and len(shape.pieces) > 0


def measured(one: Placed, other: Placed) -> coal.DistanceResult:
    """How far two shapes are apart, where they are nearest: their pieces, where they have some."""
    (shape, T), (bed, U) = one, other
    mine, its = _pieces(shape), _pieces(bed)
    least = _apart_at_least(mine, its, T.actInv(U))
    at, where = (coal.Transform3s(one.rotation, one.translation) for one in (T, U))
    best: coal.DistanceResult | None = None
    for k in np.argsort(least, axis=None):
        i, j = divmod(int(k), least.shape[1])
        if best is not None and least[i, j] >= best.min_distance:
            break
        found = coal.DistanceResult()
        coal.distance(mine.shapes[i], at, its.shapes[j], where, coal.DistanceRequest(), found)
        # What is no number is not far away.
        if best is None or not found.min_distance >= best.min_distance:
            best = found
    assert best is not None  # every shape has a piece
    return best


def _apart_at_least(one: _Pieces, other: _Pieces, T: pin.SE3) -> Floats:
    """How far pieces are apart at least (n, m) [m]: the box around each, the ball around the other.

    `T` is the pose of the other shape in the frame of the one.
    """
    theirs = other.centres @ T.rotation.T + T.translation
    ours = (one.centres - T.translation) @ T.rotation
    beside = np.maximum(np.abs(theirs - one.centres[:, None]) - one.halves[:, None], 0.0)
    besides = np.maximum(np.abs(ours[:, None] - other.centres) - other.halves, 0.0)
    return np.maximum(
        np.sqrt((beside**2).sum(axis=2)) - other.radii,
        np.sqrt((besides**2).sum(axis=2)) - one.radii[:, None],
    )


def gap_of(one: Placed, other: Placed, far: float = np.inf) -> float:
    """The distance [m] of two bodies in the world, negative inside; at least `far` beyond that."""
    (shape, T), (bed, U) = one, other
    around, about = hull(shape), hull(bed)
    offset = U.rotation.T @ (T.act(around.centre) - U.act(about.centre))
    apart = np.linalg.norm(np.maximum(np.abs(offset) - about.half, 0.0)) - around.radius
    if apart >= far:
        return float(apart)
    return float(measured(one, other).min_distance)

"""Shapes as Coal measures them, the hulls around them, and the distance of two."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import coal
import numpy as np
import pinocchio as pin

from workbench.model.geometry import (
    Box,
    Capsule,
    Cylinder,
    Floats,
    Mesh,
    Shape,
    Sphere,
    pieces_of,
)


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """A shape as a hull of points (m, 3) [m], seen from `centre` (3,) [m] in the shape's frame.

    Each point has a box of half lengths `box` (3,) [m], a disc of radius `disc` [m] across z, and a
    ball of `ball` [m].  Around it all are a box of half lengths `half` (3,) [m] and a ball
    of a `radius` [m].
    """

    centre: Floats
    half: Floats
    radius: float
    points: Floats
    box: Floats
    disc: float = 0.0
    ball: float = 0.0


@lru_cache(maxsize=4096)
def hull(shape: Shape) -> Hull:
    """The hull of a shape."""
    zero, none = np.zeros(3), np.zeros((1, 3))
    match shape:
        case Box(size=size):
            half = np.asarray(size) / 2
            return Hull(zero, half, float(np.linalg.norm(half)), none, half)
        case Sphere(radius=radius):
            return Hull(zero, np.full(3, radius), radius, none, zero, ball=radius)
        case Cylinder(radius=radius, length=length):
            half = np.array([radius, radius, length / 2])
            box, far = np.array([0.0, 0.0, length / 2]), float(np.hypot(radius, length / 2))
            return Hull(zero, half, far, none, box, disc=radius)
        case Capsule(radius=radius, length=length):
            half = np.array([radius, radius, length / 2 + radius])
            box = np.array([0.0, 0.0, length / 2])
            return Hull(zero, half, radius + length / 2, none, box, ball=radius)
        case Mesh(points=points, is_convex=is_convex):
            centre = (points.max(axis=0) + points.min(axis=0)) / 2
            off = points - centre
            half, far = np.abs(off).max(axis=0), float(np.linalg.norm(off, axis=1).max())
            # What is hollow would hardly be told apart by its hull, whose points are many.
            return Hull(centre, half, far, *((off, zero) if is_convex else (none, half)))


@lru_cache(maxsize=4096)
def coal_shape(shape: Shape) -> coal.CollisionGeometry:
    """A shape as Coal measures it: convex ones as bodies, other meshes as their surface."""
    match shape:
        case Box(size=size):
            return coal.Box(np.array(size))
        case Sphere(radius=radius):
            return coal.Sphere(radius)
        case Cylinder(radius=radius, length=length):
            return coal.Cylinder(radius, length)
        case Capsule(radius=radius, length=length):
            return coal.Capsule(radius, length)
        case Mesh(points=points, triangles=triangles, is_convex=is_convex):
            if is_convex:
                # Coal walks along edges: no edge leads from one of two equal corners to the other.
                places, number = np.unique(points, axis=0, return_inverse=True)
                if len(places) < len(points):
                    points, triangles = places, number.ravel()[triangles]
            corners, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
            for point in points:
                corners.append(np.array(point))
            for a, b, c in triangles.tolist():
                faces.append(coal.Triangle(a, b, c))
            if is_convex:
                return coal.Convex(corners, faces)
            surface = coal.BVHModelOBBRSS()
            surface.beginModel(len(triangles), len(points))
            surface.addSubModel(corners, faces)
            surface.endModel()
            return surface


Placed = tuple[Shape, pin.SE3]
"""A shape and its pose in the world."""


@dataclass(frozen=True, slots=True, eq=False)
class _BoundedPieces:
    """The pieces of a shape; around each a box (n, 3) and a ball (n,) [m] in the shape's frame."""

    shapes: tuple[coal.CollisionGeometry, ...]
    centres: Floats
    halves: Floats
    radii: Floats


@lru_cache(maxsize=4096)
def _pieces(shape: Shape) -> _BoundedPieces:
    pieces = pieces_of(shape)
    hulls = [hull(piece) for piece in pieces]
    return _BoundedPieces(
        tuple(coal_shape(piece) for piece in pieces),
        np.array([convex.centre for convex in hulls]),
        np.array([convex.half for convex in hulls]),
        np.array([convex.radius for convex in hulls]),
    )


def is_divided(shape: Shape) -> bool:
    """Whether a shape only goes around pieces."""
    return isinstance(shape, Mesh) and len(shape.pieces) > 0


def measure(first: Placed, second: Placed) -> coal.DistanceResult:
    """How far two shapes are apart, where they are nearest: their pieces, where they have some."""
    nearest = _nearest(first, second, np.inf)
    assert nearest is not None  # every shape has a piece
    return nearest


def _nearest(first: Placed, second: Placed, far: float) -> coal.DistanceResult | None:
    """How far the nearest pieces of two shapes are apart; None where none is within `far` [m]."""
    (shape, T), (bed, U) = first, second
    mine, its = _pieces(shape), _pieces(bed)
    at, where = (coal.Transform3s(pose.rotation, pose.translation) for pose in (T, U))
    if len(mine.shapes) == len(its.shapes) == 1:
        only = coal.DistanceResult()
        coal.distance(mine.shapes[0], at, its.shapes[0], where, coal.DistanceRequest(), only)
        return only
    seen = T.actInv(U)
    ours = (mine.centres - seen.translation) @ seen.rotation
    theirs = its.centres @ seen.rotation.T + seen.translation
    best: coal.DistanceResult | None = None

    def look(i: int, j: int) -> float:
        nonlocal best
        found = coal.DistanceResult()
        coal.distance(mine.shapes[i], at, its.shapes[j], where, coal.DistanceRequest(), found)
        # What is no number is not far away.
        if best is None or not found.min_distance >= best.min_distance:
            best = found
        return min(far, best.min_distance)

    # From here on, by balls and boxes: what is this far from the whole other shape, or its pieces.
    mine_out = _out_of(ours, hull(bed)) - mine.radii
    its_out = _out_of(theirs, hull(shape)) - its.radii
    if max(mine_out.min(), its_out.min()) >= far:
        return None
    least = look(int(mine_out.argmin()), int(its_out.argmin()))
    rows, columns = np.flatnonzero(~(mine_out >= least)), np.flatnonzero(~(its_out >= least))
    apart = np.maximum(
        _beyond(theirs[columns] - mine.centres[rows, None], mine.halves[rows, None])
        - its.radii[columns],
        _beyond(ours[rows, None] - its.centres[columns], its.halves[columns])
        - mine.radii[rows, None],
    )
    close = np.flatnonzero(~(apart >= least))
    for k in close[np.argsort(apart.flat[close])].tolist():
        i, j = divmod(k, len(columns))
        if apart[i, j] >= least:
            break
        least = look(int(rows[i]), int(columns[j]))
    return best


def _out_of(points: Floats, around: Hull) -> Floats:
    return _beyond(points - around.centre, around.half)


def _beyond(offsets: Floats, half: Floats) -> Floats:
    """How far points (..., 3) [m] from the middle of a box are from it, negative inside."""
    out = np.abs(offsets) - half
    outside = np.maximum(out, 0.0)
    x, y, z = outside[..., 0], outside[..., 1], outside[..., 2]
    return np.sqrt(x * x + y * y + z * z) + np.minimum(out.max(axis=-1), 0.0)


def gap_of(first: Placed, second: Placed, far: float = np.inf) -> float:
    """The distance [m] of two bodies in the world, negative inside; at least `far` beyond that."""
    (shape, T), (bed, U) = first, second
    around, about = hull(shape), hull(bed)
    offset = U.rotation.T @ (T.act(around.centre) - U.act(about.centre))
    apart = np.linalg.norm(np.maximum(np.abs(offset) - about.half, 0.0)) - around.radius
    if apart >= far:
        return float(apart)
    nearest = _nearest(first, second, far)
    return far if nearest is None else float(nearest.min_distance)


def least_gap(body: Placed, others: Sequence[Placed], far: float = np.inf) -> float:
    """The distance [m] of a body to the nearest of others; at least `far` beyond that."""
    for other in others:
        gap = gap_of(body, other, far)
        # What is no number is not far away.
        if not gap >= far:
            far = gap
    return far


def _measure_aslant_first() -> None:
    """Make Coal use the exact size of boxes in this process.

    If the first direction in which Coal measures a box has a zero component, boxes count as
    1 + 1e-10 times their size.  Then the last digits would depend on earlier measurements.
    """
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    coal.distance(
        coal.Sphere(0.02),
        coal.Transform3s(turn, np.array([0.31, 0.27, 0.43])),
        coal.Box(np.full(3, 0.1)),
        coal.Transform3s(np.eye(3), np.zeros(3)),
        coal.DistanceRequest(),
        coal.DistanceResult(),
    )


_measure_aslant_first()

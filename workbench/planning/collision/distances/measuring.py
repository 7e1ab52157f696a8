"""The distance of two shapes, measured by Coal; where a shape has pieces, between these."""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, Mesh, Shape, pieces_of
from workbench.planning.collision.bodies import coal_shape, extent
from workbench.planning.collision.distances.piece_bounds import close_pairs, far_from

REQUEST = coal.DistanceRequest()

Body = tuple[Shape, pin.SE3]
"""A shape and its pose in the world."""


class _Pieces(NamedTuple):
    """The pieces of a shape, with what is `around` the whole and each of them, see `far_from`."""

    geometries: tuple[coal.CollisionGeometry, ...]
    bounds: Floats
    around: Floats


@lru_cache(maxsize=4096)
def _pieces(shape: Shape) -> _Pieces:
    pieces = pieces_of(shape)
    bounds = np.array([np.hstack(extent(piece)) for piece in pieces])
    return _Pieces(tuple(map(coal_shape, pieces)), bounds, np.hstack(extent(shape)))


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
    if len(a.bounds) == len(b.bounds) == 1:
        return _measure(a.geometries[0], at, b.geometries[0], bt)
    seen = T.actInv(U)
    R, p = np.ascontiguousarray(seen.rotation), seen.translation
    ours = far_from(a.bounds, np.ascontiguousarray(R.T), -R.T @ p, b.around)
    theirs = far_from(b.bounds, R, p, a.around)
    # Those that are nearest to the whole other shape come first: others are hardly ever measured.
    first, second = int(ours.argmin()), int(theirs.argmin())
    best = within
    if max(ours[first], theirs[second]) >= best:
        return best
    best = min(best, _measure(a.geometries[first], at, b.geometries[second], bt))
    rows, columns = np.flatnonzero(ours < best), np.flatnonzero(theirs < best)
    pairs, least = close_pairs(a.bounds, b.bounds, R, p, rows, columns, best)
    for (i, j), gap in zip(pairs.tolist(), least.tolist(), strict=True):
        if gap >= best:
            break
        best = min(best, _measure(a.geometries[i], at, b.geometries[j], bt))
    return best


def moved_distance(body: Body, bed: Body, step: Floats, within: float = np.inf) -> float:
    """The distance [m] of two bodies as `distance`, the first of them moved by a step (3,) [m]."""
    (shape, T), (other, U) = body, bed
    return distance(shape, pin.SE3(T.rotation, T.translation + step), other, U, within)


def find_nearing(body: Body, bed: Body, steps: Floats, begins: float, keeps: float) -> float | None:
    """The first distance [m] smaller than a body must keep to another body; None: there is none.

    Args:
        body: that moves.
        bed: that stays.
        steps: (k, 3) [m] where it moves to, from where it is, straight ahead.
        begins: how far they are apart before [m].
        keeps: less is too near [m].
    """
    far = np.linalg.norm(steps, axis=1).tolist()
    gap, at = begins, 0.0
    for gone, step in zip(far, steps, strict=True):
        # A distance changes by no more than what a body moves.
        if gap - (gone - at) >= keeps:
            continue
        gap, at = moved_distance(body, bed, step, keeps + (far[-1] - gone)), gone
        if gap < keeps:
            return gap
    return None


class Group:
    """Shapes that move together, each at a place of its own, with all of their pieces in a row.

    Lifetime: as long as the shapes.
    """

    def __init__(self, placed: Sequence[tuple[Shape, pin.SE3]]):
        """The shapes, and where each is in the frame of the group."""
        pieces = [_pieces(shape) for shape, _ in placed]
        counts = [len(shape_pieces.bounds) for shape_pieces in pieces]
        self.owners = np.repeat(np.arange(len(placed)), np.array(counts, int))
        """The shape that each piece (n,) belongs to, no unit."""
        self.geometries = [piece for some in pieces for piece in some.geometries]
        bounds = np.concatenate([np.zeros((0, 7)), *(some.bounds for some in pieces)])
        self.centres, self.halves, self.radii = bounds[:, :3], bounds[:, 3:6], bounds[:, 6]
        R = np.array([T.rotation for _, T in placed]).reshape(-1, 3, 3)
        p = np.array([T.translation for _, T in placed]).reshape(-1, 3)
        self.R, self.p = R[self.owners], p[self.owners]
        self.balls = np.einsum("nij,nj->ni", self.R, self.centres) + self.p
        """Where the balls around the pieces are in the frame of the group (n, 3) [m]."""


def group_distance(
    group: Group, T: pin.SE3, shifts: Floats, other: Group, within: float = np.inf
) -> tuple[float, int]:
    """The least distance [m] between the shapes of two groups, below 0 where they overlap.

    Args:
        group: a group.
        T: where it is, seen from the other one.
        shifts: (s, 3) [m] by which each of its shapes is moved in its frame before.
        other: the group that stays.
        within: distances beyond it are not measured.

    Returns:
        The distance, and which shape of `group` it is of; -1 where none is within.
    """
    moved = shifts[group.owners]
    R, p = T.rotation @ group.R, (group.p + moved) @ T.rotation.T + T.translation
    balls = (group.balls + moved) @ T.rotation.T + T.translation
    # Of each box of the one how far the balls of the other are, and the other way round.
    apart = other.balls[None] - p[:, None]
    there = np.abs(apart @ R - group.centres[:, None]) - group.halves[:, None]
    back = np.einsum("mji,nmj->nmi", other.R, balls[:, None] - other.p[None])
    here = np.abs(back - other.centres[None]) - other.halves[None]
    least = np.maximum(_to_box(there) - other.radii, _to_box(here) - group.radii[:, None])
    best, at = within, -1
    for k in np.argsort(least, axis=None, kind="stable").tolist():
        i, j = divmod(k, len(other.radii))
        if least[i, j] >= best:
            break
        far = _measure(
            group.geometries[i],
            coal.Transform3s(R[i], p[i]),
            other.geometries[j],
            coal.Transform3s(other.R[j], other.p[j]),
        )
        if far < best:
            best, at = far, int(group.owners[i])
    return best, at


def _to_box(beyond: Floats) -> Floats:
    """Distances (...) [m] to a box, below 0 within, of points `beyond` (..., 3) its faces by it."""
    x, y, z = beyond[..., 0], beyond[..., 1], beyond[..., 2]
    # Written out: numpy reduces an axis of three slowly.
    out_x, out_y, out_z = np.maximum(x, 0.0), np.maximum(y, 0.0), np.maximum(z, 0.0)
    outside = np.sqrt(out_x * out_x + out_y * out_y + out_z * out_z)
    return outside + np.minimum(np.maximum(np.maximum(x, y), z), 0.0)


def _measure(
    geometry: coal.CollisionGeometry,
    T: coal.Transform3s,
    other: coal.CollisionGeometry,
    U: coal.Transform3s,
) -> float:
    return float(coal.distance(geometry, T, other, U, REQUEST, coal.DistanceResult()))

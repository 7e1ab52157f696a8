"""Depth images fused into a signed distance field, with the carving of free space.

After Curless, Levoy, "A Volumetric Method for Building Complex Models from Range Images", SIGGRAPH
1996.
"""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from workbench.extras.reconstruction.depth_views import Bounds, DepthView
from workbench.model.geometry import Bools, Floats, Ints, transform

SLAB = 2_000_000
"""Voxels that are worked on at once, for the memory's sake."""

AGREED = 2
"""This many views must look through a place near a surface before it is carved: one alone may have
measured wrongly."""

RIM = 3
"""[pixels] Around the part a pixel without a measurement says nothing: edges are dropped there."""


def fused(
    views: Sequence[DepthView], bounds: Bounds, voxel: float, truncation: float
) -> tuple[Floats, Floats]:
    """The signed distance to the surface, positive outside, in voxels of the region.

    Near a surface that was measured it is the mean of all views.  What any view looks through is
    outside, and so is what lies outside of the region.  What none has seen is inside where it is
    hidden behind the part in most views: so the surface is closed where nothing was measured.

    Args:
        views: in the model's frame.
        bounds: in which the part is.
        voxel: [m] width.
        truncation: [m] distances are cut off here; surfaces that are nearer to each other, seen
            from both sides, pull at each other.

    Returns:
        Distances over the truncation, in -1..1, of shape (x, y, z), and where the middle of the
        first voxel is (3,) [m].
    """
    # Two voxels around the region are outside, so that every surface is closed in it.
    counts = np.ceil((bounds.high - bounds.low) / voxel).astype(int) + 4
    origin = bounds.low - 1.5 * voxel
    field = np.ones(counts, dtype=np.float32)
    empty = [_empty(view) for view in views]
    rows = max(1, SLAB // int(counts[1] * counts[2]))
    y, z = (origin[k] + voxel * np.arange(counts[k]) for k in (1, 2))
    for first in range(0, counts[0], rows):
        last = min(first + rows, counts[0])
        x = origin[0] + voxel * np.arange(first, last)
        centres = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
        inside = np.flatnonzero(bounds.holds(centres))
        if len(inside):
            values = field[first:last].reshape(-1)
            values[inside] = _slab(views, empty, centres[inside], truncation)
            field[first:last] = values.reshape(last - first, *counts[1:])
    return field.astype(np.float64), origin


def _empty(view: DepthView) -> Bools:
    """The pixels (rows, columns) that measured nothing, and not because the part's edge is near.

    Behind them may be anything, but hardly the part.
    """
    around = np.asarray(ndimage.binary_dilation(view.is_part, iterations=RIM), dtype=bool)
    return np.asarray((view.depth == 0) & ~around)


def _slab(
    views: Sequence[DepthView], empty: Sequence[Bools], points: Floats, truncation: float
) -> Floats:
    """The field at some points (n, 3) [m] of the region, (n,) in -1..1."""
    total, weight = np.zeros(len(points)), np.zeros(len(points))
    through, hidden, missed = (np.zeros(len(points), dtype=np.int32) for _ in range(3))
    for view, nothing in zip(views, empty, strict=True):
        seen, distance, certainty, is_part = _distances(view, points, nothing, missed)
        is_free = np.where(is_part, distance > truncation, distance > -truncation)
        through[seen[is_free]] += 1
        hidden[seen[is_part & (distance < -truncation)]] += 1
        near = is_part & (np.abs(distance) <= truncation) & (certainty > 0)
        # Behind the surface a view knows less and less: the other side of a wall may be there.
        fading = np.clip(1 + np.minimum(distance[near], 0) / truncation, 0, 1)
        trusted = certainty[near] * fading
        total[seen[near]] += trusted * distance[near] / truncation
        weight[seen[near]] += trusted
    is_near = weight > 0
    value = np.where(hidden > missed, -1.0, 1.0)
    value[through > 0] = 1.0
    mean = total[is_near] / weight[is_near]
    carved = through[is_near]
    value[is_near] = np.where(
        carved >= AGREED, (total[is_near] + carved) / (weight[is_near] + carved), mean
    )
    return value


def _distances(
    view: DepthView, points: Floats, nothing: Bools, missed: Ints
) -> tuple[Ints, Floats, Floats, Bools]:
    """What a view says of points (n, 3); counts up `missed` (n,) where it has measured nothing.

    Returns:
        Which points (m,) lie in pixels that measured something; the signed distance (m,) [m] to
        what was measured there, how much it is worth (m,), and whether it is the part (m,).
    """
    T = view.T_model_camera.inverse()
    p = transform(T, points)
    rows, columns = view.camera.shape
    pixel = np.rint(p[:, :2] / p[:, 2:] * view.camera.focal + view.camera.centre).astype(int)
    is_in = ((pixel >= 0) & (pixel < (columns, rows))).all(axis=1)
    seen = np.flatnonzero(is_in)
    u, v = pixel[seen].T
    missed[seen[nothing[v, u]]] += 1
    measured = view.depth[v, u] > 0
    seen, u, v = seen[measured], u[measured], v[measured]
    surface = view.rays[v, u] * view.depth[v, u][:, None]
    normals = view.normals[v, u]
    toward = -np.einsum("nk,nk->n", normals, view.rays[v, u])
    cosine = toward / np.linalg.norm(view.rays[v, u], axis=1)
    off = p[seen] - surface
    distance = np.einsum("nk,nk->n", off, normals)
    # Without a normal, or far off, where a plane says nothing, what counts is the way of the ray.
    along = (view.depth[v, u] - p[seen, 2]) * np.linalg.norm(view.rays[v, u], axis=1)
    distance = np.where(cosine > 0, distance, along)
    return seen, distance, np.maximum(cosine, 0.0) ** 2, view.is_part[v, u]

"""A surface through the points of a model that is a cloud: of one side, or of all around.

Points that were seen from one side are joined in the picture of that side, so that the surface has
one layer.  Points of all sides get the boundary of their alpha shape (Edelsbrunner and
Muecke 1994).
"""

from collections.abc import Iterator

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, KDTree, QhullError

from workbench.formats.meshes.repair import examine_surface
from workbench.model.geometry import Bools, Floats, Ints, Mesh

MOST_POINTS = 5_000
"""Points of which the surface is made."""

LONGEST_EDGE, ALPHAS = 4.0, (2.5, 3.5, 5.0)
"""Longest edge of a triangle, and radii of the ball of the alpha shape, over the distance of the
points; the first radius that closes the surface is taken, or the last."""

JOINED = 0.8
"""Share of the triangles of a picture that are short, where it shows one side."""

LEAST_PIECE = 0.05
"""Pieces of the surface with a smaller share of the largest one's triangles are stray points."""

NARROW = 0.4
"""The cloud as seen from its origin fills no wider a cone than this, where a scanner was there:
cosine of half its angle."""


def surface_through(points: Floats) -> Mesh | None:
    """The surface, None where the points have none.

    Args:
        points: (n, 3) [m] or another unit, in a scanner's frame or in that of the part.
    """
    thin, spacing = _thinned(points)
    if len(thin) < 4 or spacing <= 0:
        return None
    for picture, away in _pictures(thin):
        try:
            triangles = Delaunay(picture).simplices
        except QhullError:
            continue
        short = _edges(thin, triangles).max(axis=1) < LONGEST_EDGE * spacing
        if short.mean() > JOINED:
            return _used(thin, _turned_from(away, thin, triangles[short]))
    around = None
    for alpha in ALPHAS:
        around = _used(thin, _alpha_shape(thin, alpha * spacing))
        if around is not None and examine_surface(around).is_watertight:
            break
    return around


def _thinned(points: Floats) -> tuple[Floats, float]:
    """At most about `MOST_POINTS` of the points, and their distance from each other."""
    few, spacing = points, _spacing(points)
    step = 0.0
    while len(few) > MOST_POINTS and spacing > 0:
        step = max(1.1 * step, 0.8 * spacing * np.sqrt(len(few) / MOST_POINTS))
        _, first = np.unique(np.floor(points / step).astype(np.int64), axis=0, return_index=True)
        few = points[np.sort(first)]
        spacing = _spacing(few)
    return few, spacing


def _spacing(points: Floats) -> float:
    """How far away the fourth neighbour of a point is, as a rule."""
    some = points[:: max(1, len(points) // 2000)]
    distances, _ = KDTree(points).query(some, k=min(5, len(points)))
    return float(np.median(distances.reshape(len(some), -1)[:, -1]))


def _pictures(points: Floats) -> Iterator[tuple[Floats, Floats]]:
    """The points in pictures (n, 2), and for each the direction (3,) away from its viewer.

    First as from the origin, where a scanner may have been; then along each principal axis, from
    the side to which the middle of the cloud bulges.
    """
    middle = points.mean(axis=0)
    away = np.linalg.norm(points, axis=1)
    if away.min() > 0 and (points @ middle / away).min() > NARROW * np.linalg.norm(middle):
        axes = np.linalg.svd(middle[None])[2]
        towards = axes[0] * np.sign(axes[0] @ middle)
        yield points @ axes[1:].T / (points @ towards)[:, None], towards
    off = points - middle
    axes = np.linalg.svd(off, full_matrices=False)[2]
    for number in (2, 1, 0):
        across, depth = off @ np.delete(axes, number, axis=0).T, off @ axes[number]
        is_inner = np.linalg.norm(across, axis=1) < np.median(np.linalg.norm(across, axis=1))
        is_behind = depth[is_inner].mean() > depth[~is_inner].mean()
        yield across, -axes[number] if is_behind else axes[number]


def _edges(points: Floats, triangles: Ints) -> Floats:
    """Lengths (m, 3) of the edges of triangles (m, 3)."""
    a, b, c = points[triangles.T]
    return np.stack([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=1)


def _turned_from(away: Floats, points: Floats, triangles: Ints) -> Ints:
    """The triangles (m, 3), no outside of which looks away (3,) from the viewer."""
    a, b, c = points[triangles.T]
    is_away = np.cross(b - a, c - a) @ away > 0
    return np.where(is_away[:, None], triangles[:, ::-1], triangles)


def _alpha_shape(points: Floats, radius: float) -> Ints | None:
    """Triangles (m, 3) around what balls of a radius cannot enter from outside."""
    try:
        found = Delaunay(points)
    except QhullError:
        return None
    solids = found.simplices.astype(np.int64)
    solids = solids[~_is_entered(points, solids, found.neighbors, radius)]
    a, b, c, d = points[solids.T]
    is_mirrored = np.einsum("nk,nk->n", np.cross(b - a, c - a), d - a) < 0
    solids = np.where(is_mirrored[:, None], solids[:, [1, 0, 2, 3]], solids)
    sides = ([0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3])
    faces = np.concatenate([solids[:, side] for side in sides])
    _, at, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[at[counts == 1]]


def _is_entered(points: Floats, solids: Ints, neighbours: Ints, radius: float) -> Bools:
    """Which solids (n, 4) a ball comes to from outside, through sides in which it fits.

    `neighbours` (n, 4) are those opposite to the corners, -1 outside.
    """
    count = len(solids)
    sides = solids[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3)
    is_way = _radii(points, sides) >= radius
    first, second = np.repeat(np.arange(count), 4)[is_way], neighbours.ravel()[is_way]
    second = np.where(second < 0, count, second)
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(count + 1, count + 1))
    piece = connected_components(graph, directed=False)[1]
    entered: Bools = piece[:-1] == piece[-1]
    return entered


def _radii(points: Floats, triangles: Ints) -> Floats:
    """Radii (m,) of the circles through the corners of triangles (m, 3)."""
    edges = _edges(points, triangles)
    a, b, c = points[triangles.T]
    area = 2 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.divide(edges.prod(axis=1), area, out=np.full(len(area), np.inf), where=area > 0)


def _used(points: Floats, triangles: Ints | None) -> Mesh | None:
    """A mesh of the triangles (m, 3), without stray pieces and the points of none."""
    if triangles is None or len(triangles) < 4:
        return None
    ends = triangles[:, [0, 1, 1, 2]].reshape(-1, 2).T
    graph = coo_array((np.ones(len(ends[0])), ends), shape=(len(points), len(points)))
    piece = connected_components(graph, directed=False)[1][triangles[:, 0]]
    counts = np.bincount(piece)
    triangles = triangles[counts[piece] >= LEAST_PIECE * counts.max()]
    used, corners = np.unique(triangles, return_inverse=True)
    return Mesh(points[used], corners.reshape(-1, 3))

"""Convex hulls: of points, of two hulls together, with few corners, and points on them."""

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from workbench.formats.meshes.reading import MOST_NEIGHBOURS, convex_hull, most_neighbours
from workbench.model.geometry import Floats, Ints, Mesh

MOST_CORNERS = 300
"""Of a piece; one with more is replaced by one around it with about this many."""

FEW_CORNERS = 100
"""The same, of a hull that stands for a whole mesh."""

STICKS_OUT_BY = 0.0005
"""[m] The body around such a hull that sticks out no further has corners enough."""

MERGED_WITHIN = 1e-6
"""[m] Corners this close are one: that little a piece may be too small after all."""

THICK = 5e-5
"""[m] Half the thickness of the hull of something flat."""

POINT_SPACING = 0.5
"""Of a tolerance: this far apart, about, are points at which a hull is checked."""
FEWEST_POINTS, MOST_POINTS = 50, 4_000
"""Such points, at least and at most."""

ROWS = 0.754877666246693, 0.569840290998053
"""Multiples of these, less their whole parts, fill a square evenly (Roberts, R2 sequence)."""


def hull(mesh: Mesh) -> Mesh | None:
    """The convex hull, or one around it where that has too many edges at one corner."""
    found = convex_hull(mesh)
    if found is None or most_neighbours(found) <= MOST_NEIGHBOURS:
        return found
    return limit_corners(found, most=FEW_CORNERS, close=STICKS_OUT_BY)


def limit_corners(piece: Mesh, *, most: int, close: float) -> Mesh:
    """The piece, or a body around it with fewer corners.

    The body is cut by the piece's face planes, one by one; the next plane is the one beyond which
    the body reaches furthest.

    Args:
        piece: a convex piece.
        most: approximate limit of corners.
        close: the cutting ends when the body reaches no further beyond the piece [m].
    """
    if len(piece.points) <= most:
        return piece
    equations = ConvexHull(piece.points).equations
    axes = np.vstack([np.eye(3), -np.eye(3)])
    planes = np.column_stack([axes, -(np.asarray(piece.points) @ axes.T).max(axis=0)])
    inside = np.asarray(piece.points).mean(axis=0)
    try:
        around = HalfspaceIntersection(planes, inside, incremental=True)
        while len(around.intersections) < most:
            beyond = (around.intersections @ equations[:, :3].T + equations[:, 3]).max(axis=0)
            if beyond.max() < close:
                break
            around.add_halfspaces(equations[[beyond.argmax()]])
        return hull_mesh(around.intersections)
    except QhullError:
        return piece


def hull_mesh(points: Floats) -> Mesh:
    """The hull of points (n, 3) [m]; those within `MERGED_WITHIN` of each other count as one."""
    hull = ConvexHull(np.unique(np.round(points / MERGED_WITHIN) * MERGED_WITHIN, axis=0))
    corners, faces = hull.points[hull.vertices], hull.simplices
    number = np.zeros(len(hull.points), int)
    number[hull.vertices] = np.arange(len(corners))
    a, b, c = hull.points[faces.T]
    looks_in = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[looks_in] = faces[looks_in][:, ::-1]
    return Mesh(corners, number[faces], is_convex=True)


def hull_of(points: Floats) -> ConvexHull:
    """The hull of points (n, 3) [m]; of flat ones that of a thin sheet."""
    middle = points.mean(axis=0)
    axes = np.linalg.eigh((points - middle).T @ (points - middle))[1].T
    for axis, size in zip(axes, np.ptp((points - middle) @ axes.T, axis=0), strict=True):
        if size < 2 * THICK:
            points = np.vstack([points + THICK * axis, points - THICK * axis])
    return ConvexHull(points)


def together(first: ConvexHull, second: ConvexHull) -> ConvexHull:
    """The hull of two hulls."""
    return ConvexHull(np.vstack([hull.points[hull.vertices] for hull in (first, second)]))


def area_of(triangles: Floats) -> float:
    """The area of triangles (n, 3, 3) [m], in m2."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2


def points_for(area: float, tolerance: float) -> int:
    """How many points are checked on so much surface [m2] for a tolerance [m]."""
    return int(np.clip(area / (POINT_SPACING * tolerance) ** 2, FEWEST_POINTS, MOST_POINTS))


def points_on(triangles: Floats, count: int) -> tuple[Floats, Ints]:
    """`count` points on triangles (n, 3, 3) [m], then the centres (m, 3); their triangles (m,)."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    share = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    number = np.arange(count)
    of = np.searchsorted(share / share[-1], (number + 0.5) / count).clip(max=len(a) - 1)
    u, v = (np.modf(number * row)[0] for row in ROWS)
    is_beyond = u + v > 1
    u, v = np.where(is_beyond, 1 - u, u)[:, None], np.where(is_beyond, 1 - v, v)[:, None]
    points = a[of] + u * (b - a)[of] + v * (c - a)[of]
    return np.vstack([points, triangles.mean(axis=1)]), np.concatenate([of, np.arange(len(a))])


def outside(hull: ConvexHull, points: Floats) -> Floats:
    """How far points (n, 3) lie outside of a hull [m], (n,); negative inside."""
    return (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)

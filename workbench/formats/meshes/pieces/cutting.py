"""A mesh cut into few convex pieces that cover it, and hulls of few corners.

A hull is taken where it is close enough; otherwise the mesh is divided by CoACD, and every triangle
is put wholly into one piece, since a piece may only be too large, never too small.

Source: X. Wei, M. Liu, Z. Ling and H. Su, "Approximate convex decomposition for 3D meshes with
collision-aware concavity and tree search", ACM Transactions on Graphics 41(4), 2022.
"""

from importlib.metadata import version

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, HalfspaceIntersection, KDTree, QhullError

from workbench.formats.meshes.kept import content_of, kept, packed, unpacked
from workbench.formats.meshes.reading import MOST_NEIGHBOURS, convex_hull, most_neighbours
from workbench.model.geometry import Floats, Mesh

MOST_CORNERS = 100
"""Of a piece; one with more is replaced by one around it with about so many."""

CLOSE = 0.0005
"""[m] A body around a piece that sticks out no further has corners enough."""

SAME = 1e-5
"""[m] Corners this close are one: that little a piece may be too small after all."""

TOUCHING = 0.002
"""[m] What lies within another piece, or no further from it, is a cut between two pieces."""

SAMPLES = 4000
"""Points on a surface at which an excess is measured."""


def cut(mesh: Mesh, tolerance: float, most: int) -> tuple[tuple[Mesh, ...], float] | None:
    """Convex pieces of a mesh, and by how much they are larger [m]; None when it is flat.

    Args:
        mesh: any triangles; they need not close.
        tolerance: [m] a hull that is no more than this too large is taken as it is.
        most: pieces to divide it into otherwise.
    """
    hull = convex_hull(mesh)
    if hull is None:
        return None
    whole = bounded(hull)
    excess = _excess(mesh, (whole,))
    if excess <= tolerance or most < 2:
        return (whole,), excess
    pieces = tuple(bounded(piece) for piece in _covering(mesh, _divided(mesh, most)))
    divided = _excess(mesh, pieces)
    return (pieces, divided) if divided < excess else ((whole,), excess)


def hull(mesh: Mesh) -> Mesh | None:
    """The convex hull, or one around it where that has too many edges at one corner."""
    found = convex_hull(mesh)
    if found is None or most_neighbours(found) <= MOST_NEIGHBOURS:
        return found
    return bounded(found)


def _excess(mesh: Mesh, pieces: tuple[Mesh, ...]) -> float:
    """How far the outside of the pieces lies from the mesh, at samples of both surfaces [m]."""
    there = _samples(mesh, 5 * SAMPLES)
    tree = KDTree(there)
    largest = 0.0
    for number, piece in enumerate(pieces):
        points = _samples(piece, SAMPLES // len(pieces) + 1)
        others = [other for k, other in enumerate(pieces) if k != number]
        hidden = np.zeros(len(points), bool)
        for other in others:
            hidden |= _outside(other, points) < TOUCHING
        if not hidden.all():
            largest = max(largest, float(tree.query(points[~hidden])[0].max()))
    return largest


def _samples(mesh: Mesh, count: int) -> Floats:
    surface = trimesh.Trimesh(mesh.points, mesh.triangles, process=False)
    points = trimesh.sample.sample_surface(surface, count, seed=0)[0]
    return np.vstack([np.asarray(points), mesh.points])


def _outside(piece: Mesh, points: Floats) -> Floats:
    """How far points (n, 3) lie outside of a convex piece; negative inside."""
    equations = ConvexHull(piece.points).equations
    return (points @ equations[:, :3].T + equations[:, 3]).max(axis=1)


def _covering(mesh: Mesh, pieces: tuple[Mesh, ...]) -> list[Mesh]:
    """The pieces, grown so that every triangle lies wholly in one of them."""
    outside = np.stack([_outside(piece, np.asarray(mesh.points)) for piece in pieces])
    owner = outside[:, mesh.triangles].max(axis=2).argmin(axis=0)
    grown: list[Mesh] = []
    for number, piece in enumerate(pieces):
        corners = mesh.points[np.unique(mesh.triangles[owner == number])]
        hull = ConvexHull(np.vstack([piece.points, corners]))
        grown.append(hull_mesh(hull.points[hull.vertices]))
    return grown


def bounded(piece: Mesh, *, most: int = MOST_CORNERS, close: float = CLOSE) -> Mesh:
    """The piece, or one around it with fewer corners when it has very many.

    Planes of its faces are taken one by one, each time the one beyond which the body cut out so
    far sticks out most.

    Args:
        piece: convex.
        most: corners that it may have, about.
        close: [m] a body around it that sticks out no further has corners enough.
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
    """The hull of points (n, 3) [m], of which those within `SAME` of each other count as one."""
    hull = ConvexHull(np.unique(np.round(points / SAME) * SAME, axis=0))
    corners, faces = hull.points[hull.vertices], hull.simplices
    number = np.zeros(len(hull.points), int)
    number[hull.vertices] = np.arange(len(corners))
    a, b, c = hull.points[faces.T]
    looks_in = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[looks_in] = faces[looks_in][:, ::-1]
    return Mesh(corners, number[faces], is_convex=True)


def _divided(mesh: Mesh, most: int) -> tuple[Mesh, ...]:
    """CoACD's pieces; kept apart from what is made of them, since cutting takes longest."""
    how = f"{CUTTING} {version('coacd')} {most}"
    found = kept(how, content_of(mesh), lambda: packed(_by_coacd(mesh, most)))
    return unpacked(found or {})


CUTTING = "coacd/3"
"""Changes with the parameters below: pieces that were cut with others do not count."""


def _by_coacd(mesh: Mesh, most: int) -> tuple[Mesh, ...]:
    import coacd  # takes a while, and is seldom needed

    coacd.set_log_level("off")
    whole = coacd.Mesh(np.asarray(mesh.points), np.asarray(mesh.triangles, np.int32))
    found = coacd.run_coacd(
        whole,
        threshold=0.05,
        max_convex_hull=most,
        preprocess_resolution=40,
        resolution=1000,
        mcts_nodes=15,
        mcts_iterations=60,
        mcts_max_depth=2,
        seed=0,
    )
    return tuple(hull_mesh(np.asarray(points)) for points, _ in found)

"""A mesh as few convex pieces that cover it, and by how much they are larger.

Convex pieces are what the collision checker is quick and sure with.  A hull is taken where it is
close enough; otherwise the mesh is divided by CoACD, and every triangle is put wholly into one
piece, since a piece may only be too large, never too small.

Source: X. Wei, M. Liu, Z. Ling and H. Su, "Approximate convex decomposition for 3D meshes with
collision-aware concavity and tree search", ACM Transactions on Graphics 41(4), 2022.
"""

import contextlib
import hashlib
import os
import zipfile
import zlib
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from io import BytesIO
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, HalfspaceIntersection, KDTree, QhullError

from workbench.formats.files.whole_files import MB, make_folder, read_whole, write_whole
from workbench.formats.meshes.reading import MOST_NEIGHBOURS, convex_hull, most_neighbours
from workbench.model.errors import FileError
from workbench.model.geometry import Floats, Mesh

MOST_CORNERS = 100
"""Of a piece; one with more is replaced by one around it with about so many."""

CLOSE = 0.0005
"""[m] A body around a piece that sticks out no further has corners enough."""

SAME = 1e-5
"""[m] Corners this close are one: that little a piece may be too small after all."""

TOUCHING = 0.002
"""[m] What lies within another piece, or no further from it, is a cut between two pieces."""

LARGEST_CACHED = 64 * MB
SAMPLES = 4000
"""Points on a surface at which an excess is measured."""


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Convex meshes that together cover a mesh.

    `excess` [m]: how far their surface lies from that of the mesh at most, seen at samples.
    """

    pieces: tuple[Mesh, ...]
    excess: float


def pieces_of(mesh: Mesh, *, tolerance: float, most: int = 8) -> Pieces | None:
    """Convex pieces that cover a mesh.

    Args:
        mesh: any triangles; they need not close.
        tolerance: [m] a hull that is no more than this too large is taken as it is.
        most: pieces to divide it into otherwise.

    Returns:
        None when all points lie in one plane.
    """
    hull = convex_hull(mesh)
    if hull is None:
        return None
    whole = _bounded(hull)
    excess = _excess(mesh, (whole,))
    if excess <= tolerance or most < 2:
        return Pieces((whole,), excess)
    pieces = tuple(_bounded(piece) for piece in _covering(mesh, _divided(mesh, most)))
    divided = _excess(mesh, pieces)
    return Pieces(pieces, divided) if divided < excess else Pieces((whole,), excess)


def hull_of(mesh: Mesh) -> Mesh | None:
    """The convex hull of a mesh, or one around it where that has too many edges at one corner.

    None when all points lie in one plane.
    """
    hull = convex_hull(mesh)
    if hull is None or most_neighbours(hull) <= MOST_NEIGHBOURS:
        return hull
    return _bounded(hull)


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
        grown.append(_hull_mesh(hull.points[hull.vertices]))
    return grown


def _bounded(piece: Mesh) -> Mesh:
    """The piece, or one around it with fewer corners when it has very many.

    Planes of its faces are taken one by one, each time the one beyond which the body cut out so
    far sticks out most.
    """
    if len(piece.points) <= MOST_CORNERS:
        return piece
    equations = ConvexHull(piece.points).equations
    axes = np.vstack([np.eye(3), -np.eye(3)])
    planes = np.column_stack([axes, -(np.asarray(piece.points) @ axes.T).max(axis=0)])
    inside = np.asarray(piece.points).mean(axis=0)
    try:
        around = HalfspaceIntersection(planes, inside, incremental=True)
        while len(around.intersections) < MOST_CORNERS:
            beyond = (around.intersections @ equations[:, :3].T + equations[:, 3]).max(axis=0)
            if beyond.max() < CLOSE:
                break
            around.add_halfspaces(equations[[beyond.argmax()]])
        return _hull_mesh(around.intersections)
    except QhullError:
        return piece


def _hull_mesh(points: Floats) -> Mesh:
    """The hull of points (n, 3), of which those within `SAME` of each other count as one."""
    hull = ConvexHull(np.unique(np.round(points / SAME) * SAME, axis=0))
    corners, faces = hull.points[hull.vertices], hull.simplices
    number = np.zeros(len(hull.points), int)
    number[hull.vertices] = np.arange(len(corners))
    a, b, c = hull.points[faces.T]
    looks_in = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[looks_in] = faces[looks_in][:, ::-1]
    return Mesh(corners, number[faces], is_convex=True)


def _divided(mesh: Mesh, most: int) -> tuple[Mesh, ...]:
    """CoACD's pieces, from the cache when the same mesh was divided before."""
    content = [np.ascontiguousarray(mesh.points), np.ascontiguousarray(mesh.triangles)]
    key = hashlib.sha256(f"{CUTTING} {version('coacd')} {most}".encode())
    for array in content:
        key.update(array.tobytes())
    path = cache_folder() / f"{key.hexdigest()}.npz"
    kept = _kept(path)
    if kept is not None:
        return kept
    pieces = _by_coacd(mesh, most)
    arrays = {f"p{k}": piece.points for k, piece in enumerate(pieces)}
    arrays |= {f"t{k}": piece.triangles for k, piece in enumerate(pieces)}
    buffer = BytesIO()
    np.savez(buffer, **arrays)  # type: ignore[arg-type]
    # Where nothing can be kept the next start takes longer, and that is all.
    with contextlib.suppress(FileError):
        make_folder(path.parent)
        write_whole(path, buffer.getvalue())
    return pieces


def _kept(path: Path) -> tuple[Mesh, ...] | None:
    """Pieces from the cache; None when there are none, or what is there is none of ours."""
    try:
        with np.load(BytesIO(read_whole(path, LARGEST_CACHED))) as found:
            count = len(found.files) // 2
            kept = tuple(Mesh(found[f"p{k}"], found[f"t{k}"], True) for k in range(count))
            return kept or None
    except (FileError, ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile, zlib.error):
        return None


@lru_cache(maxsize=1)
def cache_folder() -> Path:
    """Where what took long to make is kept between runs."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "workbench" / "pieces"


CUTTING = "coacd/2"
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
    return tuple(_hull_mesh(np.asarray(points)) for points, _ in found)

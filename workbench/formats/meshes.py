"""Triangle meshes from files, in metres."""

from pathlib import Path

import numpy as np
import trimesh

from workbench.model.errors import FileError
from workbench.model.geometry import Floats, Mesh

LARGEST_MESH = 100 * 1024 * 1024
MOST_TRIANGLES = 1_000_000
LARGEST_EXTENT = 20.0
"""[m] Anything larger is taken for millimetres read as metres."""


def read_mesh(path: Path, scale: Floats | float = 1.0) -> Mesh:
    """The triangles of an STL, OBJ, PLY, GLB or DAE file, multiplied by `scale`.

    Raises:
        FileError: not there, too large, not a mesh, empty, not finite, or of a size that
            speaks for another unit.
    """
    if not path.is_file():
        raise FileError(path, "there is no such mesh file")
    if path.stat().st_size > LARGEST_MESH:
        raise FileError(path, f"is larger than {LARGEST_MESH // 1024 // 1024} MB")
    try:
        loaded = trimesh.load_mesh(path, process=False)
    except Exception as error:  # the loaders behind trimesh raise whatever they like
        raise FileError(path, f"cannot be read as a mesh: {error}") from None
    if not isinstance(loaded, trimesh.Trimesh) or len(loaded.faces) == 0:
        raise FileError(path, "holds no triangles")
    if len(loaded.faces) > MOST_TRIANGLES:
        raise FileError(path, f"has {len(loaded.faces)} triangles, {MOST_TRIANGLES} are allowed")
    points = np.asarray(loaded.vertices, dtype=np.float64) * scale
    if not np.all(np.isfinite(points)):
        raise FileError(path, "holds a point that is not finite")
    size = float(np.ptp(points, axis=0).max())
    if size > LARGEST_EXTENT:
        raise FileError(
            path, f"would be {size:.0f} m large; if it is in millimetres, scale it by 0.001"
        )
    return Mesh(points, np.asarray(loaded.faces))


def convex_hull(mesh: Mesh) -> Mesh:
    """The convex hull as a solid convex mesh."""
    hull = trimesh.Trimesh(mesh.points, mesh.triangles, process=False).convex_hull
    return Mesh(hull.vertices, hull.faces, is_convex=True)

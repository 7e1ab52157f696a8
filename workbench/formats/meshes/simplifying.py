"""Very fine surfaces made coarser, with a bound on how far they move.

Source: the library manifold3d, which collapses edges and keeps a closed surface closed.
"""

from pathlib import Path

import numpy as np

from workbench.model.errors import FileError
from workbench.model.geometry import Mesh
from workbench.model.messages.files import FileProblem

LARGE = 200_000
"""Triangles of a part; one with more is simplified."""

FIRST_DEVIATION = 2e-5
"""Deviation [m] allowed at first; it is doubled until the mesh has few enough triangles."""

COARSEST = 0.004
"""Of the part's size: if that is not enough, somebody has to do it in CAD."""


def simplify_mesh(path: Path, mesh: Mesh) -> tuple[Mesh, str]:
    """A surface with at most `LARGE` triangles, and what was done, in words.

    Args:
        path: of the file that it is from.
        mesh: its corners joined.

    Raises:
        FileError: it is not closed, or remains too fine.
    """
    import manifold3d  # takes a while, and is seldom needed

    count = len(mesh.triangles)
    whole = manifold3d.Manifold(
        manifold3d.Mesh64(
            vert_properties=np.array(mesh.points, np.float64, order="C"),
            tri_verts=np.array(mesh.triangles, np.uint64, order="C"),
        )
    )
    if whole.status() != manifold3d.Error.NoError:
        raise FileError(path, FileProblem.EXPORT_OPEN(count=count, most=LARGE))
    off = FIRST_DEVIATION
    coarsest = COARSEST * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    while off <= max(coarsest, FIRST_DEVIATION):
        fewer = whole.simplify(off).to_mesh64()
        if 4 <= len(fewer.tri_verts) <= LARGE:
            points = np.asarray(fewer.vert_properties)[:, :3]
            made = Mesh(points, np.asarray(fewer.tri_verts).astype(np.int64))
            words = f"simplified from {count} to {len(made.triangles)} triangles"
            return made, f"{words}, at most {off * 1000:g} mm off"
        off *= 2
    raise FileError(path, FileProblem.EXPORT(count=count, most=LARGE))

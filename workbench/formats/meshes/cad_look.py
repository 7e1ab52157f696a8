"""What a CAD file holds, before anything is made of it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.formats.meshes.cad_bodies import read_bodies
from workbench.formats.meshes.cad_files import read_cad
from workbench.formats.meshes.repair import SurfaceReport, examine_surface, joined_corners
from workbench.model.geometry import Floats


@dataclass(frozen=True, slots=True, eq=False)
class CadLook:
    """The surface in a file; `low` and `high` (3,) [m] are its corners in the file's frame.

    `unit` is that it was read in, empty if the file says it; `is_assumed`: nobody has said so, only
    this one gives the size of a part or a tool.  `solids` names those of a file that holds several,
    one of each shape.
    """

    surface: SurfaceReport
    low: Floats
    high: Floats
    unit: str
    is_assumed: bool
    solids: tuple[str, ...] = ()


def look_at(file: Path, unit: str = "", solid: str = "") -> CadLook:
    """Read a CAD file and tell what it holds; for a process of its own (`formats.files.apart`).

    Args:
        file: a CAD file, or a zip file with one.
        unit: mm, m or inch; empty when the file says it or it is not known.
        solid: name of the solid to look at; empty: all of them as they are placed.

    Raises:
        FileError: it cannot be read (`read_cad`).
    """
    cad = read_cad(file, unit or None, solid=solid or None, read=read_bodies)
    mesh, _ = joined_corners(cad.mesh)
    points = np.asarray(mesh.points)
    low, high = points.min(axis=0), points.max(axis=0)
    return CadLook(examine_surface(mesh), low, high, cad.unit, cad.is_assumed, cad.solids)

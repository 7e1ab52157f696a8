"""A folder for a new part: `part.toml`, its mesh in millimetres, and grasps to be written."""

import json
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.formats.files.toml_documents import numbers
from workbench.formats.files.whole_files import write_whole
from workbench.formats.meshes.cad_files import CadMesh, read_cad
from workbench.formats.meshes.repair import Surface, examined, joined_corners, repaired
from workbench.formats.meshes.triangles import stl_of, triangles_of
from workbench.formats.parts.reading import read_part
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Mesh
from workbench.model.part import Part
from workbench.model.symmetry import Symmetry
from workbench.plugins.progress import Report, silent

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}")

PLASTIC = 1200.0
"""[kg/m3] What a part is taken to be made of when nobody says."""

TOLERANCE = 0.001
"""[m] A hull that is no more than this too large is taken as it is; stands in `part.toml`."""

THINNEST = 1e-4
"""The share of its box that a body must fill; a surface around less encloses nothing."""

GRASPS = """\
# Grasps of {name}; lengths in mm, angles in degrees, all in the part's frame (see part.toml).
# `workbench grasps suggest {name} --cell CELL --add` writes some; keys: see parts/keyed_cylinder.
"""


@dataclass(frozen=True, slots=True, eq=False)
class Imported:
    """A surface that can become a part, and what was done to get it.

    `mesh` [m] has its corners joined; `done` says in words what was left out and mended.
    """

    source: Path
    cad: CadMesh
    mesh: Mesh
    surface: Surface
    done: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class WrittenPart:
    """A part as its folder has it now."""

    folder: Path
    part: Part


def import_mesh(path: Path, unit: str | None = None, *, repair: bool = False) -> Imported:
    """Read a CAD file and look whether its surface can be that of a part.

    Args:
        path: STL, OBJ, PLY, GLB or STEP.
        unit: mm, m or inch; None when the file says it or it is not known.
        repair: mend what can be mended.

    Raises:
        FileError: it cannot be read (`read_cad`), or its surface is not closed, with the reason.
    """
    cad = read_cad(path, unit)
    mesh, done = joined_corners(cad.mesh)
    if len(mesh.triangles) < 4:
        raise FileError(path, f"has {len(mesh.triangles)} triangles, a body has four at least")
    surface = examined(mesh)
    if surface.problems and repair:
        mesh, mended = repaired(mesh)
        done, surface = (*done, *mended), examined(mesh)
    if surface.problems:
        help = "it could not be repaired; mend it in CAD" if repair else "have it mended (--repair)"
        raise FileError(path, f"its surface is not closed: {', '.join(surface.problems)}; {help}")
    if surface.volume < THINNEST * float(np.prod(surface.size)):
        raise FileError(path, "its surface encloses nothing")
    return Imported(path, cad, mesh, surface, done)


def check_name(name: str) -> None:
    """Refuse what no part and no folder should be called.

    Raises:
        InputError: says what is expected.
    """
    if not NAME.fullmatch(name):
        raise InputError(f"name {name!r}: letters, digits, - and _ are expected, 1 to 60 of them")


def write_part(
    into: Path,
    name: str,
    imported: Imported,
    *,
    mass: float,
    symmetry: Symmetry | None = None,
    proposal: str = "",
    report: Report = silent,
) -> WrittenPart:
    """Make the folder of a new part, all of it or nothing.

    Args:
        into: the folder of parts; made when missing.
        name: of the part and its folder.
        imported: its surface.
        mass: [kg].
        symmetry: that a person has accepted; None when nobody has.
        proposal: a comment on the symmetry found, for a person to confirm.
        report: takes the share done and what is being done.

    Raises:
        InputError: the name is none.
        FileError: the folder is there already, or cannot be written.
    """
    check_name(name)
    folder = into / name
    if os.path.lexists(folder):
        raise FileError(folder, "is there already; choose another name, or remove it first")
    try:
        into.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(prefix=f".{name}-", dir=into))
    except OSError as error:
        raise FileError(into, error.strerror or "cannot be written") from None
    try:
        made.chmod(0o755)
        text = "\n".join(_lines(name, imported, mass, symmetry, proposal)) + "\n"
        write_whole(made / "part.toml", text.encode())
        surface = triangles_of(imported.mesh)
        write_whole(made / f"{name}.stl", stl_of(surface.apply_scale(1000)))
        write_whole(made / "grasps.toml", GRASPS.format(name=name).encode())
        report(0.2, "convex pieces")
        part = read_part(made / "part.toml")  # divides the mesh, and keeps the pieces for later
        try:
            made.rename(folder)
        except OSError as error:
            raise FileError(folder, error.strerror or "cannot be written") from None
    finally:
        shutil.rmtree(made, ignore_errors=True)
    return WrittenPart(folder, part)


def _lines(
    name: str, imported: Imported, mass: float, symmetry: Symmetry | None, proposal: str
) -> Iterator[str]:
    source, unit = imported.source.name, imported.cad.unit or "its own unit"
    size = ", ".join(f"{length * 1000:.4g}" for length in imported.surface.size)
    yield f"# Made from {json.dumps(source)}, read in {unit}.  Its frame is that of the file."
    yield f"# {size} mm, {imported.surface.volume * 1e6:.4g} cm3."
    yield f"name = {json.dumps(name)}"
    yield f"mass_g = {mass * 1000:.6g}"
    yield "# friction = 0.4     # against pads or cup: stated, grips are checked for its weight"
    yield f"tolerance_mm = {TOLERANCE * 1000:g}     # a convex hull this much too large will do"
    yield ""
    yield f"# The surface that the scanner sees, {imported.surface.triangles} triangles."
    yield from ("[mesh]", f'file = "{name}.stl"', 'unit = "mm"', "")
    yield "# Turns about an axis that leave the part as it is: 1 none, n by 360/n degrees, 0 any."
    yield "# It passes the origin, or point_mm; what there is beside it stands in also, such as"
    yield "# also = [{axis = [1, 0, 0], fold = 2}]."
    if proposal:
        yield f"# Found in the mesh: {proposal}"
    stated = symmetry or Symmetry()
    yield from ("[symmetry]", f"axis = {numbers(stated.axis)}", f"fold = {stated.fold}")
    if any(stated.point):
        yield f"point_mm = {numbers(1000 * np.array(stated.point))}"
    if stated.also:
        each = (f"{{axis = {numbers(one.axis)}, fold = {one.fold}}}" for one in stated.also)
        yield f"also = [{', '.join(each)}]"

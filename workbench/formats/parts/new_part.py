"""A folder for a new part: `part.toml`, its mesh in millimetres, and grasps to be written."""

import json
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePath

import numpy as np

from workbench.formats.files.toml_documents import numbers
from workbench.formats.files.whole_files import write_whole
from workbench.formats.meshes.cad_files import PLASTIC, CadMesh, mass_words, read_cad
from workbench.formats.meshes.reading import is_flat
from workbench.formats.meshes.repair import (
    SurfaceReport,
    examine_surface,
    joined_corners,
    outside_out,
    repair_surface,
)
from workbench.formats.meshes.simplifying import LARGE, simplify_mesh
from workbench.formats.meshes.triangles import stl_of, triangles_of
from workbench.formats.parts.reading import read_part, tolerance_of
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Mesh
from workbench.model.messages.files import FileProblem
from workbench.model.messages.work import ProgressText
from workbench.model.part import Part
from workbench.model.symmetry import Symmetry
from workbench.plugins.progress import Report, silent

PART_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}")

HEAVIEST = 1000.0
"""[kg] Of what is picked; what is heavier has another unit."""

LIGHTEST = 1e-5
"""[kg] Nothing lighter is picked; its unit is another, or nobody can hold it."""

THINNEST = 1e-4
"""The share of its box that a body must fill; a surface around less encloses nothing."""

GRASPS = """\
# Grasps of {name}; lengths in mm, angles in degrees, all in the part's frame (see part.toml).
# `workbench grasps suggest {name} --cell CELL --add` writes some; keys: see parts/keyed_cylinder.
# Where none takes a part, a plan tries all grips of the tools:
search = true
"""


@dataclass(frozen=True, slots=True, eq=False)
class Imported:
    """A surface that can become a part, and what was done to get it.

    `mesh` [m] has its corners joined; `done` says in words what was left out and mended.
    """

    source: Path
    cad: CadMesh
    mesh: Mesh
    surface: SurfaceReport
    done: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class WrittenPart:
    """A part as its folder has it now."""

    folder: Path
    part: Part


def import_mesh(
    path: Path,
    unit: str | None = None,
    *,
    repair: bool = False,
    solid: str | None = None,
    is_open: bool = False,
    density: float = PLASTIC,
    report: Report = silent,
) -> Imported:
    """Read a CAD file and look whether its surface can be that of a part.

    Args:
        path: of the file.
        unit: mm, m or inch; None when the file says it or it is not known.
        repair: mend what can be mended.
        solid: which of several solids, see `read_cad`.
        is_open: take a surface that cannot be closed as it is.
        density: [kg/m3], to say what each unit would mean.
        report: takes the share done and what is being done.

    Raises:
        FileError: it cannot be read (`read_cad`), or its surface is not closed, with the reason.
    """
    cad = read_cad(path, unit, solid=solid, density=density)
    report(0.4, ProgressText.JOINING())
    mesh, done = joined_corners(cad.mesh)
    if len(mesh.triangles) < 4:
        raise FileError(path, f"has {len(mesh.triangles)} triangles, a body has four at least")
    if is_flat(np.asarray(mesh.points)):
        raise FileError(path, FileProblem.FLAT())
    surface = examine_surface(mesh)
    if surface.is_inside_out:
        mesh, turned = outside_out(mesh)
        done, surface = (*done, *turned), examine_surface(mesh)
    is_hollow = surface.is_watertight and _encloses_nothing(surface)
    if (surface.problems or is_hollow) and repair:
        report(0.6, ProgressText.MENDING())
        mesh, mended = repair_surface(mesh)
        done, surface = (*done, *mended), examine_surface(mesh)
    if surface.problems and not is_open:
        help = FileProblem.NOT_REPAIRED() if repair else FileProblem.REPAIR()
        problems = tuple(surface.problems)
        raise FileError(path, FileProblem.NOT_CLOSED(problems=problems, repair=help))
    if not surface.problems and _encloses_nothing(surface):
        raise FileError(path, FileProblem.NO_VOLUME())
    if len(mesh.triangles) > LARGE:
        report(0.8, ProgressText.SIMPLIFYING(count=len(mesh.triangles)))
        mesh, words = simplify_mesh(path, mesh)
        done, surface = (*done, words), examine_surface(mesh)
    return Imported(path, cad, mesh, surface, done)


def _encloses_nothing(surface: SurfaceReport) -> bool:
    return surface.volume < THINNEST * float(np.prod(surface.size))


def mass_of(imported: Imported, density: float, mass: float | None) -> float:
    """The mass of a new part [kg], which `density` [kg/m3] or a person says.

    Raises:
        FileError: it is not known, or that of no part.
    """
    if mass is not None:
        return mass
    if imported.surface.problems:
        raise FileError(imported.source, FileProblem.NO_MASS())
    weighs = imported.surface.volume * density
    if not LIGHTEST <= weighs <= HEAVIEST:
        size = " x ".join(f"{length * 1000:.4g}" for length in imported.surface.size)
        mass_text = mass_words(weighs)
        raise FileError(imported.source, FileProblem.MASS(size=size, mass=mass_text))
    return weighs


def check_name(name: str) -> None:
    """Refuse what no part and no folder should be called.

    Raises:
        InputError: says what is expected.
    """
    if not PART_NAME.fullmatch(name):
        raise InputError(FileProblem.PART_NAME(name=repr(name)))


def name_after(file: str) -> str:
    """A name that a part may have, after that of its CAD file."""
    letters = (c if c.isalnum() and c.isascii() else "_" for c in PurePath(file).stem)
    return "".join(letters).strip("_")[:60] or "part"


def free_name(into: Path, name: str) -> str:
    """The name of a new part, with a number behind it where a part of that name is there."""
    names = (name, *(f"{name[:56]}_{number}" for number in range(2, 100)))
    return next((free for free in names if not os.path.lexists(into / free)), name)


def check_new(into: Path, name: str) -> Path:
    """The folder that a new part of that name gets, in the folder of parts.

    Raises:
        InputError: the name is none.
        FileError: the folder is there already.
    """
    check_name(name)
    folder = into / name
    if os.path.lexists(folder):
        raise FileError(folder, FileProblem.EXISTS())
    return folder


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
    folder = check_new(into, name)
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
        report(0.2, ProgressText.CONVEX_PIECES())
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
    yield f"mass_g = {max(mass * 1000, 0.001):.6g}"
    yield "# friction = 0.4     # against pads or cup: stated, grips are checked for its weight"
    tolerance = f"{tolerance_of(imported.mesh) * 1000:.3g}"
    yield f"tolerance_mm = {tolerance}     # by so much may bodies for distances be too large"
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
        each = (f"{{axis = {numbers(axis.axis)}, fold = {axis.fold}}}" for axis in stated.also)
        yield f"also = [{', '.join(each)}]"

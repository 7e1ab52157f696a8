"""From a CAD file to a part with its folder: the steps that page and command line share."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from workbench.app.core.cell.making import ImportPart
from workbench.formats.files.whole_files import write_upload
from workbench.formats.meshes.cad_files import PLASTIC
from workbench.formats.meshes.pieces import convex_pieces
from workbench.formats.parts.new_part import (
    Imported,
    WrittenPart,
    check_new,
    import_mesh,
    mass_of,
    write_part,
)
from workbench.model.errors import JobCancelled
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.parts import SymmetryText
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.part import Part
from workbench.planning.grasps.part_symmetry import FoundSymmetry, proposed_symmetry
from workbench.plugins.progress import Cancelled, Report, silent

PARTS = Path("parts")
"""Folder of new parts, in the working directory."""


@dataclass(frozen=True, slots=True, eq=False)
class MadePart:
    """Result of an import: the surface, the part as written, and its symmetry.

    `excess` [m] is the largest distance of its convex pieces outside of the surface.
    """

    imported: Imported
    written: WrittenPart
    symmetry: FoundSymmetry | None
    excess: float


@dataclass(frozen=True, slots=True)
class CadChoices:
    """How a CAD file is read.

    `unit` is mm, m or inch; None if the file states it or only one is plausible.  `solid` selects
    one of several solids, see `read_cad`.  `repair` mends the surface; `is_open` accepts
    a surface that cannot be closed.
    """

    unit: str | None = None
    solid: str | None = None
    repair: bool = False
    is_open: bool = False


def make_part(
    file: Path,
    name: str,
    into: Path,
    choices: CadChoices,
    *,
    density: float = PLASTIC,
    mass: float | None = None,
    is_symmetric: bool = False,
    report: Report = silent,
) -> MadePart:
    """Read a CAD file and make the folder of a part.

    Args:
        file: a CAD file, or a zip file with one.
        name: of the part and its folder.
        into: the folder of parts.
        choices: how the file is read.
        density: [kg/m3], for the mass.
        mass: [kg], when it is known.
        is_symmetric: state the symmetry that is found; otherwise it is a remark in the file.
        report: takes the share done and what is being done.

    Raises:
        InputError: the name cannot be used.
        FileError: the file cannot be used, or the folder is there or cannot be written.
    """
    check_new(into, name)
    report(0.0, ProgressText.READING())
    imported = import_mesh(
        file,
        choices.unit,
        repair=choices.repair,
        solid=choices.solid,
        is_open=choices.is_open,
        density=density,
        report=lambda done, note: report(0.2 * done, note),
    )
    weighs = mass_of(imported, density, mass)
    report(0.2, ProgressText.SYMMETRY())
    found = proposed_symmetry(imported.mesh)
    written = write_part(
        into,
        name,
        imported,
        mass=weighs,
        symmetry=found.symmetry if found is not None and is_symmetric else None,
        proposal="" if found is None else str(symmetry_words(found)),
        report=lambda done, note: report(0.3 + 0.6 * done, note),
    )
    report(0.9, ProgressText.EXCESS())
    return MadePart(imported, written, found, excess_of(written.part))


@lru_cache(maxsize=64)
def excess_of(part: Part) -> float:
    """How far the convex pieces of a part stick out of its surface at most [m]."""
    return convex_pieces.excess_of(part.mesh, part.pieces)


def symmetry_words(found: FoundSymmetry) -> Message:
    """A symmetry for people."""
    symmetry = found.symmetry
    turns = [_turns(axis.fold, _numbers(axis.axis)) for axis in symmetry.axes]
    args = {"turns": turns, "symmetry": str(symmetry), "off": found.deviation}
    if any(symmetry.point):
        point = _numbers(1000 * np.array(symmetry.point))
        return SymmetryText.FOUND_THROUGH(point=point, **args)
    return SymmetryText.FOUND(**args)


def _turns(fold: int, axis: str) -> Message:
    if fold == 0:
        return SymmetryText.ANY_TURN(axis=axis)
    return SymmetryText.TURNS(angle=f"{360 / fold:g}", axis=axis)


def _numbers(values: Floats) -> str:
    return f"[{', '.join(f'{value + 0.0:g}' for value in np.round(values, 4))}]"


def imported_part(command: ImportPart, report: Report, cancelled: Cancelled) -> Part:
    """The part that a command asks for, its folder written.

    Raises:
        JobCancelled: before anything was written.
        InputError: the file cannot be used, see `make_part`.
    """
    # Its own name goes into the part's file.
    with write_upload(command.file, command.content.data) as file:

        def go_on(done: float, note: Message | str) -> None:
            if cancelled():
                raise JobCancelled(CancelText.IMPORT())
            report(done, note)

        return make_part(
            file,
            command.name,
            PARTS,
            CadChoices(command.unit or None, command.solid or None, repair=command.is_mended),
            density=command.density,
            is_symmetric=command.is_symmetric,
            report=go_on,
        ).written.part

"""What may be made and edited: what files can hold, and nobody has changed meanwhile."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import get_args

from workbench.app.core.commands import AddTool, EditPart, ImportPart, TryEmptying
from workbench.app.core.value_checks import (
    MOST_PARTS,
    MOST_PILES,
    SEED_LIMIT,
    check_among,
    check_integer,
    check_number,
    check_text,
)
from workbench.formats.cells.drawn_tools import check_drawn
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import MB
from workbench.formats.meshes.cad_files import KINDS, LARGEST_CAD
from workbench.formats.parts.grasp_files import as_written
from workbench.formats.parts.new_part import check_name
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, InputError
from workbench.model.part import Entry, GraspLibrary, GraspPattern, Part
from workbench.model.part_edits import edited
from workbench.model.prediction import CHANGE_KINDS, Seen
from workbench.model.symmetry import Symmetry

DENSITIES = (10.0, 25_000.0)
"""[kg/m3] From foam to more than gold."""

MOST_KINDS = 20
"""Parts of one cell: each is searched for in every scan."""

MOST_TOOLS = 20
"""That one arm can carry."""

MOST_GRASPS = 10_000
"""Of one part, with patterns and symmetry written out."""


def part_of(cell: Cell, name: str) -> Part:
    """The part of that name.

    Raises:
        CommandRefused: there is none.
    """
    try:
        return cell.part(name)
    except InputError as error:
        raise CommandRefused(str(error)) from error


def check_edit(cell: Cell, edit: EditPart) -> None:
    """What is edited is there, and what comes of it can be kept in files.

    Raises:
        CommandRefused: it is not, or cannot.
    """
    part = part_of(cell, edit.part)
    try:
        after = edited_part(part, edit)
    except InputError as error:
        raise CommandRefused(str(error)) from error
    if after.digest == part.digest:
        raise CommandRefused(f"nothing of part {part.name} was changed")


def check_emptying(cell: Cell, command: TryEmptying) -> None:
    """Piles of parts that the cell picks, no more of them than can be emptied in one task.

    Raises:
        CommandRefused: other parts, too many or too few, or changes of a kind that there is not.
    """
    known = tuple(part.name for part in cell.parts)
    for kind in command.kinds:
        check_among("part", kind, known)
    if len(set(command.kinds)) < len(command.kinds):
        raise CommandRefused(f"each part is named once, not {', '.join(command.kinds)}")
    check_integer("parts", command.count, 1, MOST_PARTS)
    check_integer("piles", command.piles, 1, MOST_PILES)
    check_integer("seed", command.seed, 0, SEED_LIMIT - MOST_PILES)
    check_among("seen", command.seen, get_args(Seen))
    for kind in command.changes:
        check_among("kind of change", kind, CHANGE_KINDS)


def check_import(cell: Cell, command: ImportPart) -> None:
    """A part of this name can be made of such a file.

    Raises:
        CommandRefused: it cannot.
    """
    check_text("file", command.file)
    try:
        check_name(command.name)
    except InputError as error:
        raise CommandRefused(str(error)) from error
    if command.name in (part.name for part in cell.parts):
        raise CommandRefused(f"the cell has a part {command.name} already; choose another name")
    if len(cell.parts) >= MOST_KINDS:
        raise CommandRefused(f"a cell has up to {MOST_KINDS} parts")
    kind = PurePosixPath(command.file).suffix.lower()
    if kind not in KINDS:
        raise CommandRefused(f"{command.file} is no CAD file: one of {', '.join(KINDS)} is")
    if not 0 < command.content.size <= LARGEST_CAD:
        raise CommandRefused(
            f"{command.file} has {command.content.size:,} bytes; up to {LARGEST_CAD / MB:g} MB "
            "are taken"
        )
    check_among("unit", command.unit, ("", *UNITS))
    check_number("density", command.density, *DENSITIES, "kg/m3")


def check_tool(cell: Cell, command: AddTool) -> None:
    """A tool can be meant so, and the arm that shall carry it has room for it.

    Raises:
        CommandRefused: it cannot, or has none.
    """
    name = command.drawn.name
    check_among("arm", command.arm, tuple(arm.name for arm in cell.arms))
    try:
        check_drawn(command.drawn)
    except InputError as error:
        raise CommandRefused(str(error)) from error
    known = {tool.name for arm in cell.arms for tool in (arm.tool, *arm.tools)}
    if name in known:
        raise CommandRefused(f"the cell has a tool {name} already; choose another name")
    if len(cell.arm(command.arm).tools) >= MOST_TOOLS:
        raise CommandRefused(f"an arm has up to {MOST_TOOLS} tools")


def edited_part(part: Part, edit: EditPart) -> Part:
    """The part after an edit, its numbers as files hold them.

    Raises:
        InputError: what was edited is not there any more, or cannot be kept in a file.
    """
    symmetry = edit.symmetry or part.symmetry
    symmetry.check()
    # Counted before anything is written out.
    _check_count(edit.now, symmetry)
    library = part.library
    if edit.was or edit.now:
        library = edited(library, edit.was, as_written(GraspLibrary(edit.now)).entries)
    if edit.pairs is not None:
        library = as_written(replace(library, pairs=edit.pairs))
    _check_count(library.entries, symmetry)
    return replace(part, library=library, symmetry=symmetry)


def _check_count(entries: Sequence[Entry], symmetry: Symmetry) -> None:
    count = sum(entry.count if isinstance(entry, GraspPattern) else 1 for entry in entries)
    count *= 1 + len(symmetry.turns)
    if count > MOST_GRASPS:
        raise InputError(
            f"with patterns and symmetry written out there would be {count:,} grasps; "
            f"{MOST_GRASPS:,} are allowed"
        )

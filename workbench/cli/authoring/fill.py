"""`workbench grasps suggest --fill`: the library with which a cell's bin is emptied of a part."""

from dataclasses import replace
from pathlib import Path

from workbench.app.filling.fill import Filled, filled
from workbench.app.filling.words import filled_words
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.part import Grasps
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json, print_table, progress
from workbench.formats.files.shipped import find
from workbench.formats.parts.grasp_files import keys_of, save_grasps
from workbench.model.cell import Cell
from workbench.model.part import Entry, GraspPattern, Part, grasps_of


def fill(typed: Grasps, part: Part, cell: Cell) -> int:
    """Fill the library, write it and print what it takes."""
    if typed.arm is not None:
        arms = (cell.arm(typed.arm),)
        cell = replace(cell, arms=arms)
    with progress("grasps") as report:
        make_ready(report, ("planning",))
        found = filled(cell, part, seed=typed.seed, report=report)
    file = grasps_file(typed.part)
    if found.entries:
        library = part.library
        entries = (*library.entries, *found.entries)
        save_grasps(file, replace(library, entries=entries, searches=True))
    if typed.json:
        print_json(_form(found, file))
    else:
        _print(found, part, cell, file)
    return SUCCESS if found.entries else NO_PLAN


def grasps_file(part: str) -> Path:
    """Where the grasps of a part stand, by its name or place."""
    place = find("parts", part)
    return (place if place.is_dir() else place.parent) / "grasps.toml"


def _print(found: Filled, part: Part, cell: Cell, file: Path) -> None:
    if found.entries:
        print_table(
            f"Grasps of {part.name} for {cell.name}",
            ("grasp", "copies", "takes besides", "priority", "closed to mm", "tilt degrees"),
            [_row(entry, adds) for entry, adds in zip(found.entries, found.adds, strict=True)],
        )
    for line in filled_words(found):
        print(line)
    if found.entries:
        print(f"{len(found.entries)} families of grasps added to {file}")


def _row(entry: Entry, adds: float) -> tuple[str, ...]:
    keys, copies = keys_of(entry), len(grasps_of(entry))
    return (
        entry.name,
        str(copies) if isinstance(entry, GraspPattern) else "",
        f"{adds:.0%}",
        str(keys.get("priority", 0)),
        f"{keys['grip_mm']:g}",
        f"{keys.get('tilt_deg', 0):g}",
    )


def _form(found: Filled, file: Path) -> dict[str, object]:
    return {
        "ok": bool(found.entries),
        "grasps": [
            {**keys_of(entry), "takes_besides": round(adds, 4)}
            for entry, adds in zip(found.entries, found.adds, strict=True)
        ],
        "parts": found.parts,
        "taken": found.taken,
        "stays": [{"said": reason.program_form, "parts": count} for reason, count in found.stays],
        "helps": [{"said": change.program_form, "parts": count} for change, count in found.helps],
        "said": [message.program_form for message in filled_words(found)],
        "seconds": round(found.seconds, 1),
        "added_to": str(file) if found.entries else None,
    }

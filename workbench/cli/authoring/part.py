"""`workbench part`: from a CAD file to a part, and whether it is fit for picking."""

from typing import Any

import numpy as np

from workbench.app.core.cell.making import DENSITIES
from workbench.app.picking.part_import import CadChoices, MadePart, make_part, symmetry_words
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.part import PartImport, PartList
from workbench.cli.authoring.part_check import (
    count_pieces,
    counted_pieces,
    exactness,
    format_count,
    millimetres,
)
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, print_json, print_table, progress
from workbench.formats.files.shipped import folders
from workbench.formats.meshes.cad_files import SeveralSolids, is_unusual
from workbench.formats.parts.new_part import HEAVIEST, LIGHTEST, check_name, name_after
from workbench.formats.parts.reading import read_part
from workbench.model.errors import FileError


def import_part(typed: PartImport) -> int:
    """Make the folder of a part and tell what was found."""
    name = name_after(typed.file.name) if typed.name is None else typed.name
    check_name(name)
    check_number("--density", typed.density, *DENSITIES)
    if typed.mass_g is not None:
        check_number("--mass-g", typed.mass_g, LIGHTEST * 1000, HEAVIEST * 1000)
    if (typed.into / name).exists():
        raise FileError(typed.into / name, "is there already; choose another name")
    try:
        made = _make(typed, name)
    except SeveralSolids as error:
        if not typed.json:
            _print_solids(error)
        raise
    if typed.json:
        print_json(_import_form(typed, made))
    else:
        _print_import(typed, made)
    return SUCCESS


def _make(typed: PartImport, name: str) -> MadePart:
    choices = CadChoices(
        typed.unit,
        None if typed.whole else typed.solid or "",
        repair=typed.repair,
        is_open=typed.open,
    )
    with progress("import") as report:
        make_ready(report, ("planning",))
        return make_part(
            typed.file,
            name,
            typed.into,
            choices,
            density=typed.density,
            mass=None if typed.mass_g is None else typed.mass_g / 1000,
            is_symmetric=typed.accept_symmetry,
            report=report,
        )


def _print_solids(several: SeveralSolids) -> None:
    """List the solids of a file, so that somebody can choose."""
    rows = [
        (
            solid.name,
            millimetres(np.ptp(solid.own.points, axis=0) * several.scale),
            millimetres(solid.placed.points.mean(axis=0) * several.scale),
        )
        for solid in several.solids
    ]
    print_table("Solids", ("--solid", "size mm", "middle in the file mm"), rows)


def _import_form(typed: PartImport, made: MadePart) -> dict[str, Any]:
    imported, written, found = made.imported, made.written, made.symmetry
    surface = imported.surface
    return {
        "ok": True,
        "folder": str(written.folder),
        "unit": imported.cad.unit or "as the file says",
        "unit_assumed": imported.cad.is_assumed,
        "size_mm": np.round(surface.size * 1000, 3).tolist(),
        "triangles": surface.triangles,
        "volume_cm3": round(surface.volume * 1e6, 4),
        "components": surface.components,
        "mass_g": round(written.part.mass * 1000, 3),
        "solids": imported.cad.taken,
        "watertight": surface.is_watertight,
        "done": list(imported.done),
        "pieces": count_pieces(written.part),
        "excess_mm": round(made.excess * 1000, 2),
        "symmetry": None if found is None else str(symmetry_words(found)),
        "symmetry_stated": found is not None and typed.accept_symmetry,
    }


def _print_import(typed: PartImport, made: MadePart) -> None:
    imported, found = made.imported, made.symmetry
    surface, cad, part = imported.surface, imported.cad, made.written.part
    assumed = " (assumed: no other gives the size of a part)" if cad.is_assumed else ""
    print(f"{typed.file.name}: read in {cad.unit or 'its own unit'}{assumed}")
    if cad.taken:
        print(cad.taken)
    closed = "watertight" if surface.is_watertight else "open"
    print(
        f"size {millimetres(surface.size)} mm, {surface.volume * 1e6:.4g} cm3, "
        f"{surface.triangles} triangles, {closed}, {format_count(surface.components, 'body')}"
    )
    if is_unusual(imported.mesh):
        print("parts in bins are 5 to 600 mm large: check the unit (--unit)")
    if surface.problems:
        print(f"open: {', '.join(surface.problems)}; use it to find the part, not to grip it")
    for line in imported.done:
        print(f"mended: {line}")
    how = "given" if typed.mass_g is not None else f"at {typed.density:g} kg/m3"
    print(f"mass {part.mass * 1000:.4g} g ({how})")
    print(f"{counted_pieces(part)}. {exactness(made.excess)}")
    if found is not None:
        only = "a comment only: --accept-symmetry states it"
        print(f"symmetry: {symmetry_words(found)} ({'stated' if typed.accept_symmetry else only})")
    print(f"written to {made.written.folder}")
    print(
        f"next: `workbench cell new NAME --urdf FILE --part {part.name}`, or name it in a cell "
        "file's parts"
    )


def list_parts(typed: PartList) -> int:
    """Print name, size and grasps of every part that is found by name."""
    rows: list[dict[str, Any]] = []
    seen: set[str] = set()
    for folder in folders("parts"):
        for place in sorted(folder.iterdir()):
            if place.name in seen or not (place / "part.toml").is_file():
                continue
            seen.add(place.name)
            try:
                part = read_part(place)
            except FileError as error:
                rows.append({"name": place.name, "problem": str(error)})
                continue
            size = np.ptp(part.mesh.points, axis=0)
            rows.append(
                {
                    "name": place.name,
                    "size_mm": np.round(size * 1000, 2).tolist(),
                    "mass_g": round(part.mass * 1000, 3),
                    "grasps": len(part.library.grasps),
                    "folder": str(place),
                }
            )
    if typed.json:
        print_json({"ok": True, "parts": rows})
        return SUCCESS
    print_table(
        "Parts",
        ("part", "size mm", "grasps", "folder"),
        [
            (row["name"], "cannot be read", "", row["problem"])
            if "problem" in row
            else (
                row["name"],
                ", ".join(f"{value:g}" for value in row["size_mm"]),
                str(row["grasps"]),
                row["folder"],
            )
            for row in rows
        ],
    )
    return SUCCESS

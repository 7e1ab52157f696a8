"""A cell that knows many kinds of parts: reading it, and a search for the few that lie there."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

from workbench.formats.cells.reading import cell_path, read_cell
from workbench.formats.files.shipped import find
from workbench.formats.files.whole_files import write_whole
from workbench.formats.meshes.triangles import stl_of, triangles_of
from workbench.formats.parts.reading import read_part
from workbench.perception.parts.part_surface import prepare
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import find_parts
from workbench.studies.scale.growth import Costs, processor_seconds, seconds_and_megabytes

SHAPES = ("bolt", "bracket", "keyed_cylinder", "puck", "spacer")
"""Shipped parts that are copied."""

SMALLEST, LARGER_BY = 0.75, 1.02
"""Of the copies of a shape, over the shape: the first, and each over the one before."""

KINDS_THERE = 4
"""Kinds of which a part lies in the bin: the first ones, one of a shape each."""

SEED = 1


def write_library(folder: Path, cell: str, count: int) -> Path:
    """A copy of a cell that picks `count` kinds of parts.

    Args:
        folder: an empty one, which takes cell and parts.
        cell: name or path of the cell.
        count: kinds of parts.

    Returns:
        The path of the cell's file.
    """
    # Of no other library, whose kinds may be prepared already.
    names = [f"{SHAPES[k % len(SHAPES)]}_{k}_of_{count}" for k in range(count)]
    for k, name in enumerate(names):
        _write_kind(folder / name, SHAPES[k % len(SHAPES)], SMALLEST * LARGER_BY ** (k // 5))
    source = cell_path(cell)
    robot = folder / "robots" / source.parent.name
    shutil.copytree(source.parent, robot)
    path = robot / source.name
    listed = ", ".join(f'"../../{name}"' for name in names)
    text = re.sub(r"(?m)^parts = \[.*\]$", f"parts = [{listed}]", path.read_text("utf-8"))
    write_whole(path, text.encode())
    return path


def _write_kind(folder: Path, shape: str, factor: float) -> None:
    source = find("parts", shape)
    folder.mkdir(parents=True)
    mesh = triangles_of(read_part(source).mesh)
    write_whole(folder / f"{shape}.stl", stl_of(mesh.apply_scale(1000 * factor)))
    text = (source / "part.toml").read_text("utf-8")
    named = text.replace(f'name = "{shape}"', f'name = "{folder.name}"')
    write_whole(folder / "part.toml", named.encode())
    shutil.copy(source / "grasps.toml", folder / "grasps.toml")


def measure_library(path: Path) -> Costs:
    """Processor times [s] of a cell with many kinds, and what a prepared search takes."""
    read = processor_seconds(lambda: read_cell(path))
    cell = read_cell(path)
    prepared, memory = seconds_and_megabytes(lambda: [prepare(part) for part in cell.parts])
    there = replace(cell, parts=cell.parts[:KINDS_THERE])
    scan = synthesize(there, drop_parts(there.parts, cell.bin, seed=SEED), seed=SEED)
    find_parts(scan, there, seed=SEED)
    return {
        "read the cell, s": read,
        "prepare the kinds once, s": prepared,
        "prepare the kinds once, MB of memory": memory,
        "find 4 parts of 4 kinds, s": processor_seconds(lambda: find_parts(scan, cell, seed=SEED)),
    }

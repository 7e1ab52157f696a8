"""Parts that are larger or smaller than their CAD files: by how much, as a scan shows it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from workbench.formats.cells.reading import part_folders
from workbench.formats.parts.scales import change_offset, change_scale
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.scan import LocalizationResult
from workbench.perception.parts.sizing import sized

LEAST_SIZE, LARGEST_SIZE = 0.5, 2.0
"""Of a part over its CAD file."""

ROUNDS = 4
"""Searches at most: poses found with a wrong size tell the right one only nearly."""


def with_sizes(cell: Cell, sizes: Mapping[str, float]) -> Cell:
    """The cell whose parts are this many times as large, by their names."""
    return replace(cell, parts=tuple(sized(part, sizes.get(part.name, 1.0)) for part in cell.parts))


def sizes_of(cell: Cell, typed: Sequence[str]) -> dict[str, float]:
    """The sizes that were typed, each as `PART=SIZE`, by part.

    Raises:
        InputError: something else was typed, or the cell has no such part.
    """
    sizes: dict[str, float] = {}
    names = [part.name for part in cell.parts]
    for override in typed:
        name, _, size = override.partition("=")
        if name not in names:
            raise InputError(
                f"--scale {override}: no part of the cell is {name}; {', '.join(names)}"
            )
        try:
            sizes[name] = float(size)
        except ValueError:
            raise InputError(f"--scale {override}: PART=SIZE is expected, as {name}=0.92") from None
        if not LEAST_SIZE <= sizes[name] <= LARGEST_SIZE:
            raise InputError(
                f"--scale {override}: from {LEAST_SIZE:g} to {LARGEST_SIZE:g} is expected"
            )
    return sizes


def learn_sizes(
    cell: Cell, search: Callable[[Cell], LocalizationResult]
) -> tuple[LocalizationResult, Cell, dict[str, float]]:
    """Search until the parts are as large as the scan shows them.

    Args:
        cell: its parts in the sizes that are known before.
        search: finds the parts of a cell in the scan.

    Returns:
        What the last search found, the cell that it was given, and the size over that before, no
        unit, of each part that has another one.
    """
    sizes: dict[str, float] = {}
    findings = search(cell)
    for _ in range(ROUNDS - 1):
        off = {check.part: check.ratio for check in findings.scales if check.is_off}
        if not off:
            break
        cell = with_sizes(cell, off)
        sizes |= {name: sizes.get(name, 1.0) * ratio for name, ratio in off.items()}
        findings = search(cell)
    return findings, cell, sizes


def store_sizes(
    cell_file: Path, sizes: Mapping[str, float], findings: LocalizationResult
) -> list[str]:
    """Write sizes, and how far surfaces lie off, into the `part.toml` of each part.

    Args:
        cell_file: of the cell.
        sizes: of the cell's parts, over those that are written there, no unit.
        findings: what the scan shows of parts of these sizes.

    Returns:
        A line for each part of the cell.

    Raises:
        FileError: a file cannot be read or written, or a size is no longer allowed.
    """
    folders = part_folders(cell_file)
    lines: list[str] = []
    checks = {check.part: check for check in findings.scales}
    offsets = {check.part: check.offset for check in findings.offsets if check.is_off}
    for name, size in sizes.items():
        if name in offsets:
            offset = change_offset(folders[name], offsets[name])
            lines.append(
                f"{name}: offset_mm = {offset * 1000:g} is written into "
                f"{folders[name] / 'part.toml'}; search, bodies for distances and new grasps use it"
            )
        if size != 1.0:
            scale = change_scale(folders[name], size)
            lines.append(
                f"{name}: scale = {scale:g} is written into {folders[name] / 'part.toml'}; search, "
                "bodies for distances and new grasps use it"
            )
        elif name in offsets:
            continue
        elif name in checks:
            lines.append(
                f"{name}: its size is as written, within {checks[name].deviation * 100:.1f} %"
            )
        else:
            lines.append(f"{name}: this scan does not show its size; three parts have to show it")
    return lines

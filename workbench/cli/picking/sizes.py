"""Parts that are larger or smaller than their CAD files: by how much, as a scan shows it."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from workbench.formats.cells.reading import part_folders
from workbench.formats.parts.scales import write_shape
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.scan import LocalizationResult
from workbench.perception.parts.sizing import offset_of

LEAST_SIZE, LARGEST_SIZE = 0.5, 2.0
"""Of a part over its CAD file."""


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


def store_sizes(
    cell_file: Path, cell: Cell, sizes: Mapping[str, float], findings: LocalizationResult
) -> list[str]:
    """Write sizes, and how far surfaces lie off, into the `part.toml` of each part.

    Args:
        cell_file: of the cell.
        cell: as its file states it.
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
    for name, size in sizes.items():
        part, by = cell.part(name), offset_of(findings, name)
        if size == 1.0 and by == 0.0:
            lines.append(
                f"{name}: its size is as written, within {checks[name].deviation * 100:.1f} %"
                if name in checks
                else f"{name}: this scan does not show its size; three parts have to show it"
            )
            continue
        scale, offset = write_shape(folders[name], part.scale * size, part.offset + by)
        changes = {"scale": (size != 1.0, scale), "offset_mm": (by != 0.0, offset * 1000)}
        lines += [
            f"{name}: {key} = {value:g} is written into {folders[name] / 'part.toml'}; search, "
            "bodies for distances and new grasps use it"
            for key, (is_changed, value) in changes.items()
            if is_changed
        ]
    return lines

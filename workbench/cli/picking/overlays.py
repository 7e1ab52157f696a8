"""What was found in a scan, drawn over it into a file, and parts of other sizes than their CAD."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.formats.files.pictures import write_picture
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.scan import Detection, Scan
from workbench.perception.parts.sizing import sized
from workbench.perception.views.overlay import overlay
from workbench.perception.views.surfaces import triangles_of

LEAST_SIZE, LARGEST_SIZE = 0.5, 2.0
"""Of a part over its CAD file."""


def write_overlay(path: Path, scan: Scan, cell: Cell, found: Sequence[Detection]) -> None:
    """Draw the detections over the scan, each with its number and how sure it is."""
    meshes = {part.name: triangles_of(part.mesh) for part in cell.parts}
    T_scanner_world = scan.T_world_scanner.inverse()
    drawn = overlay(
        scan,
        [
            (meshes[detection.part], (T_scanner_world * detection.T_world_part).homogeneous)
            for detection in found
        ],
    )
    words = [
        ((float(place[0]), float(place[1])), _words(number, detection))
        for number, (detection, place) in enumerate(zip(found, drawn.places, strict=True), start=1)
        if np.isfinite(place).all()
    ]
    write_picture(path, drawn.picture, words)


def _words(number: int, detection: Detection) -> str:
    return (
        f"{number}" if detection.probability is None else f"{number}: {detection.probability:.0%}"
    )


def with_sizes(cell: Cell, typed: Sequence[str]) -> Cell:
    """The cell whose parts have the sizes typed, each as `PART=SIZE`.

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
    return replace(cell, parts=tuple(sized(part, sizes.get(part.name, 1.0)) for part in cell.parts))

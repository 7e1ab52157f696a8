"""What was found in a scan, drawn over it into a file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from workbench.formats.files.pictures import write_picture
from workbench.model.cell import Cell
from workbench.model.scan import Detection, Scan
from workbench.perception.views.overlay import overlay
from workbench.perception.views.surfaces import triangles_of


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

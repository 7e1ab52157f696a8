"""A touch test in a file: a scan of the plate where parts lie, and joints at its balls."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.formats.cells.calibrations import read_joints, read_plate
from workbench.formats.files.toml_documents import numbers, text
from workbench.formats.files.toml_keys import read_toml
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import is_file, write_whole
from workbench.model.calibration import BallPlate
from workbench.model.cell import Arm, Cell
from workbench.model.derived.controller_axes import shown_axes
from workbench.model.geometry import Floats

FORMAT = "workbench-touches/1"

MOST = 30
"""Touches."""


@dataclass(frozen=True, slots=True, eq=False)
class TouchesFile:
    """A scan in a file, in `unit`, and the configurations (n,) [rad] of the touches.

    `seat` [m] is the inner diameter of the tip.
    """

    scan: Path
    unit: str
    plate: BallPlate
    arm: str
    seat: float
    qs: tuple[Floats, ...]


def read_touches(path: Path, cell: Cell) -> TouchesFile:
    """The touches of a file: `format`, `scan`, `arm`, `tip_mm`, `[plate]`, `[[touch]]`.

    Raises:
        FileError: names file, key, value and what was expected.
    """
    table = read_toml(path)
    table.text("format", among=(FORMAT,))
    arm = cell.arm(table.text("arm", among=tuple(arm.name for arm in cell.arms)))
    name, unit = table.text("scan"), table.text("unit", cell.scanner.unit, among=tuple(UNITS))
    if not is_file(path.parent / name):
        raise table.error("scan", f"there is no file {name!r} beside {path.name}")
    seat = table.number("tip_mm", 0.0, low=0, high=400) / 1000
    plate = read_plate(table.table("plate"))
    qs = tuple(read_joints(touch, cell, arm) for touch in table.tables("touch"))
    if len(qs) > MOST:
        raise table.error("touch", f"up to {MOST} touches are expected, {len(qs)} are given")
    table.finish()
    return TouchesFile(path.parent / name, unit, plate, arm.name, seat, qs)


def write_touches(path: Path, cell: Cell, arm: Arm, file: TouchesFile) -> None:
    """Write what `read_touches` reads; the scan lies beside it.

    Raises:
        FileError: it cannot be written.
    """
    lines = [
        "# A scan of the plate, and joints where the tool touches its balls.",
        f'format = "{FORMAT}"',
        f"scan = {text(file.scan.name)}",
        f'unit = "{file.unit}"                # of the scan',
        f'arm = "{arm.name}"',
        f"tip_mm = {file.seat * 1000:.10g}                 # inner diameter of the tip; 0: a point",
        "",
        "[plate]",
        f"ball_mm = {file.plate.radius * 2000:.10g}",
        f"sides_mm = {numbers(np.array(file.plate.sides) * 1000, 4)}",
        *_touch_lines(cell, arm, file.qs),
    ]
    write_whole(path, ("\n".join(lines) + "\n").encode())


def _touch_lines(cell: Cell, arm: Arm, qs: Sequence[Floats]) -> list[str]:
    found: list[str] = []
    for q in qs:
        found += ["", "[[touch]]", f"joints_deg = {numbers(shown_axes(cell, arm, q), 4)}"]
    return found

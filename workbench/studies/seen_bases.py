"""Bases that were placed with errors and are found again in a scan: what is stated and true."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.geometry import Floats, frozen, put
from workbench.model.part import Part
from workbench.model.recipes.joint import PlacingError
from workbench.model.scan import Detection, Obstacle
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.standing.second_look import find_standing
from workbench.planning.placing.assembling import base_errors
from workbench.planning.placing.chance import draw_errors
from workbench.planning.placing.sources import scanner_error
from workbench.plugins.progress import Report, silent

ABOVE = 0.0005
"""[m] A base stands so much above the floor of the bin, to touch nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenAgain:
    """A base as a scan shows it: `error` is stated, `off` (6,) [m, rad] is how far it truly is.

    `off` is what the scanner's calibration does not bring about: from the pose seen, along the
    base's axes.
    """

    error: PlacingError
    off: Floats

    def __post_init__(self) -> None:
        put(self, off=frozen(self.off))


def see_again(
    cell_name: str,
    kind: str,
    believed: Sequence[PlacingError],
    *,
    count: int,
    seed: int,
    report: Report = silent,
) -> list[SeenAgain]:
    """Bases of a kind that stand off in the middle of the bin, and are seen in one scan each.

    Args:
        cell_name: whose scanner sees them.
        kind: of the bases.
        believed: how far they may be off where they were placed; each base has one of these.
        count: of bases; those that the scan does not show are left out.
        seed: of errors and scans.
        report: progress.
    """
    part = read_part(kind)
    cell = replace(read_cell(cell_name), parts=(part,))
    high = ABOVE - float(part.mesh.points[:, 2].min())
    T_believed = cell.bin.T_world_bin * pin.SE3(np.eye(3), np.array([0.0, 0.0, high]))
    turned = draw_errors(scanner_error(cell.scanner), count, (seed, 0))
    found: list[SeenAgain] = []
    for number in range(count):
        report(number / count, kind)
        error = believed[number % len(believed)]
        own = draw_errors(error.covariance, 1, (seed, 1, number))[0]
        placed = error.by_scanner @ turned[number] + own
        seen = _see(cell, part, T_believed, motion_of(placed), (seed + number) % 2**31)
        if seen is not None:
            found.append(replace(seen, error=replace(seen.error, believed=error)))
    return found


def motion_of(error: Floats) -> pin.SE3:
    """What is off by an error (6,) [m, rad], in its own frame."""
    return pin.SE3(pin.exp3(error[3:]), error[:3])


def _see(cell: Cell, part: Part, T_believed: pin.SE3, off: pin.SE3, seed: int) -> SeenAgain | None:
    T_true = T_believed * off
    scan = synthesize(cell, (Detection(part.name, T_true),), seed=seed)
    seen = find_standing(scan, cell, part, T_believed)
    if seen.T_world_part is None:
        return None
    box = Obstacle(T_true, np.ones(3), part.name, T_believed, seen)
    T_off = seen.T_world_part.actInv(T_true)
    is_off = np.concatenate([T_off.translation, pin.log3(T_off.rotation)])
    return SeenAgain(base_errors(cell, (), (box,))[part.name], is_off)

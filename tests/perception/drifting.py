"""Weeks of a simulated cell whose scanner drifts: what its scans show, day after day."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin

from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Scan
from workbench.perception.calibration.drift import DAY
from workbench.perception.calibration.things import (
    PutPart,
    Sighting,
    motion_of,
    put_slopes,
    sight_things,
)
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize

CUP = np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 1.0])
"""What a suction cup on a level face keeps of the error of what it takes."""

PRIOR = np.diag(np.square([0.0005] * 3 + [np.deg2rad(0.05)] * 3))
"""Of a calibration, at the bin's middle."""


@cache
def yumi(fov: float | None = None) -> Cell:
    """The YuMi, with a scanner that sees more of the table if wanted [rad]."""
    cell = read_cell("yumi")
    if fov is None:
        return cell
    return replace(cell, scanner=replace(cell.scanner, field_of_view=fov))


@cache
def piles(cell: Cell, seed: int) -> tuple[tuple[Detection, ...], ...]:
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, 7, 4)
    return tuple(
        pile_of(cell, "keyed_cylinder", int(n), seed=seed + k) for k, n in enumerate(counts)
    )


def seen(cell: Cell, moved, parts, seed: int, T_bin_moved: pin.SE3 | None = None) -> Scan:
    """What a scanner sees that hangs elsewhere than the cell says, with the pose of the cell.

    `moved` (6,) [m, rad] is by how much, at the bin's middle; the bin stands elsewhere, too, by
    `T_bin_moved` in its own frame.
    """
    T = motion_of(moved, cell.bin.T_world_bin.translation) * cell.scanner.T_world_scanner
    true = replace(cell, scanner=replace(cell.scanner, T_world_scanner=T))
    if T_bin_moved is not None:
        here = cell.bin.T_world_bin * T_bin_moved
        true = replace(true, bin=replace(cell.bin, T_world_bin=here))
        carried = here * cell.bin.T_world_bin.inverse()
        parts = [replace(one, T_world_part=carried * one.T_world_part) for one in parts]
    scan = synthesize(true, parts, seed=seed)
    return replace(scan, T_world_scanner=cell.scanner.T_world_scanner)


def weeks(
    seed: int, drift, *, days: int = 14, scans: int = 2, jitter: float = 0.0, bin_moves=None
) -> list[Sighting]:
    """What `days` days show as the scanner drifts evenly by `drift` (6,) [m, rad].

    The bin is put back every morning to `jitter` [m] along each level axis, and 0.3 of that in
    radians per 100 mm; from half of the time on it stands elsewhere by `bin_moves`.
    """
    cell, rng = yumi(), np.random.default_rng(seed)
    found = []
    for day in range(days):
        moved = np.asarray(drift) * day / (days - 1)
        off = rng.normal(0, 1, 3) * [jitter, jitter, 3 * jitter]
        T = pose_from_rpy((*off[:2], 0), (0, 0, off[2]))
        if bin_moves is not None and 2 * day >= days:
            T = T * bin_moves
        for _ in range(scans):
            pile = piles(cell, seed)[rng.integers(4)]
            scan = seen(cell, moved, pile, int(rng.integers(1 << 30)), T)
            found += sight_things(cell, scan, at=(day + 0.5) * DAY)
    return found

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
    ThingSighting,
    motion_of,
    put_slopes,
    sight_things,
)
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize

NOT = np.zeros(6)
"""Moved by nothing."""

CUP = np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 1.0])
"""What a suction cup on a level face keeps of the error of what it takes."""

PRIOR = np.diag(np.square([0.0005] * 3 + [np.deg2rad(0.05)] * 3))
"""Of a calibration, at the bin's middle."""


@cache
def yumi(fov: float | None = None) -> Cell:
    """The YuMi, with a scanner of few pixels, that sees more of the table if wanted [rad]."""
    cell = read_cell("yumi")
    mount = replace(cell.scanner, resolution=(320, 240))
    return replace(cell, scanner=mount if fov is None else replace(mount, field_of_view=fov))


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
    `T_bin_moved` in its own frame, and with it the first of both lists of `parts`.
    """
    inside, beside = parts
    T = motion_of(moved, cell.bin.T_world_bin.translation) * cell.scanner.T_world_scanner
    true = replace(cell, scanner=replace(cell.scanner, T_world_scanner=T))
    if T_bin_moved is not None:
        here = cell.bin.T_world_bin * T_bin_moved
        true = replace(true, bin=replace(cell.bin, T_world_bin=here))
        carried = here * cell.bin.T_world_bin.inverse()
        inside = [replace(one, T_world_part=carried * one.T_world_part) for one in inside]
    scan = synthesize(true, [*inside, *beside], seed=seed)
    return replace(scan, T_world_scanner=cell.scanner.T_world_scanner)


def weeks(
    cell: Cell,
    seed: int,
    drift,
    *,
    start=NOT,
    days: int = 15,
    jitter: float = 0.0,
    bin_moves: pin.SE3 | None = None,
    has_parts: bool = False,
) -> list[ThingSighting]:
    """What one scan a day shows as the scanner drifts in the middle third of so many `days`.

    It hangs off by `start` (6,) [m, rad] from the first day on, and by `drift` (6,) more at last.
    The bin is put back every morning to `jitter` [m] along each level axis, and 3 times that in
    radians per metre; from half of the time on it stands elsewhere by `bin_moves`.  With parts the
    robot lays one onto the table every day.
    """
    rng, found = np.random.default_rng(seed), list[ThingSighting]()
    for day in range(days):
        moved = start + np.asarray(drift) * np.clip((3 * day / days - 0.8), 0, 1)
        off = rng.normal(0, 1, 3) * [jitter, jitter, 3 * jitter]
        T = pose_from_rpy((*off[:2], 0), (0, 0, off[2]))
        if bin_moves is not None and 2 * day >= days:
            T = T * bin_moves
        pile = list(piles(cell, seed)[rng.integers(4)])
        laid = put_parts(cell, 100 * seed + day, moved, 1, slip=3e-4) if has_parts else []
        lies = [Detection(one.detection.part, there) for one, there in laid]
        scan = seen(cell, moved, (pile, lies), int(rng.integers(1 << 30)), T)
        found += sight_things(cell, scan, [one for one, _ in laid], at=(day + 0.5) * DAY)
    return found


def put_parts(
    cell: Cell, seed: int, moved, count: int, *, slip: float = 0.0, is_turned: bool = True
) -> list[tuple[PutPart, pin.SE3]]:
    """Parts that the robot takes from the bin and lays onto the table, and where they truly lie.

    The robot knows of them what a scanner says that hangs elsewhere by `moved` (6,) [m, rad].  A
    cup holds them; they lie down level on the table.  Each is off by `slip` [m] then, and by as
    many radians per 100 mm.
    """
    rng, middle = np.random.default_rng(seed), cell.bin.T_world_bin.translation
    lying = piles(cell, 0)[seed % 4][0]
    on_floor = lying.T_world_part.translation[2] - middle[2]
    found = []
    for number in range(count):
        x, y, yaw, turn = rng.uniform((-0.05, -0.1, -np.pi, -np.pi), (0.05, 0.1, np.pi, np.pi))
        T_true = pose_from_rpy((*(middle[:2] + [x, y]), middle[2] + on_floor), (0, 0, yaw))
        T_true = T_true * pin.SE3(lying.T_world_part.rotation, np.zeros(3))
        T_seen = motion_of(moved, middle).inverse() * T_true
        side = 0.24 if number % 2 else -0.24
        there = (middle[0] + rng.uniform(-0.12, 0.12), side, -0.01 + on_floor)
        turned = pin.exp3(np.array([0.0, 0.0, turn if is_turned else 0.0])) @ T_true.rotation
        level = pin.SE3(turned, np.array(there))  # where it shall lie, level as it lay
        T_raw = level * T_seen.inverse() * T_true
        wrong = T_raw * level.inverse()
        by = rng.normal(0, slip, 3)
        about = pin.rpy.matrixToRpy(wrong.rotation)[2] + 10 * by[2]
        shift = T_raw.translation[:2] - level.translation[:2] + by[:2]
        T_lies = pin.SE3(
            pin.exp3(np.array([0, 0, about])) @ level.rotation, level.translation + [*shift, 0.0]
        )
        slopes = put_slopes(middle, T_seen, level, CUP)
        found.append((PutPart(Detection("keyed_cylinder", level), slopes), T_lies))
    return found

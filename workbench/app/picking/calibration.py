"""From scans of a held plate to the scanner's true pose in the cell."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.calibration import BallPlate, Calibration, PlateSighting
from workbench.model.cell import Arm, Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.scan import Scan
from workbench.perception.calibration.calibrate import PlatePose, calibrate
from workbench.perception.simulation.held_plate import held_pose, is_plate_in_sight, scan_held_plate
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.viewpoints import poses_in_view

SPARE = 3
"""Times as many poses are looked for as are wanted: the arm itself hides the plate in some."""


def calibrated(cell: Cell, sightings: Sequence[PlateSighting]) -> Calibration:
    """Where the scanner is, by the robot's kinematics and what was seen of the plate.

    Raises:
        InputError: the sightings do not belong together, are too few, too similar or at odds.
    """
    if not sightings:
        raise InputError("no pose was scanned yet; a calibration needs 4, 8 are better")
    first = sightings[0]
    for one in sightings:
        sides = np.asarray(one.plate.sides)
        if one.arm != first.arm or not np.array_equal(sides, first.plate.sides):
            raise InputError(
                f"{one.name} is of another plate or arm than {first.name}; remove one of them"
            )
    kinematics, arm = Kinematics(cell), cell.arm(first.arm)
    poses = [
        PlatePose(one.name, flange_pose(kinematics, arm, one.q), one.balls, one.is_used)
        for one in sightings
    ]
    return calibrate(poses, first.plate.centres)


def flange_pose(kinematics: Kinematics, arm: Arm, q: Floats) -> pin.SE3:
    """`T_world_flange` of an arm at `q` (n,) [rad]."""
    return kinematics.tcp_pose(arm, q) * arm.tool.T_flange_tcp.inverse()


def with_calibration(cell: Cell, calibration: Calibration, at: float, by: str) -> Cell:
    """The cell with its scanner where the calibration says; `at` [s since the epoch], `by` whom."""
    record = calibration.record(at, by)
    mount = replace(cell.scanner, T_world_scanner=calibration.T_world_scanner, calibration=record)
    return replace(cell, scanner=mount)


def moved_by(cell: Cell, calibration: Calibration) -> tuple[float, float, float]:
    """By how much the scanner is elsewhere than the cell says.

    Returns:
        Distance [m] and angle [rad] of the scanner, and how far a point in the middle of the bin
        is moved by it [m], which is what matters to a grasp.
    """
    before, after = cell.scanner.T_world_scanner, calibration.T_world_scanner
    between = before.actInv(after)
    middle = cell.bin.T_world_bin.translation
    shift = after.act(before.inverse().act(middle)) - middle
    return (
        float(np.linalg.norm(between.translation)),
        float(np.linalg.norm(pin.log3(between.rotation))),
        float(np.linalg.norm(shift)),
    )


def simulated_sight(
    cell: Cell,
    arm: Arm,
    q: Floats,
    plate: BallPlate,
    *,
    seed: int,
    T_world_scanner: pin.SE3 | None = None,
) -> Scan:
    """What the simulated scanner sees of an arm at `q` (n,) [rad] that holds the plate."""
    links = Kinematics(cell).link_poses(dict(zip(arm.joints, map(float, q), strict=True)))
    return scan_held_plate(cell, links, arm.name, plate, seed=seed, T_world_scanner=T_world_scanner)


def suggested_poses(
    cell: Cell, arm: Arm, plate: BallPlate, count: int, *, seed: int
) -> tuple[Floats, ...]:
    """Configurations (n,) [rad] in which the scanner sees the plate, held beside the tool.

    They are clear of everything by the policy's margin and differ in how the wrist is turned.
    """
    T_tcp_middle = held_pose(plate) * pin.SE3(np.eye(3), plate.centres.mean(axis=0))
    kinematics, seen = Kinematics(cell), list[Floats]()
    for q in poses_in_view(cell, arm, T_tcp_middle, SPARE * count, seed=seed):
        links = kinematics.link_poses(dict(zip(arm.joints, map(float, q), strict=True)))
        if is_plate_in_sight(cell, links, arm.name, plate):
            seen.append(q)
        if len(seen) == count:
            break
    return tuple(seen)

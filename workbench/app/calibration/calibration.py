"""From scans of a plate to the scanner's true pose in the cell.

An arm holds the plate before a scanner that stands, or carries the scanner before a plate that
stands.  The second is solved as the first: as if the scanner stood at its view, and a flange moved
the plate.  With `F` = `T_world_flange` and `V` the same at the view, `F * T_flange_scanner * p =
T_world_plate * c` becomes `(V * T_flange_scanner) * p = (V * F^-1 * V) * (V^-1 * T_world_plate) *
c`.
"""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from workbench.model.calibration import Calibration, PlateObservation
from workbench.model.cell import IN_WORLD, Arm, Bin, Cell
from workbench.model.derived.scanner_poses import flange_at_view, with_calibrated_scanner
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, shift_and_turn
from workbench.model.messages.calibration import PlateText
from workbench.model.messages.cells import CellText
from workbench.perception.calibration.calibrate import PlatePose, calibrate
from workbench.perception.calibration.sureness import point_errors
from workbench.planning.kinematics.robot import Kinematics


def compute_calibration(cell: Cell, observations: Sequence[PlateObservation]) -> Calibration:
    """Where the scanner is, by the robot's kinematics and what was seen of the plate.

    Raises:
        InputError: the observations do not belong together, are too few, too similar or at odds.
    """
    check_in_own_frame(cell)
    if not observations:
        raise InputError(PlateText.NO_POSE())
    first, carrier = observations[0], cell.scanner.on_arm
    if carrier is not None and first.arm != carrier.arm:
        wrong = PlateText.OTHER_CARRIER(pose=first.name, arm=first.arm, carrier=carrier.arm)
        raise InputError(wrong)
    for observation in observations:
        sides = np.asarray(observation.plate.sides)
        if observation.arm != first.arm or not np.array_equal(sides, first.plate.sides):
            raise InputError(PlateText.OTHER_PLATE(pose=observation.name, first=first.name))
    return calibrate(poses_of(cell, observations), first.plate.centres)


def check_in_own_frame(cell: Cell) -> None:
    """The scanner's points are in a frame of its own, so there is something to calibrate.

    Raises:
        InputError: they are in the frame of the cell.
    """
    if cell.scanner.cloud_axes == IN_WORLD:
        raise InputError(PlateText.IN_WORLD())


def check_stands(cell: Cell) -> None:
    """The scanner stands.

    Raises:
        InputError: an arm carries it.
    """
    if (carrier := cell.scanner.on_arm) is not None:
        raise InputError(CellText.SCANNER_HANGS(cell=cell.name, arm=carrier.arm))


def poses_of(cell: Cell, observations: Sequence[PlateObservation]) -> list[PlatePose]:
    """The same with the flange where the robot's joints say it is; all of one arm."""
    kinematics, carrier = Kinematics(cell), cell.scanner.on_arm
    return [
        PlatePose(
            observation.name,
            plate_flange(cell, kinematics, cell.arm(observation.arm), observation.q),
            observation.balls,
            observation.is_used,
            None if carrier is None else flange_at_view(cell.scanner).translation,
        )
        for observation in observations
    ]


def plate_flange(cell: Cell, kinematics: Kinematics, arm: Arm, q: Floats) -> pin.SE3:
    """`T_world_flange` of the flange that moves the plate, while an arm stands at `q` (n,) [rad].

    It is the arm's; where that carries the scanner, the one that would move the plate alike before
    the scanner at its view.
    """
    T_world_flange = kinematics.tcp_pose(arm, q) * arm.tool.T_flange_tcp.inverse()
    if cell.scanner.on_arm is None:
        return T_world_flange
    return plate_mover(T_world_flange, flange_at_view(cell.scanner))


def plate_mover(T_world_flange: pin.SE3, T_world_view: pin.SE3) -> pin.SE3:
    """The flange that moves the plate as one that carries the scanner moves before the plate.

    Args:
        T_world_flange: of the arm that carries the scanner.
        T_world_view: the same at the view, where both are alike.
    """
    return T_world_view * T_world_flange.inverse() * T_world_view


def plate_pose(
    cell: Cell, kinematics: Kinematics, arm: Arm, q: Floats, T_flange_plate: pin.SE3
) -> pin.SE3:
    """`T_world_plate` while an arm stands at `q` (n,) [rad].

    Args:
        cell: with its scanner: where an arm carries that, the plate stands.
        kinematics: of the cell.
        arm: that moves the plate or the scanner.
        q: see there.
        T_flange_plate: of the arm at `q`, or at the view where it carries the scanner.
    """
    if cell.scanner.on_arm is not None:
        return flange_at_view(cell.scanner) * T_flange_plate
    return plate_flange(cell, kinematics, arm, q) * T_flange_plate


def with_calibration(cell: Cell, calibration: Calibration, at: float, by: str) -> Cell:
    """The cell with its scanner where the calibration says; `at` [s since the epoch], `by` whom."""
    record = calibration.record(at, by)
    return with_calibrated_scanner(cell, calibration.T_world_scanner, record)


def corner_errors(
    cell: Cell, covariance: Floats, T_world_scanner: pin.SE3 | None = None
) -> dict[str, float]:
    """How far off what lies at the bin's corners is seen by the calibration alone, [m].

    In 95 % of calibrations a point there is no further off.  Robot, search and grip come on top.

    Args:
        cell: with the bin.
        covariance: (6, 6) [m, rad] of the scanner's pose, as `Calibration` has it.
        T_world_scanner: where the scanner is; where the cell has it when not given.

    Returns:
        By the corner's name, those of the floor first.
    """
    T = cell.scanner.T_world_scanner if T_world_scanner is None else T_world_scanner
    corners = bin_corners(cell.bin)
    errors = point_errors(covariance, T.translation, np.array(list(corners.values())))
    return dict(zip(corners, errors.tolist(), strict=True))


def bin_corners(box: Bin) -> dict[str, Floats]:
    """The corners of the bin's inside (3,) [m] in the world, floor first, by names of its walls."""
    length, width, height = box.size
    return {
        f"{level} {along} {across}": box.T_world_bin.act(np.array([x, y, z]))
        for level, z in (("floor", 0.0), ("rim", height))
        for along, x in (("front", length / 2), ("back", -length / 2))
        for across, y in (("left", width / 2), ("right", -width / 2))
    }


def moved_by(cell: Cell, calibration: Calibration) -> tuple[float, float, float]:
    """By how much the scanner is elsewhere than the cell says.

    Returns:
        Distance [m] and angle [rad] of the scanner, and how far a point in the middle of the bin
        is moved by it [m]: that matters to a grasp.
    """
    before, after = cell.scanner.T_world_scanner, calibration.T_world_scanner
    middle = cell.bin.T_world_bin.translation
    shift = after.act(before.inverse().act(middle)) - middle
    return (*shift_and_turn(before.actInv(after)), float(np.linalg.norm(shift)))

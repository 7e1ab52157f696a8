"""Which pose of plate or scanner to take next, and how a person gets there from the last one."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from workbench.app.calibration.ball_plate import suggested_poses
from workbench.app.calibration.calibration import bin_corners, plate_flange, plate_pose, poses_of
from workbench.model.calibration import Calibration, NextPose, PlateObservation
from workbench.model.cell import Cell
from workbench.model.derived.scanner_poses import scanner_pose, with_scanner_at
from workbench.model.geometry import Floats
from workbench.model.messages.calibration import PoseText
from workbench.model.messages.message import Message
from workbench.perception.calibration.next_pose import errors_with
from workbench.planning.kinematics.robot import Kinematics

POSES_TRIED = 10
"""Poses among which the best is searched for."""

LEAST_MOTION = (0.01, np.deg2rad(2.0))
"""[m, rad] Motions that are smaller than this are not reported."""

SIDE_NAMES = (
    PoseText.FRONT,
    PoseText.FRONT_LEFT,
    PoseText.LEFT,
    PoseText.BACK_LEFT,
    PoseText.BACK,
    PoseText.BACK_RIGHT,
    PoseText.RIGHT,
    PoseText.FRONT_RIGHT,
)
"""Of the bin, as seen from its middle, counterclockwise from x."""


def next_poses(
    cell: Cell, observations: Sequence[PlateObservation], found: Calibration, *, seed: int
) -> tuple[NextPose, ...]:
    """Poses of plate or scanner that would tell more, those first that would tell most.

    Args:
        cell: robot, bin, scanner.
        observations: as the calibration was made of them.
        found: the calibration: it says where scanner and plate are.
        seed: of the poses that are tried.

    Returns:
        Nothing where the arm reaches no pose in which the plate is seen.
    """
    last = observations[-1]
    arm, plate = cell.arm(last.arm), last.plate
    calibrated = with_scanner_at(cell, found.T_world_scanner)
    qs = suggested_poses(
        calibrated,
        arm,
        plate,
        POSES_TRIED,
        seed=seed,
        T_flange_plate=found.T_flange_plate,
        aside=float(cell.bin.size[:2].min()) / 2,
    )
    if not qs:
        return ()
    kinematics = Kinematics(cell)
    left_out = {residual.name for residual in found.residuals if residual.left_out}
    Ts = [plate_flange(cell, kinematics, arm, q) for q in qs]
    error, errors = errors_with(
        [pose for pose in poses_of(cell, observations) if pose.name not in left_out],
        (found.T_world_scanner, found.T_flange_plate),
        plate.centres,
        Ts,
        np.array(list(bin_corners(cell.bin).values())),
    )
    to_bin, middle = cell.bin.T_world_bin.inverse(), pin.SE3(np.eye(3), plate.centres.mean(axis=0))

    def moved_pose(q: Floats) -> pin.SE3:
        if cell.scanner.on_arm is not None:
            return to_bin * scanner_pose(calibrated, q)
        return to_bin * plate_pose(cell, kinematics, arm, q, found.T_flange_plate) * middle

    thing = PoseText.PLATE() if cell.scanner.on_arm is None else PoseText.SCANNER()
    before = moved_pose(last.q)
    return tuple(
        NextPose(
            qs[k],
            error,
            float(errors[k]),
            last.name,
            steps_to(before, moved_pose(qs[k]), thing),
        )
        for k in np.argsort(errors, kind="stable")
    )


def steps_to(T_bin_from: pin.SE3, T_bin_to: pin.SE3, thing: Message) -> tuple[Message, ...]:
    """How plate or scanner gets from one pose to another, for a person who looks at the bin.

    First a turn about the vertical, then a tip, then a shift, by the names of the bin's walls.
    """
    rotation = (T_bin_to * T_bin_from.inverse()).rotation
    # The turn about the vertical that leaves a tip about a level axis (swing and twist).
    z, w = pin.Quaternion(rotation).coeffs()[2:]
    yaw = 2 * np.arctan2(z, w) if np.hypot(z, w) > 1e-9 else 0.0
    yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
    tip = pin.log3(rotation @ pin.exp3(np.array([0.0, 0.0, -yaw])))
    said: list[Message] = []
    if yaw >= LEAST_MOTION[1]:
        said.append(PoseText.TURN_LEFT(thing=thing, angle=float(yaw)))
    elif yaw <= -LEAST_MOTION[1]:
        said.append(PoseText.TURN_RIGHT(thing=thing, angle=-float(yaw)))
    angle = float(np.linalg.norm(tip))
    if angle >= LEAST_MOTION[1]:
        # What is above the axis goes along it times the vertical.
        towards = _side(np.array([tip[1], -tip[0]]))
        said.append(PoseText.TIP(angle=angle, side=towards))
    shift = T_bin_to.translation - T_bin_from.translation
    level = float(np.linalg.norm(shift[:2]))
    if level >= LEAST_MOTION[0]:
        said.append(PoseText.MOVE(far=level, side=_side(shift[:2])))
    height = float(abs(shift[2]))
    if shift[2] >= LEAST_MOTION[0]:
        said.append(PoseText.RAISE(far=height))
    elif shift[2] <= -LEAST_MOTION[0]:
        said.append(PoseText.LOWER(far=height))
    return tuple(said)


def _side(direction: Floats) -> Message:
    """Where a level direction (2,) of the bin's frame points, by eighths of a turn."""
    return SIDE_NAMES[round(float(np.arctan2(direction[1], direction[0])) / (np.pi / 4)) % 8]()

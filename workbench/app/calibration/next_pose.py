"""Which pose of the plate to take next, and how a person gets there from the last one."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.app.calibration.calibration import bin_corners, flange_pose, poses_of
from workbench.app.calibration.held_plate import suggested_poses
from workbench.model.calibration import Calibration, NextPose, PlateObservation
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.messages.calibration import PoseText
from workbench.model.messages.message import Message
from workbench.perception.calibration.next_pose import errors_with
from workbench.planning.kinematics.robot import Kinematics

TRIED = 10
"""Poses among which the best is searched for."""

LEAST = (0.01, np.deg2rad(2.0))
"""[m, rad] Motions that are smaller than this are not reported."""

SIDES = (
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
    """Poses of the plate that would tell more, those first that would tell most.

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
    mount = replace(cell.scanner, T_world_scanner=found.T_world_scanner)
    qs = suggested_poses(
        replace(cell, scanner=mount),
        arm,
        plate,
        TRIED,
        seed=seed,
        T_tcp_plate=arm.tool.T_flange_tcp.inverse() * found.T_flange_plate,
        aside=float(cell.bin.size[:2].min()) / 2,
    )
    if not qs:
        return ()
    kinematics = Kinematics(cell)
    left_out = {residual.name for residual in found.residuals if residual.left_out}
    Ts = [flange_pose(kinematics, arm, q) for q in qs]
    error, errors = errors_with(
        [pose for pose in poses_of(cell, observations) if pose.name not in left_out],
        (found.T_world_scanner, found.T_flange_plate),
        plate.centres,
        Ts,
        np.array(list(bin_corners(cell.bin).values())),
    )
    held = found.T_flange_plate * pin.SE3(np.eye(3), plate.centres.mean(axis=0))
    to_bin = cell.bin.T_world_bin.inverse()
    before = to_bin * flange_pose(kinematics, arm, last.q) * held
    return tuple(
        NextPose(qs[k], error, float(errors[k]), last.name, steps_to(before, to_bin * Ts[k] * held))
        for k in np.argsort(errors, kind="stable")
    )


def steps_to(T_bin_from: pin.SE3, T_bin_to: pin.SE3) -> tuple[Message, ...]:
    """How the plate gets from one pose to another, for a person who looks at the bin.

    First a turn about the vertical, then a tip, then a shift, by the names of the bin's walls.
    """
    rotation = (T_bin_to * T_bin_from.inverse()).rotation
    # The turn about the vertical that leaves a tip about a level axis (swing and twist).
    z, w = pin.Quaternion(rotation).coeffs()[2:]
    yaw = 2 * np.arctan2(z, w) if np.hypot(z, w) > 1e-9 else 0.0
    yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
    tip = pin.log3(rotation @ pin.exp3(np.array([0.0, 0.0, -yaw])))
    said: list[Message] = []
    if yaw >= LEAST[1]:
        said.append(PoseText.TURN_LEFT(angle=float(yaw)))
    elif yaw <= -LEAST[1]:
        said.append(PoseText.TURN_RIGHT(angle=-float(yaw)))
    angle = float(np.linalg.norm(tip))
    if angle >= LEAST[1]:
        # What is above the axis goes along it times the vertical.
        towards = _side(np.array([tip[1], -tip[0]]))
        said.append(PoseText.TIP(angle=angle, side=towards))
    shift = T_bin_to.translation - T_bin_from.translation
    level = float(np.linalg.norm(shift[:2]))
    if level >= LEAST[0]:
        said.append(PoseText.MOVE(far=level, side=_side(shift[:2])))
    height = float(abs(shift[2]))
    if shift[2] >= LEAST[0]:
        said.append(PoseText.RAISE(far=height))
    elif shift[2] <= -LEAST[0]:
        said.append(PoseText.LOWER(far=height))
    return tuple(said)


def _side(direction: Floats) -> Message:
    """Where a level direction (2,) of the bin's frame points, by eighths of a turn."""
    return SIDES[round(float(np.arctan2(direction[1], direction[0])) / (np.pi / 4)) % 8]()

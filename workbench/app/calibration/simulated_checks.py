"""Simulated checks of a scanner: an artefact of balls in the bin, and a tool that touches them."""

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from workbench.model.calibration import BallArtefact
from workbench.model.cell import Arm, Cell
from workbench.model.derived.scanner_poses import scanner_pose
from workbench.model.derived.touches import reach_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.calibration import VerifyText
from workbench.model.scan import Scan
from workbench.perception.simulation.ball_plate import ball_solids, cell_scene, scan_scene
from workbench.perception.views.surfaces import add_solids
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.viewpoints import TILT, sample_configurations

FREE = 0.03
"""[m] Between the balls and the walls of the bin."""

PLACES = 200
"""Places that are drawn until the balls lie inside the bin."""


def simulated_place(cell: Cell, artefact: BallArtefact, seed: int) -> pin.SE3:
    """`T_world_artefact` of the simulation: level, between floor and rim of the bin.

    Raises:
        InputError: the artefact is too long for the bin.
    """
    rng, length = np.random.default_rng(seed), cell.bin.size
    middle = artefact.centres.mean(axis=0)
    room = length[:2] / 2 - artefact.radius - FREE
    for _ in range(PLACES):
        height = rng.uniform(artefact.radius, length[2])
        turn = pin.rpy.rpyToMatrix(0.0, 0.0, rng.uniform(-np.pi, np.pi))
        place = np.array([*rng.uniform(-1, 1, 2) * np.maximum(room, 0.0), height])
        balls = (artefact.centres - middle) @ turn.T + place
        if np.all(np.abs(balls[:, :2]) <= room):
            return cell.bin.T_world_bin * pin.SE3(turn, place - turn @ middle)
    raise InputError(VerifyText.TOO_LONG())


def simulated_balls(
    cell: Cell,
    artefact: BallArtefact,
    *,
    seed: int,
    joints: Mapping[str, float] | None = None,
    T_world_scanner: pin.SE3 | None = None,
) -> Scan:
    """What the simulated scanner sees of an artefact in the bin.

    Args:
        cell: with bin and scanner.
        artefact: the balls.
        seed: of its place, and of the noise.
        joints: name -> [rad, m] of the robot; None: at home.
        T_world_scanner: where the scanner truly is; None: as the cell has it.
    """
    scene = cell_scene(cell, Kinematics(cell).link_poses(joints or {}))
    balls = ball_solids(artefact.centres, artefact.radius)
    add_solids(scene, balls, simulated_place(cell, artefact, seed))
    carrier, T = cell.scanner.on_arm, T_world_scanner
    if T is None:
        q = () if carrier is None or not joints else [joints[name] for name in carrier.joints]
        T = scanner_pose(cell, np.array(q)) if len(q) else cell.scanner.T_world_scanner
    return scan_scene(cell, scene, seed=seed, T_world_scanner=T)


def touching_joints(
    cell: Cell, arm: Arm, ball: Floats, radius: float, seat: float, *, seed: int
) -> Floats:
    """A configuration (n,) [rad] in which the tool of an arm touches a ball at (3,) [m].

    Raises:
        InputError: the arm does not reach it with the tool up to 30 degrees from straight down.
    """

    def draw(rng: np.random.Generator) -> pin.SE3:
        lean, yaw, tilt = rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi), rng.uniform(TILT)
        axis = tilt * np.array([np.cos(lean), np.sin(lean), 0.0])
        R = pin.exp3(axis) @ pin.rpy.rpyToMatrix(np.pi, 0.0, yaw)
        return pin.SE3(R, ball - R[:, 2] * reach_of(seat, radius))

    found = sample_configurations(cell, arm, draw, 1, seed=seed)
    if not found:
        raise InputError(VerifyText.NOT_REACHED(arm=arm.name))
    return found[0]

"""A ball that a tool tip touches: where the robot has its centre, and where the scanner has it."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.calibration import BallScan, Touch
from workbench.model.cell import Arm, Cell
from workbench.model.derived.scanner_poses import scanner_pose
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, transform
from workbench.model.messages.calibration import VerifyText
from workbench.model.messages.message import Message

NO_TCP = 1e-6
"""[m] A TCP nearer to the flange is that of no tool."""

FAR = 0.03
"""[m] A touched ball is nearer to where the scanner has it."""


@dataclass(frozen=True, slots=True, eq=False)
class TouchedBall:
    """The ball of a scan, from 1, whose centre (3,) [m] lies nearest to that at the tip.

    `tip` is the centre by the robot's joints, `seen` by the scanner, both in the world; `turn`
    (3, 3) is the rotation of the tool.
    """

    ball: int
    tip: Floats
    seen: Floats
    turn: Floats

    @property
    def offset(self) -> Floats:
        """From where the robot has the centre to where the scanner has it (3,) [m]."""
        return self.seen - self.tip


def tool_pose(cell: Cell, arm: Arm, q: Floats) -> pin.SE3:
    """`T_world_tcp` of an arm at `q` (n,) [rad], chain order."""
    values = dict(zip(arm.joints, map(float, np.asarray(q)), strict=True))
    links = cell.robot.link_poses(values)
    return cell.T_world_robot * links[arm.flange] * arm.tool.T_flange_tcp


def reach_of(seat: float, radius: float) -> float:
    """How far [m] a ball's centre lies before the TCP: `Touch.seat` and the radius [m]."""
    return float(np.sqrt(max(radius**2 - seat**2 / 4, 0.0)))


def seen_balls(cell: Cell, scan: BallScan) -> Floats:
    """The centres (k, 3) [m] in the world, by the scanner's pose in the cell.

    Raises:
        InputError: the scan is of another scanner: one on an arm, or one that stands.
    """
    carrier = cell.scanner.on_arm
    if len(scan.q) != (0 if carrier is None else len(carrier.joints)):
        raise InputError(VerifyText.OTHER_CELL(name=scan.name))
    T = scanner_pose(cell, scan.q)
    return transform(T, scan.balls)


def touched_ball(cell: Cell, scan: BallScan, touch: Touch) -> TouchedBall:
    """The ball that a touch means.

    Raises:
        InputError: scan or touch are of another cell.
    """
    arm = cell.arm(touch.arm)
    if len(touch.q) != len(arm.joints):
        raise InputError(VerifyText.OTHER_CELL(name=touch.name))
    T = tool_pose(cell, arm, touch.q)
    tip = T.act(np.array([0.0, 0.0, reach_of(touch.seat, scan.artefact.radius)]))
    seen = seen_balls(cell, scan)
    ball = int(np.linalg.norm(seen - tip, axis=1).argmin())
    return TouchedBall(ball + 1, tip, seen[ball], T.rotation)


def touch_problem(cell: Cell, scan: BallScan, touch: Touch) -> Message | None:
    """Why a touch of a known arm, at joints within its limits, says nothing; None when it does."""
    if np.linalg.norm(cell.arm(touch.arm).tool.T_flange_tcp.translation) < NO_TCP:
        return VerifyText.NO_TCP(arm=touch.arm)
    ball = 2 * scan.artefact.radius
    if not 0 <= touch.seat < ball:
        return VerifyText.SEAT(ball=f"{ball * 1000:g}")
    try:
        touched = touched_ball(cell, scan, touch)
    except InputError as error:
        return error.message
    away = float(np.linalg.norm(touched.offset))
    if away > FAR:
        return VerifyText.FAR_TOUCH(away=away, ball=touched.ball, scan=scan.name)
    return None

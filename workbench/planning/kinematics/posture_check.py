"""Why a pendant shows another pose than the cell has for the same joints: base, tool, a joint."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm
from workbench.model.geometry import Floats, shift_and_turn
from workbench.planning.kinematics.robot import Kinematics

CauseKind = Literal["none", "joint", "base", "tool"]
Frame = Literal["flange", "tcp"]

SAME_POSE = (0.001, float(np.deg2rad(0.2)))
"""[m, rad] Poses nearer than this are one: pendants show few digits, and robots differ a little."""


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """One thing that explains a difference alone.

    `frame` is what the pendant shows then.  Of a `joint` it is the `name` and by how much its zero
    is off, `offset` [rad, m].  Of the `base`, `T` is the cell's base in that of the pendant; of
    the `tool`, the pendant's TCP in the flange.
    """

    kind: CauseKind
    frame: Frame
    name: str = ""
    offset: float = 0.0
    T: pin.SE3 | None = None


def base_poses(kinematics: Kinematics, arm: Arm, q: Floats) -> dict[Frame, pin.SE3]:
    """Flange and TCP of an arm at `q` (n,) [rad, m] in the robot's base."""
    T_base_world = kinematics.cell.T_world_robot.inverse()
    T_base_tcp = T_base_world * kinematics.tcp_pose(arm, q)
    return {"flange": T_base_tcp * arm.tool.T_flange_tcp.inverse(), "tcp": T_base_tcp}


def causes_of(kinematics: Kinematics, arm: Arm, q: Floats, T_shown: pin.SE3) -> tuple[Cause, ...]:
    """What would explain that the pendant shows a pose, the likeliest first.

    One posture cannot distinguish a base from a tool, nor a turned base from the zero of the first
    joint: all that explain it are named, those first that need fewer numbers.

    Args:
        kinematics: of the cell.
        arm: whose pose it is.
        q: (n,) [rad, m] its joints, in chain order.
        T_shown: the pose on the pendant.

    Returns:
        Agreement alone where the poses agree; together with a joint only causes of one number.
    """
    here = base_poses(kinematics, arm, q)
    for frame, T in here.items():
        if _is_same(T, T_shown):
            return (Cause("none", frame),)
    joints = sorted(
        (
            Cause("joint", frame, arm.joints[number], offset)
            for frame in here
            for number in range(len(arm.joints))
            if (offset := _joint_offset(kinematics, arm, q, number, frame, T_shown)) is not None
        ),
        key=lambda cause: abs(cause.offset),
    )
    # A tool may be given anew, or be the cell's a little off: whichever needs fewer numbers.
    T_flange_shown, T_tcp_shown = (T.actInv(T_shown) for T in here.values())
    tool = Cause("tool", "tcp", T=T_flange_shown)
    found = [(min(_numbers(T_flange_shown), _numbers(T_tcp_shown)), tool)]
    for frame, T in here.items():
        T_shown_base = T_shown * T.inverse()
        found.append((_numbers(T_shown_base), Cause("base", frame, T=T_shown_base)))
    found.sort(key=lambda entry: entry[0])
    return (*joints, *(cause for count, cause in found if count == 1 or not joints))


def _is_same(T: pin.SE3, other: pin.SE3) -> bool:
    shift, turn = shift_and_turn(T.actInv(other))
    return shift <= SAME_POSE[0] and turn <= SAME_POSE[1]


def _joint_offset(
    kinematics: Kinematics, arm: Arm, q: Floats, number: int, frame: Frame, T_shown: pin.SE3
) -> float | None:
    """By how much this joint alone would have to be off [rad, m]; None where that is not it."""
    step = 1e-6
    ahead = np.array(q, dtype=np.float64)
    ahead[number] += step
    T, T_ahead = (base_poses(kinematics, arm, values)[frame] for values in (q, ahead))
    # The joint moves all behind it along one screw: as far as the shown pose is from this one.
    screw = pin.log6(T_ahead * T.inverse()).vector / step
    needed = pin.log6(T_shown * T.inverse()).vector
    offset = float(screw @ needed / (screw @ screw))
    moved = np.array(q, dtype=np.float64)
    moved[number] += offset
    return offset if _is_same(base_poses(kinematics, arm, moved)[frame], T_shown) else None


def _numbers(T: pin.SE3) -> int:
    """How many shifts along the axes and turns about them a pose needs."""
    shift, turn = np.abs(T.translation), np.abs(pin.log3(T.rotation))
    return int(np.sum(shift > SAME_POSE[0]) + np.sum(turn > SAME_POSE[1]))

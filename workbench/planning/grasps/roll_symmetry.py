"""Whether a hand takes a part alike however that is turned about its axis.

The scan may not show a part's roll.  What the hand does to it must then be right for all turns: the
hand keeps out of the room of all of them (`collision.rolled`), and what it closes on is checked
here, turn after turn.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Tool
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import Grasp, Part
from workbench.model.scan import Detection
from workbench.model.symmetry import make_turn
from workbench.planning.collision.hands import closed_press
from workbench.planning.collision.legs import grips
from workbench.planning.collision.unknown_rolls import axis_of, room_of, turns_about
from workbench.planning.grasps.grasp_check import FRICTION, ROUNDING, GraspChecker
from workbench.planning.grasps.pads import PadContact

HAND_DIGITS = 7
"""Decimals [m] by which hands are distinguished: what differs less is checked once."""


@dataclass(frozen=True, slots=True)
class Uneven:
    """What differs between the turns of a part, and by how much [m]."""

    message: Message
    amount: float


def uneven(part: Part, detection: Detection, arm: Arm, grasp: Grasp) -> tuple[Uneven | None, ...]:
    """For each of the `grips` of a grasp what is wrong at some turn of the part; None for nothing.

    Args:
        part: that is taken.
        detection: of it, whose roll is not known.
        arm: whose tool.
        grasp: of the part.
    """
    return _uneven(part, axis_of(part, detection).tobytes(), arm, grasp)


@lru_cache(maxsize=4096)
def _uneven(part: Part, axis: bytes, arm: Arm, grasp: Grasp) -> tuple[Uneven | None, ...]:
    line = np.frombuffer(axis).reshape(2, 3)
    # Pads give way by `press`: what fingers meet before that is not what they shall hold.
    closed, allowed = (grasp.grip, 0.0) if arm.tool.fingers else (0.0, arm.tool.press)
    wide = closed + 2 * (closed_press(arm.tool, part) - allowed)
    found: list[Uneven | None] = []
    for grip in grips(arm.tool, grasp):
        T = grasp.T_part_tcp * grip
        room = _room_checker(part, arm.tool, axis)
        if room.clearance(T, wide, within=0.0)[0] < -allowed - ROUNDING:
            depth, at = room.clearance(T, closed, within=0.0)
            note = VerdictNote.CUTS_INTO(closed=closed, body=at, depth=-depth)
            found.append(Uneven(note, -depth))
            continue
        key = (np.round(_without_turn(line, T).homogeneous, HAND_DIGITS)[:3] + 0.0).tobytes()
        found.append(
            _compare_holds(part, arm.tool, axis, key, grasp.opening, grasp.approach_length)
        )
    return tuple(found)


def _without_turn(axis: Floats, T_part_tcp: pin.SE3) -> pin.SE3:
    """The one of all hands that differ by a turn about the axis that stands for them."""
    point, direction = axis
    R, out = T_part_tcp.rotation, T_part_tcp.translation - point
    side, across = np.eye(3)[int(np.argmin(np.abs(direction)))], out
    for way in (out, R[:, 2], R[:, 0]):
        across = way - (way @ direction) * direction
        if np.linalg.norm(across) > 1e-4:
            break
    side = side - (side @ direction) * direction
    angle = np.arctan2(np.cross(side, across) @ direction, side @ across)
    return make_turn(direction, float(-angle), point) * T_part_tcp


@lru_cache(maxsize=8)
def _checker(part: Part, tool: Tool) -> GraspChecker:
    return GraspChecker(part, tool)


@lru_cache(maxsize=16)
def _room_checker(part: Part, tool: Tool, axis: bytes) -> GraspChecker:
    """Of the room of all turns."""
    line = np.frombuffer(axis).reshape(2, 3)
    detection = Detection(part.name, pin.SE3.Identity(), roll_known=False, roll_axis=line)
    return GraspChecker(replace(part, pieces=room_of(part, detection)), tool)


@lru_cache(maxsize=16384)
def _compare_holds(
    part: Part, tool: Tool, axis: bytes, T_part_tcp: bytes, opening: float, approach_length: float
) -> Uneven | None:
    """What differs in what a hand holds, over all turns."""
    rows = np.frombuffer(T_part_tcp).reshape(3, 4)
    T = pin.SE3(rows[:, :3].copy(), rows[:, 3].copy())
    hands = [turn * T for turn in turns_about(np.frombuffer(axis).reshape(2, 3))]
    checker = _checker(part, tool)
    if not tool.fingers:
        grasp = Grasp("", T, 0.0, 0.0, approach_length=approach_length)
        seals = (checker.seal_findings(replace(grasp, T_part_tcp=hand)) for hand in hands)
        leak = next((found[0] for found in seals if found), None)
        if leak is None:
            return None
        return Uneven(VerdictNote.AT_SOME_TURN(problem=leak.text), leak.amount)
    if checker.pads is None:
        return Uneven(VerdictNote.MANY_FINGERS(count=len(tool.fingers)), 0.0)
    holds: list[PadContact] = []
    for hand in hands:
        hold = checker.hold(hand, opening)
        if hold is None:
            return Uneven(VerdictNote.NOTHING_HELD(), 0.0)
        holds.append(hold)
    return _compare(holds, tool.press)


def _compare(holds: list[PadContact], press: float) -> Uneven | None:
    """What fingers hold at some turns and not at others; pads give way by `press` [m]."""
    widths, middles = [hold.width for hold in holds], [hold.offset for hold in holds]
    wide, aside = float(np.ptp(widths)), float(np.ptp(middles))
    if wide > press:
        return Uneven(VerdictNote.WIDTH_VARIES(low=min(widths), high=max(widths)), wide)
    if aside > press:
        return Uneven(VerdictNote.OFF_CENTRE(aside=aside), aside)
    steepest = [max(hold.slants) for hold in holds]
    if max(steepest) > FRICTION >= min(steepest):
        return Uneven(VerdictNote.INCLINED(angle=float(max(steepest))), 0.0)
    return None

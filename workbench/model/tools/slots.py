"""A cell by the tools that its arms carry: the others stand in their slots, as obstacles."""

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell, Finger, Fixture, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Solid
from workbench.model.messages.cells import SlotText
from workbench.model.messages.message import Message
from workbench.model.robot import ToolSlot

NO_TOOL = Tool("", pin.SE3.Identity(), (), mass=0.0)
"""What a bare flange carries."""

FINGER_STEP = 0.005
"""[m] Nobody knows how far open the fingers are of a tool in its slot: they stand there at all
openings that are this far apart."""


def with_mounted(cell: Cell, arm: str, tool: str) -> Cell:
    """The cell with another of an arm's tools mounted; empty: with a bare flange.

    Raises:
        InputError: the arm has no such tool.
    """
    mounted = tool_of_arm(cell.arm(arm), tool) if tool else NO_TOOL
    arms = (replace(a, tool=mounted) if a.name == arm else a for a in cell.arms)
    return replace(cell, arms=tuple(arms))


def tool_of_arm(arm: Arm, name: str) -> Tool:
    """The tool of that name, of those that an arm can carry.

    Raises:
        InputError: there is none; the message lists those there are.
    """
    for tool in (arm.tool, *arm.tools):
        if tool.name == name:
            return tool
    known = [tool.name for tool in arm.tools]
    raise InputError(SlotText.NO_TOOL(arm=arm.name, name=f"{name!r:.60}", known=known))


def slot_of(arm: Arm, tool: str) -> ToolSlot | None:
    """The slot of one of an arm's tools; None where it has none."""
    return next((slot for slot in arm.tool_slots if slot.tool == tool), None)


def arm_with_slot(cell: Cell, tool: str) -> str:
    """The name of the first arm that has a slot for a tool; where none has, of the first arm."""
    having = (arm.name for arm in cell.arms if slot_of(arm, tool) is not None)
    return next(having, cell.arms[0].name)


def stands_in_slot(arm: Arm, tool: str) -> bool:
    """Whether a tool has a slot, and stands there since the arm carries another one or none."""
    return tool != arm.tool.name and slot_of(arm, tool) is not None


def change_problem(cell: Cell, arm_name: str, tool: str) -> Message | None:
    """Why an arm cannot put down its tool and take that one; None when it can.

    Raises:
        InputError: there is no such arm, or it has no such tool.
    """
    arm = cell.arm(arm_name)
    wanted = tool_of_arm(arm, tool)
    if wanted.name == arm.tool.name:
        return SlotText.CARRIED(arm=arm.name, tool=tool)
    for name in (arm.tool.name, tool):
        if slot_of(arm, name) is None:
            return SlotText.NO_SLOT(arm=arm.name, tool=name)
    if not cell.controller.motion.takes_tools:
        return SlotText.NO_LINK(link=cell.controller.link)
    if arm.jerk is not None:
        return SlotText.JERK(arm=arm.name)
    return None


def standing_tools(cell: Cell) -> tuple[Fixture, ...]:
    """The tools that stand in their slots, each as a fixture whose frame is that of the flange."""
    return tuple(
        Fixture(standing_name(arm, slot.tool), slot.T_world_flange, _solids(arm, slot.tool))
        for arm in cell.arms
        for slot in arm.tool_slots
        if stands_in_slot(arm, slot.tool)
    )


def standing_name(arm: Arm, tool: str) -> str:
    """The name of a tool in its slot, among fixtures."""
    return f"{arm.name} slot {tool}"


def _solids(arm: Arm, name: str) -> tuple[Solid, ...]:
    tool = tool_of_arm(arm, name)
    fingers = (solid for finger in tool.fingers for solid in _at_all_openings(tool, finger))
    return tuple(
        replace(solid, name=f"{name} {solid.name} in its slot") for solid in (*tool.body, *fingers)
    )


def _at_all_openings(tool: Tool, finger: Finger) -> tuple[Solid, ...]:
    low, high = tool.stroke[0] / 2, tool.stroke[1] / 2
    count = 1 + math.ceil((high - low) / FINGER_STEP)
    shifts = (share * finger.direction for share in np.linspace(low, high, count))
    return tuple(
        replace(
            finger.solid,
            T_owner_shape=pin.SE3(np.eye(3), np.asarray(shift)) * finger.solid.T_owner_shape,
        )
        for shift in shifts
    )

"""The tools that arms of a new cell carry until somebody describes theirs."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from workbench.formats.grippers.grippers import gripper_of, tool_name
from workbench.formats.robots.descriptions import Description, read_description
from workbench.model.cell import Finger, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy

DARK, LIGHT = (0.35, 0.36, 0.4), (0.55, 0.57, 0.6)


def first_tools(
    typed: str, package_paths: Sequence[Path], hands: Sequence[Description | None]
) -> tuple[tuple[Tool, ...], tuple[str, ...]]:
    """The tool of each arm, and what was decided about them.

    Args:
        typed: `gripper`, `suction`, or the path of a URDF or xacro file; empty: their own hands.
        package_paths: folders where packages are searched for first.
        hands: what hangs on the flange of each arm in the robot's own file.

    Raises:
        InputError: the file holds no gripper.
        FileError: it cannot be read.
    """
    match typed:
        case "":
            return _own_hands(hands)
        case "gripper":
            return (gripper(),) * len(hands), ()
        case "suction":
            return (suction_cup(),) * len(hands), ()
        case _:
            found = read_description(Path(typed), package_paths=package_paths)
            tool, notes = gripper_of(found, tool_name(found))
            return (tool,) * len(hands), notes


def _own_hands(
    hands: Sequence[Description | None],
) -> tuple[tuple[Tool, ...], tuple[str, ...]]:
    """The hand of each arm; a gripper where it has none, or one that cannot be a tool."""
    tools: list[Tool] = []
    notes: list[str] = []
    for number, hand in enumerate(hands, start=1):
        tool = gripper()
        if hand is not None:
            name = "hand" if len(hands) == 1 else f"hand_{number}"
            try:
                tool, said = gripper_of(hand, name)
                notes += said
            except InputError as error:
                notes.append(f"{error}; the arm carries a gripper of the usual size instead")
        tools.append(tool)
    return tuple(tools), tuple(notes)


def gripper() -> Tool:
    """A parallel gripper of the usual size; its fingers close along y of the TCP."""
    finger = Box(np.array([0.006, 0.01, 0.06]))
    return Tool(
        "gripper",
        pose_from_rpy((0, 0, 0.16), (0, 0, -np.pi / 2)),
        (Solid("palm", Cylinder(0.04, 0.1), pose_from_rpy((0, 0, 0.05)), DARK),),
        tuple(
            Finger(
                Solid(f"finger_{name}", finger, pose_from_rpy((0.003 * side, 0, 0.13)), LIGHT),
                np.array([side, 0.0, 0.0]),
            )
            for name, side in (("a", 1.0), ("b", -1.0))
        ),
        (0.0, 0.06),
    )


def suction_cup() -> Tool:
    """A suction cup on a tube."""
    return Tool(
        "suction_cup",
        pose_from_rpy((0, 0, 0.2)),
        (
            Solid("mount", Cylinder(0.03, 0.03), pose_from_rpy((0, 0, 0.015)), DARK),
            Solid("tube", Cylinder(0.01, 0.158), pose_from_rpy((0, 0, 0.109)), LIGHT),
            Solid("cup", Cylinder(0.016, 0.012), pose_from_rpy((0, 0, 0.194)), DARK),
        ),
        press=0.003,
    )

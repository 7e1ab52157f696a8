"""The tools that arms of a new cell carry until somebody describes theirs."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from workbench.formats.grippers.grippers import gripper_of
from workbench.formats.robots.descriptions import read_description
from workbench.model.cell import Finger, Tool
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy

DARK, LIGHT = (0.35, 0.36, 0.4), (0.55, 0.57, 0.6)


def first_tool(typed: str, package_paths: Sequence[Path]) -> tuple[Tool, tuple[str, ...]]:
    """The tool that somebody names, and what was decided about it.

    Args:
        typed: `gripper`, `suction`, or the path of a URDF or xacro file.
        package_paths: folders where packages are searched for first.

    Raises:
        InputError: the file holds no gripper.
        FileError: it cannot be read.
    """
    match typed:
        case "gripper":
            return gripper(), ()
        case "suction":
            return suction_cup(), ()
        case _:
            found = read_description(Path(typed), package_paths=package_paths)
            return gripper_of(found, found.robot.name)


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

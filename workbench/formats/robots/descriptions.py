"""Robots as their makers describe them: what a file leaves open is assumed, and reported."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from workbench.formats.files.whole_files import read_whole
from workbench.formats.files.xml_elements import LARGEST_FILE, parse_xml
from workbench.formats.meshes.reading import WrongUnit
from workbench.formats.robots.packages import Packages
from workbench.formats.robots.remarks import Remarks
from workbench.formats.robots.urdf import robot_of
from workbench.formats.robots.urdf_geometry import Shapes, read_colours
from workbench.formats.robots.urdf_joints import Follower
from workbench.formats.robots.xacro_files import Expanded, expand_xacro, is_xacro
from workbench.model.errors import FileError
from workbench.model.geometry import Mesh
from workbench.model.robot import Robot

MeshUnit = Literal["m", "mm"]

MM = 0.001
TINY_MESH, JOINT_DISTANCE = 0.01, 0.1
"""[m] Meshes of a robot are not all smaller than the one while its joints are that far apart."""


@dataclass(frozen=True, slots=True, eq=False)
class Description:
    """A robot, the joints in it that follow others, and sentences about what was assumed."""

    robot: Robot
    followers: tuple[Follower, ...] = ()
    notes: tuple[str, ...] = ()


def read_description(
    path: Path,
    *,
    arguments: Mapping[str, str] | None = None,
    package_paths: Sequence[Path] = (),
    mesh_unit: MeshUnit | None = None,
) -> Description:
    """A robot from the URDF or xacro file of somebody else.

    Args:
        path: of the file; packages that it names are searched for around it (`Packages`).
        arguments: for a xacro file.
        package_paths: folders where packages are searched for first.
        mesh_unit: of meshes of which neither the URDF nor their own file says it; None: metres,
            or millimetres where metres would make a mesh larger than a robot.

    Raises:
        FileError: something without which there is no robot is missing or wrong.
    """
    packages = Packages(path, package_paths)
    if is_xacro(path):
        source = expand_xacro(path, arguments or {}, packages)
    else:
        unused = ("it is no xacro file, so it takes no arguments",) if arguments else ()
        source = Expanded(read_whole(path, LARGEST_FILE), unused)
    if mesh_unit is not None:
        return _read(path, source, packages, MM if mesh_unit == "mm" else 1.0)
    try:
        return _read(path, source, packages, 1.0)
    except WrongUnit as error:
        found = _read(path, source, packages, MM)
        note = f"its meshes are taken to be in mm, since in m {error}"
        return Description(found.robot, found.followers, (note, *found.notes))


def _read(path: Path, source: Expanded, packages: Packages, scale: float) -> Description:
    root, remarks = parse_xml(path, source.content, "robot"), Remarks(is_strict=False)
    shapes = Shapes(read_colours(root), packages, remarks, scale)
    robot, followers = robot_of(path, root, shapes, remarks)
    largest = _largest_mesh(robot)
    apart = sum(float(np.linalg.norm(joint.T_parent_joint.translation)) for joint in robot.joints)
    if 0 < largest < TINY_MESH and apart > JOINT_DISTANCE:
        raise FileError(
            path,
            f"its largest mesh would be {largest * 1000:.2g} mm, its joints are {apart:.2g} m "
            "apart: correct --mesh-unit, or the scale of its meshes",
        )
    return Description(robot, followers, (*source.notes, *remarks.sentences))


def _largest_mesh(robot: Robot) -> float:
    """The largest side of all meshes [m]; 0 without any."""
    return max(
        (
            float(np.ptp(solid.shape.points, axis=0).max())
            for link in robot.links
            for solid in (*link.collision, *link.visual)
            if isinstance(solid.shape, Mesh)
        ),
        default=0.0,
    )

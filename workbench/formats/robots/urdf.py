"""URDF and SRDF to a robot: links, joints, geometry, and pairs that need no check.

Beyond the standard, `<capsule radius= length=>` is read (length of the cylinder alone), and a
mesh named `*.convex.obj` counts as a solid convex piece.  What the standard has for dynamics,
transmissions and simulators is passed over.  A mimic joint, and a continuous one without a limit,
such as a wheel, counts as fixed.

Source: https://wiki.ros.org/urdf/XML
"""

from pathlib import Path
from typing import Literal

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.xml_elements import Element, read_xml
from workbench.formats.robots.packages import Packages
from workbench.formats.robots.remarks import Remarks
from workbench.formats.robots.urdf_geometry import Shapes, read_colours
from workbench.formats.robots.urdf_joints import Follower, as_tree, read_joint
from workbench.formats.robots.xacro_files import is_xacro
from workbench.model.errors import FileError
from workbench.model.robot import Link, Robot

Collision = Literal["as_is", "hull"]


def read_urdf(
    path: Path, *, collision: Collision = "as_is", hull_except: tuple[str, ...] = ()
) -> Robot:
    """A robot from a URDF file that has to be right in everything.

    Args:
        path: the file; meshes are looked up next to it and, for `package://`, around it.
        collision: `hull` replaces every collision mesh by its convex hull.
        hull_except: links whose meshes stay as they are.

    Raises:
        FileError: not XML, a mesh is missing, the links are not one tree, a number is wrong.
    """
    root = read_xml(path, "robot")
    if is_xacro(path):
        raise FileError(path, "is a xacro file; `workbench cell new` expands it")
    remarks = Remarks()
    shapes = Shapes(read_colours(root), Packages(path), remarks)
    hulls = None if collision == "as_is" else hull_except
    return robot_of(path, root, shapes, remarks, hull_except=hulls)[0]


def robot_of(
    path: Path,
    root: Element,
    shapes: Shapes,
    remarks: Remarks,
    *,
    hull_except: tuple[str, ...] | None = None,
) -> tuple[Robot, tuple[Follower, ...]]:
    """The robot under a root element, and its joints that follow others.

    Args:
        path: of the file, for messages.
        root: the element `<robot>`.
        shapes: reads the geometry of its links.
        remarks: about what is passed over.
        hull_except: links whose collision meshes do not become convex; None: of none.

    Raises:
        FileError: as `read_urdf`.
    """
    links: dict[str, Link] = {}
    for element in root.all("link"):
        name = element.text("name")
        if name in links:
            raise element.with_name(name).error("is there twice")
        is_hull = hull_except is not None and name not in hull_except
        links[name] = shapes.link(element.with_name(name), name, hull=is_hull)
    if not links:
        raise FileError(path, "has no links")
    for name in hull_except or ():
        if name not in links:
            raise FileError(path, f"has no link {quote(name)} whose meshes could stay as they are")
    followers: list[Follower] = []
    joints = [
        read_joint(element.with_name(element.text("name")), links, remarks, followers)
        for element in root.all("joint")
    ]
    ordered = as_tree(path, links, joints)
    there = {joint.name for joint in joints}
    for follower in followers:
        if follower.leader not in there:
            joint, leader = quote(follower.joint.name), quote(follower.leader)
            problem = f"joint {joint}: there is no joint {leader} to mimic"
            remarks.pass_over(FileError(path, problem), "it stands still")
    robot = Robot(root.text("name", path.stem), tuple(links.values()), ordered)
    return robot, tuple(follower for follower in followers if follower.leader in there)


def read_srdf(path: Path) -> frozenset[tuple[str, str]]:
    """The link pairs that an SRDF file excludes from collision checking.

    Raises:
        FileError: not XML, or a pair without its two names.
    """
    pairs = (
        (element.text("link1"), element.text("link2"))
        for element in read_xml(path, "robot").all("disable_collisions")
    )
    return frozenset((min(pair), max(pair)) for pair in pairs)

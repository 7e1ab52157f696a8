"""URDF and SRDF to a robot: links, joints, geometry, and pairs that need no check.

Beyond the standard, `<capsule radius= length=>` is read (length of the cylinder alone), and a
mesh named `*.convex.obj` counts as a solid convex piece.  What the standard has for dynamics,
transmissions and simulators is passed over.  A mimic joint, and a continuous one without a limit,
such as a wheel, counts as fixed.

Source: https://wiki.ros.org/urdf/XML
"""

import math
from collections import Counter, defaultdict
from pathlib import Path
from typing import Literal

import numpy as np

from workbench.formats.files.toml_keys import shown
from workbench.formats.files.xml_elements import Element, parse_xml, read_xml
from workbench.formats.robots.urdf_geometry import Shapes, read_colours, read_pose
from workbench.formats.robots.xacro_files import is_xacro
from workbench.model.errors import FileError
from workbench.model.robot import Joint, JointKind, Link, Robot

Collision = Literal["as_is", "hull"]

KINDS: dict[str, JointKind] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
WIDEST_TURN = 4 * math.pi
"""[rad] Wider joint limits are taken for degrees."""
FASTEST_TURN = 100.0
"""[rad/s] Faster joints are taken for degrees per second."""
NO_LIMIT = 1000.0
"""[rad/s] A joint this fast stands in a file that knows no limit for it."""
LONGEST_SLIDE = 20.0
"""[m] Longer slides are taken for millimetres."""


def read_urdf(
    path: Path,
    *,
    collision: Collision = "as_is",
    hull_except: tuple[str, ...] = (),
    mesh_scale: float = 1.0,
    content: bytes | None = None,
) -> Robot:
    """A robot from a URDF file.

    Args:
        path: the file; meshes are looked up beside it and, for `package://`, above it.
        collision: `hull` replaces every collision mesh by its convex hull.
        hull_except: links whose meshes stay as they are.
        mesh_scale: of all meshes, beside what the file says: 0.001 when they are in mm.
        content: of the file, where it is not to be read but was expanded from it.

    Raises:
        FileError: not XML, a mesh is missing, the links are not one tree, a number is wrong.
    """
    root = read_xml(path, "robot") if content is None else parse_xml(path, content, "robot")
    if content is None and is_xacro(path):
        raise FileError(path, "is a xacro file; `workbench cell new` expands it")
    shapes = Shapes(read_colours(root), mesh_scale)
    links: dict[str, Link] = {}
    for element in root.all("link"):
        name = element.text("name")
        if name in links:
            raise element.named(name).error("is there twice")
        hull = collision == "hull" and name not in hull_except
        links[name] = Link(
            name,
            collision=shapes.solids(element.named(name), "collision", name, hull=hull),
            visual=shapes.solids(element.named(name), "visual", name, hull=False),
        )
    if not links:
        raise FileError(path, "has no links")
    for name in hull_except:
        if name not in links:
            raise FileError(path, f"has no link {shown(name)} whose meshes could stay as they are")
    joints = [_joint(element.named(element.text("name")), links) for element in root.all("joint")]
    return Robot(root.text("name", path.stem), tuple(links.values()), _as_tree(path, links, joints))


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


def _joint(element: Element, links: dict[str, Link]) -> Joint:
    name, declared = element.text("name"), element.text("type")
    if declared not in KINDS:
        raise element.error(f"type={shown(declared)} is not one of {', '.join(KINDS)}")
    kind = KINDS[declared]
    parent, child = (_end(element, tag, links) for tag in ("parent", "child"))
    T, axis = read_pose(element), np.array([1.0, 0.0, 0.0])
    # A wheel may come without a limit: nobody says how fast it turns, so it is not turned.  Who
    # mimics another, as the second finger does, cannot be sent anywhere.
    is_wheel = declared == "continuous" and element.one("limit") is None
    if kind == "fixed" or is_wheel or element.one("mimic") is not None:
        return Joint(name, "fixed", parent, child, T, axis)
    given = element.one("axis")
    if given is not None:
        axis = given.numbers("xyz", 3)
        if np.linalg.norm(axis) < 1e-9:
            raise given.error("has no direction")
        axis = axis / np.linalg.norm(axis)
    return Joint(name, kind, parent, child, T, axis, *_limits(element, declared))


def _end(element: Element, tag: str, links: dict[str, Link]) -> str:
    end = element.one(tag)
    if end is None:
        raise element.error(f"has no <{tag}>")
    link = end.text("link")
    if link not in links:
        raise end.error(f"there is no link {shown(link)}")
    return link


def _limits(element: Element, declared: str) -> tuple[float, float, float]:
    """Lower and upper limit [rad or m] and velocity [rad/s or m/s]."""
    limit = element.one("limit")
    if limit is None:
        raise element.error("has no <limit> with lower, upper and velocity")
    velocity = limit.number("velocity")
    if velocity <= 0:
        raise limit.error(
            f"velocity={velocity:g}: must be positive; give its speed, or make the joint fixed"
        )
    turns = declared != "prismatic"
    if turns and FASTEST_TURN < velocity < NO_LIMIT:
        raise limit.error(f"velocity={velocity:g}: rad/s are expected, this looks like degrees")
    if declared == "continuous":
        return -2 * math.pi, 2 * math.pi, velocity
    lower, upper = limit.number("lower", 0.0), limit.number("upper", 0.0)
    if not lower < upper:
        raise limit.error(
            f"lower={lower:g} is not less than upper={upper:g}; "
            "give its range, or make the joint fixed"
        )
    widest, unit, other = (
        (WIDEST_TURN, "radians", "degrees") if turns else (LONGEST_SLIDE, "metres", "millimetres")
    )
    if max(-lower, upper) > widest:
        raise limit.error(
            f"lower={lower:g} and upper={upper:g}: {unit} are expected, these look like {other}"
        )
    return lower, upper, velocity


def _as_tree(path: Path, links: dict[str, Link], joints: list[Joint]) -> tuple[Joint, ...]:
    """The joints with parents before children, when they make one tree of all links."""
    for name, times in Counter(joint.name for joint in joints).items():
        if times > 1:
            raise FileError(path, f"joint {shown(name)} is there {times} times")
    children = Counter(joint.child for joint in joints)
    for name, times in children.items():
        if times > 1:
            raise FileError(path, f"link {shown(name)} is the child of {times} joints")
    roots = [name for name in links if name not in children]
    if not roots:
        raise FileError(path, "no link is the root: the joints make a circle")
    if len(roots) > 1:
        listed = ", ".join(shown(name) for name in roots[:5])
        raise FileError(path, f"one link must be the root, these {len(roots)} are: {listed}")
    onward: defaultdict[str, list[Joint]] = defaultdict(list)
    for joint in joints:
        onward[joint.parent].append(joint)
    ordered = list(onward[roots[0]])
    for joint in ordered:  # grows while it is walked
        ordered += onward[joint.child]
    if len(ordered) < len(joints):
        left = next(joint for joint in joints if joint not in ordered)
        raise FileError(path, f"joint {shown(left.name)} is part of a circle")
    return tuple(ordered)

"""URDF and SRDF to a robot: links, joints, geometry, and pairs that need no check.

Beyond the standard, `<capsule radius= length=>` is read (length of the cylinder alone), and a
mesh named `*.convex.obj` counts as a solid convex piece.
"""

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Literal

import numpy as np

from workbench.formats.meshes import convex_hull, read_mesh
from workbench.model.errors import FileError
from workbench.model.geometry import (
    Box,
    Capsule,
    Cylinder,
    Floats,
    Mesh,
    Shape,
    Solid,
    Sphere,
    pose_from_rpy,
)
from workbench.model.robot import Joint, JointKind, Link, Robot

Collision = Literal["as_is", "hull"]

LARGEST_FILE = 20 * 1024 * 1024
GREY = (0.78, 0.78, 0.8)


def read_urdf(
    path: Path, *, collision: Collision = "as_is", hull_except: tuple[str, ...] = ()
) -> Robot:
    """A robot from a URDF file.

    Args:
        path: the file; meshes are looked up beside it and, for `package://`, above it.
        collision: `hull` replaces every collision mesh by its convex hull.
        hull_except: links whose meshes stay as they are.

    Raises:
        FileError: not XML, a mesh is missing, the links are not one tree, a number is wrong.
    """
    root = _parsed(path, "robot")
    colours = _materials(root)
    links: dict[str, Link] = {}
    for element in root.findall("link"):
        name = _attribute(path, element, "name")
        if name in links:
            raise FileError(path, f"link {name!r} is there twice")
        as_hull = collision == "hull" and name not in hull_except
        links[name] = Link(
            name,
            collision=_solids(path, element, "collision", name, colours, as_hull),
            visual=_solids(path, element, "visual", name, colours, False),
        )
    if not links:
        raise FileError(path, "has no links")
    joints = [_joint(path, element, links) for element in root.findall("joint")]
    return Robot(
        root.get("name") or path.stem, tuple(links.values()), _as_tree(path, links, joints)
    )


def read_srdf(path: Path) -> frozenset[tuple[str, str]]:
    """The link pairs that an SRDF file excludes from collision checking.

    Raises:
        FileError: not XML, or a pair without its two names.
    """
    pairs = (
        (_attribute(path, element, "link1"), _attribute(path, element, "link2"))
        for element in _parsed(path, "robot").findall("disable_collisions")
    )
    return frozenset((min(pair), max(pair)) for pair in pairs)


def _parsed(path: Path, tag: str) -> ElementTree.Element:
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise FileError(path, f"is larger than {LARGEST_FILE // 1024 // 1024} MB")
        data = path.read_bytes()
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be read") from None
    if b"<!ENTITY" in data:
        raise FileError(path, "declares XML entities, which are not read")
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise FileError(path, f"is not valid XML: {error}") from None
    if root.tag != tag:
        raise FileError(path, f"starts with <{root.tag}>, <{tag}> is expected")
    return root


def _attribute(path: Path, element: ElementTree.Element, key: str) -> str:
    value = element.get(key)
    if not value:
        raise FileError(path, f"<{element.tag}> has no {key}")
    return value


def _numbers(path: Path, element: ElementTree.Element, key: str, default: str) -> Floats:
    text = element.get(key, default)
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.array([math.nan])
    if len(values) != len(default.split()) or not np.all(np.isfinite(values)):
        raise FileError(
            path, f"<{element.tag} {key}={text!r}>: {len(default.split())} numbers are expected"
        )
    return values


def _positive(path: Path, element: ElementTree.Element, key: str) -> float:
    _attribute(path, element, key)
    value = float(_numbers(path, element, key, "0")[0])
    if value < 0 or (value == 0 and key != "length"):
        raise FileError(path, f"<{element.tag} {key}={value:g}>: must be positive")
    return value


def _origin(path: Path, element: ElementTree.Element):  # type: ignore[no-untyped-def]
    origin = element.find("origin")
    if origin is None:
        return pose_from_rpy((0, 0, 0))
    return pose_from_rpy(
        _numbers(path, origin, "xyz", "0 0 0"), _numbers(path, origin, "rpy", "0 0 0")
    )


Colours = dict[str, tuple[float, float, float]]


def _materials(root: ElementTree.Element) -> Colours:
    colours: Colours = {}
    for material in root.iter("material"):
        colour = material.find("color")
        if colour is not None:
            words = colour.get("rgba", "").split()[:3]
            try:
                red, green, blue = (min(max(float(word), 0.0), 1.0) for word in words)
            except ValueError:
                continue  # a colour that cannot be read is no reason to refuse a robot
            colours[material.get("name", "")] = (red, green, blue)
    return colours


def _solids(
    path: Path,
    link: ElementTree.Element,
    tag: str,
    name: str,
    colours: Colours,
    as_hull: bool,
) -> tuple[Solid, ...]:
    solids: list[Solid] = []
    for number, element in enumerate(link.findall(tag)):
        geometry = element.find("geometry")
        if geometry is None or len(geometry) == 0:
            raise FileError(path, f"link {name!r}: <{tag}> has no geometry")
        shape = _shape(path, geometry[0])
        if as_hull and isinstance(shape, Mesh):
            shape = convex_hull(shape)
        material = element.find("material")
        colour = GREY if material is None else colours.get(material.get("name", ""), GREY)
        solids.append(Solid(f"{name}_{number}", shape, _origin(path, element), colour))
    return tuple(solids)


def _shape(path: Path, element: ElementTree.Element) -> Shape:
    match element.tag:
        case "box":
            size = _numbers(path, element, "size", "0 0 0")
            if np.any(size <= 0):
                raise FileError(path, f"<box size={element.get('size')!r}>: must be positive")
            return Box(size)
        case "cylinder" | "capsule":
            radius = _positive(path, element, "radius")
            length = _positive(path, element, "length")
            if element.tag == "capsule":
                return Capsule(radius, length)
            return Cylinder(radius, length)
        case "sphere":
            return Sphere(_positive(path, element, "radius"))
        case "mesh":
            file = _mesh_file(path, _attribute(path, element, "filename"))
            mesh = read_mesh(file, _numbers(path, element, "scale", "1 1 1"))
            if file.name.endswith(".convex.obj"):
                return Mesh(mesh.points, mesh.triangles, is_convex=True)
            return mesh
        case other:
            raise FileError(
                path, f"<{other}> is no known geometry (box, cylinder, capsule, sphere, mesh)"
            )


def _mesh_file(path: Path, name: str) -> Path:
    """Beside the URDF, or for `package://` in it or in one of the folders above."""
    plain = name.removeprefix("file://")
    if not plain.startswith("package://"):
        file = (path.parent / plain).resolve()
        if file.is_file():
            return file
        raise FileError(path, f"mesh {name!r} is not there (looked for {file})")
    package, _, rest = plain.removeprefix("package://").partition("/")
    for folder in (path.parent, *path.resolve().parents):
        for file in (folder / package / rest, folder / rest):
            if file.is_file():
                return file
        if folder.name == package and (folder / rest).is_file():
            return folder / rest
    raise FileError(path, f"mesh {name!r} is not in the URDF's folder or one above it")


def _joint(path: Path, element: ElementTree.Element, links: dict[str, Link]) -> Joint:
    name = _attribute(path, element, "name")
    ends: list[str] = []
    for tag in ("parent", "child"):
        end = element.find(tag)
        link = "" if end is None else end.get("link", "")
        if link not in links:
            raise FileError(path, f"joint {name!r}: {tag} link {link!r} does not exist")
        ends.append(link)
    declared = _attribute(path, element, "type")
    kinds: dict[str, JointKind] = {
        "revolute": "revolute",
        "continuous": "revolute",
        "prismatic": "prismatic",
        "fixed": "fixed",
    }
    if declared not in kinds:
        raise FileError(path, f"joint {name!r}: type {declared!r} is not one of {', '.join(kinds)}")
    kind = kinds[declared]
    T, axis = _origin(path, element), np.array([1.0, 0.0, 0.0])
    if kind == "fixed":
        return Joint(name, kind, ends[0], ends[1], T, axis)
    given = element.find("axis")
    if given is not None:
        axis = _numbers(path, given, "xyz", "1 0 0")
    if np.linalg.norm(axis) < 1e-9:
        raise FileError(path, f"joint {name!r}: the axis has no direction")
    lower, upper, velocity = _limits(path, element, name, declared)
    axis = axis / np.linalg.norm(axis)
    return Joint(name, kind, ends[0], ends[1], T, axis, lower, upper, velocity)


def _limits(
    path: Path, element: ElementTree.Element, name: str, declared: str
) -> tuple[float, float, float]:
    limit = element.find("limit")
    if limit is None:
        raise FileError(path, f"joint {name!r}: <limit> with lower, upper and velocity is missing")
    velocity = float(_numbers(path, limit, "velocity", "0")[0])
    lower, upper = (float(_numbers(path, limit, key, "0")[0]) for key in ("lower", "upper"))
    if declared == "continuous":
        lower, upper = -2 * math.pi, 2 * math.pi
    if not lower < upper:
        raise FileError(path, f"joint {name!r}: lower limit {lower:g} is not below upper {upper:g}")
    if velocity <= 0:
        raise FileError(path, f"joint {name!r}: the velocity limit must be positive")
    if declared == "revolute" and max(abs(lower), abs(upper)) > 4 * math.pi:
        raise FileError(
            path, f"joint {name!r}: limits {lower:g} to {upper:g} rad look like degrees"
        )
    return lower, upper, velocity


def _as_tree(path: Path, links: dict[str, Link], joints: list[Joint]) -> tuple[Joint, ...]:
    """The joints with parents before children, when they make one tree of all links."""
    children = [joint.child for joint in joints]
    for child in children:
        if children.count(child) > 1:
            raise FileError(path, f"link {child!r} hangs on two joints")
    roots = [name for name in links if name not in children]
    if len(roots) != 1:
        listed = ", ".join(roots) or "none: the joints make a circle"
        raise FileError(path, f"one link must be the root, these are: {listed}")
    reached, ordered, waiting = {roots[0]}, [], list(joints)
    while waiting:
        next_ones = [joint for joint in waiting if joint.parent in reached]
        if not next_ones:
            raise FileError(path, f"joint {waiting[0].name!r} is part of a circle")
        ordered += next_ones
        reached |= {joint.child for joint in next_ones}
        waiting = [joint for joint in waiting if joint.child not in reached]
    return tuple(ordered)

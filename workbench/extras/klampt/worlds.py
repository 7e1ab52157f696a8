"""Klamp't worlds: the cell at the start of a leg, and the motion of the leg.

A world is one XML file that names a robot (URDF) and still things (STL).  The robot carries its
tools, and what it holds, as links of its own.  Everything is collision geometry: these files are
for checking with other tools what was planned here.

Source: https://github.com/krishauser/Klampt, manual, "File types"
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.extras.klampt.urdf_writer import depth_first, write_urdf
from workbench.formats.files.whole_files import file_name, make_folder, write_whole
from workbench.formats.meshes.triangles import stl_of, surface_of
from workbench.formats.robots.urdf_writer import numbers, write_xml
from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_bin import barriers
from workbench.model.geometry import Floats, Solid
from workbench.model.part import Part
from workbench.model.robot import Joint, Link, Robot

WORLD = "world"
"""Klamp't takes a root link of this name for the world itself, and leaves it out of its list."""


@dataclass(frozen=True, slots=True, eq=False)
class WorldPart:
    """A part with its name in the world: `T` is `T_world_part`, or `T_tcp_part` in a hand."""

    name: str
    part: Part
    T: pin.SE3


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """The cell during one leg.

    `standing` are the parts in the bin; `openings` [m] and `held` go by arm.  `joints` are those
    that move, with `t` (n,) [s] and `q` (n, len(joints)); others stand at home, or at zero.
    """

    standing: tuple[WorldPart, ...] = ()
    openings: Mapping[str, float] = field(default_factory=dict)
    held: Mapping[str, WorldPart] = field(default_factory=dict)
    joints: tuple[str, ...] = ()
    t: Floats = field(default_factory=lambda: np.zeros(1))
    q: Floats = field(default_factory=lambda: np.zeros((1, 0)))


def write_world(folder: Path, name: str, cell: Cell, snapshot: Snapshot) -> Path:
    """Write a folder with `world.xml`, `robot.urdf`, their meshes, and `motion.path`.

    Args:
        folder: in which the folder is made.
        name: of the folder.
        cell: robot, tools, bin and fixtures.
        snapshot: the parts, and where everything is.

    Returns:
        The world file.

    Raises:
        FileError: the folder cannot be written to.
    """
    folder = folder / name
    make_folder(folder / "meshes")
    robot = robot_with_tools(cell, snapshot)
    write_urdf(folder / "robot.urdf", robot)
    whole = _configurations(cell, robot, snapshot)
    root = ElementTree.Element("world")
    config = f"{whole.shape[1]} {numbers(whole[0])}"
    ElementTree.SubElement(root, "robot", name=robot.name, file="robot.urdf", config=config)
    still = [("bin", cell.bin.solids, cell.bin.T_world_bin)]
    still += [(fixture.name, fixture.solids, fixture.T_world_fixture) for fixture in barriers(cell)]
    still += [(placed.name, placed.part.pieces, placed.T) for placed in snapshot.standing]
    for thing, solids, T in still:
        if solids:
            root.append(_terrain(folder, thing, solids, T))
    write_xml(folder / "world.xml", root)
    lines = (
        f"{t!r}\t{len(q)} {numbers(q)}\n" for t, q in zip(snapshot.t.tolist(), whole, strict=True)
    )
    write_whole(folder / "motion.path", "".join(lines).encode())
    return folder / "world.xml"


def robot_with_tools(cell: Cell, snapshot: Snapshot) -> Robot:
    """The robot in its place in the world, with `<arm>_tool` and what it holds as links.

    Fingers stand at the snapshot's openings; links that no movable joint parts are not checked
    against each other.
    """
    links, joints = list(cell.robot.links), list(cell.robot.joints)
    for arm in cell.arms:
        tool = f"{arm.name}_tool"
        links.append(Link(tool, _tool_solids(arm, snapshot.openings.get(arm.name, 0.0))))
        joints.append(_fix(arm.flange, tool, pin.SE3.Identity()))
        if housing := cell.scanner.housing_of(arm.name):
            links.append(Link(f"{arm.name}_scanner", housing))
            joints.append(_fix(arm.flange, links[-1].name, pin.SE3.Identity()))
        held = snapshot.held.get(arm.name)
        if held is not None:
            links.append(Link(held.name, held.part.pieces))
            joints.append(_fix(tool, held.name, arm.tool.T_flange_tcp * held.T))
    links.insert(0, Link(WORLD))
    joints.insert(0, _fix(WORLD, cell.robot.root, cell.T_world_robot))
    robot = replace(cell.robot, links=tuple(links), joints=tuple(joints))
    return replace(robot, disabled_pairs=robot.disabled_pairs | frozenset(_rigid_pairs(robot)))


def _tool_solids(arm: Arm, opening: float) -> tuple[Solid, ...]:
    fingers = (
        replace(
            finger.solid,
            T_owner_shape=pin.SE3(np.eye(3), opening / 2 * finger.direction)
            * finger.solid.T_owner_shape,
        )
        for finger in arm.tool.fingers
    )
    return (*arm.tool.body, *fingers)


def _fix(parent: str, child: str, T: pin.SE3) -> Joint:
    return Joint(f"{child}_mount", "fixed", parent, child, T, np.array([0.0, 0.0, 1.0]))


def _rigid_pairs(robot: Robot) -> Iterator[tuple[str, str]]:
    """Links that no movable joint parts."""
    carrier = {robot.root: robot.root}
    for joint in depth_first(robot):
        carrier[joint.child] = carrier[joint.parent] if joint.kind == "fixed" else joint.child
    for first, second in combinations(sorted(carrier), 2):
        if carrier[first] == carrier[second]:
            yield first, second


def _configurations(cell: Cell, robot: Robot, snapshot: Snapshot) -> Floats:
    """Whole configurations (n, joints) as Klamp't orders them; fixed joints count, as zero."""
    names = [joint.name for joint in depth_first(robot)]
    whole = np.zeros((len(snapshot.t), len(names)))
    for arm in cell.arms:
        whole[:, [names.index(joint) for joint in arm.joints]] = arm.home
    whole[:, [names.index(joint) for joint in snapshot.joints]] = snapshot.q
    return whole


def _terrain(folder: Path, name: str, solids: Iterable[Solid], T: pin.SE3) -> ElementTree.Element:
    mesh = f"meshes/{file_name(name)}.stl"
    surface = surface_of(solids)
    surface.apply_transform(T.homogeneous)
    write_whole(folder / mesh, stl_of(surface))
    return ElementTree.Element("terrain", name=name, file=mesh)

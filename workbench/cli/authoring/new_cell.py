"""`workbench cell new`: from a URDF to a cell that can be viewed, checked and changed."""

import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.arguments.cell import CellNew
from workbench.cli.authoring.first_tools import first_tools, gripper
from workbench.cli.authoring.new_cell_report import Made, print_report
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, progress, split_option
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.formats.grippers.grippers import hand_beyond
from workbench.formats.parts.reading import read_part
from workbench.formats.robots.descriptions import Description, read_description
from workbench.formats.robots.in_place import RobotInPlace, box_around, in_pieces
from workbench.formats.robots.urdf_package import simplify_robot
from workbench.model.cell import Arm, Cell, ScannerMount, Tool
from workbench.model.derived.policies import POLICIES
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Bin
from workbench.model.robot import Robot
from workbench.planning.collision.link_pairs import pairs_without_check
from workbench.plugins.extras import from_extra
from workbench.plugins.progress import Report
from workbench.plugins.robot_link import controller_by, usual_link
from workbench.studies.layout.arms import ends_of, right_first, standing, without_hands
from workbench.studies.layout.bins import LaidOut, laid_out
from workbench.studies.layout.flanges import mounts_of, named_mounts

ACCELERATION_DEG = 600
HELD, SUCKED = "keyed_cylinder", "puck"
"""Parts of a first cell, by fingers and by suction cups, where nobody names one."""

MOST_NAMED = 8
"""Files of a folder that are named in a message."""

ACCELERATION = (
    f"no file says how fast joints may accelerate: {ACCELERATION_DEG} degrees/s2 is assumed; "
    "acceleration_deg of each [[arm]] in cell.toml"
)
CONTROLLER = (
    "no file names the controller: a simulated one is written, at 127.0.0.1; replace the whole "
    "[controller] in cell.toml by that of your robot link or of the pick server"
)
MASS = (
    "no file says what the tool weighs, so the controller gets no load: mass_g of [[tool]] in "
    "cell.toml"
)
ASSUMED = (ACCELERATION, MASS, CONTROLLER)
"""What no file of a robot states."""

OTHER_HAND = (
    "with the hand on the flange there is no plan for this part in any bin, so the arms carry a "
    "gripper of the usual size; --part for another part, `workbench cell tool` for another hand"
)

Unchecked = Mapping[tuple[str, str], str]
"""Pairs of links that need no check, each with its reason."""


def new_cell(typed: CellNew) -> int:
    """Make the folder of a cell and tell what was decided."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}", typed.name):
        raise InputError(
            f"name {typed.name!r}: letters, digits, - and _ are expected, 1 to 60 of them"
        )
    check_number("--tolerance-mm", typed.tolerance_mm, 0.1, 1000)
    check_whole("--pieces", typed.pieces, 1, 64)
    for value in typed.position_mm:
        check_number("--position-mm", value, -20_000, 20_000)
    folder = Path("robots") / typed.name if typed.out is None else typed.out
    if folder.exists():
        raise InputError(f"{folder}: is there already; choose another name or --out")
    with progress("new cell") as report:
        report(0.0, "reading the robot")
        world, description = _read(typed)
        arms = _arms(typed, description)
        robot, excess = simplify_robot(
            arms.robot,
            tolerance=typed.tolerance_mm / 1000,
            most=typed.pieces,
            report=lambda done, link: report(0.1 + 0.4 * done, f"convex pieces: {link}"),
        )
        report(0.5, "finding pairs of links that need no check")
        found, unchecked, tool_notes = _with_tools(
            typed, arms, lambda tools: _laid_out(typed, robot, arms, world, tools, report)
        )
        report(0.95, "writing the cell")
        path = write_cell(folder, found.cell, unchecked)
    decisions = (*description.notes, *arms.notes, *tool_notes, *ASSUMED, *found.notes)
    made = Made(path, found.cell, arms.gone, excess, unchecked, decisions)
    print_report(made, as_json=typed.json)
    return SUCCESS


def _with_tools(
    typed: CellNew,
    arms: "_Arms",
    laid_out_with: Callable[[tuple[Tool, ...]], tuple[LaidOut, Unchecked]],
) -> tuple[LaidOut, Unchecked, tuple[str, ...]]:
    """The cell with the tools that are wanted, and what was decided about these.

    Where nobody names any, and the arms pick nothing with their own hands, they get others.
    """
    tools, notes = first_tools(typed.tool, typed.package_path, arms.hands)
    if typed.tool or not any(arms.hands):
        return *laid_out_with(tools), notes
    with suppress(InputError):  # of no bin that is reached
        found, unchecked = laid_out_with(tools)
        if found.takes:
            return found, unchecked, notes
    return *laid_out_with((gripper(),) * len(tools)), (OTHER_HAND,)


def _laid_out(
    typed: CellNew,
    robot: Robot,
    arms: "_Arms",
    world: RobotInPlace,
    tools: tuple[Tool, ...],
    report: Report,
) -> tuple[LaidOut, Unchecked]:
    """The cell with these tools, all at its place, and the pairs of links that need no check."""
    cell = _standing(typed, _bare(typed, robot, arms.flanges, tools), world)
    unchecked = pairs_without_check(cell)
    cell = replace(cell, robot=replace(robot, disabled_pairs=frozenset(unchecked)))
    make_ready(report, ("planning",))
    found = laid_out(
        cell,
        moves_bin=typed.bin is None,
        report=lambda done, what: report(0.6 + 0.3 * done, what),
    )
    return found, unchecked


def import_world(typed: arguments.Import) -> int:
    """Make the folder of a cell from a Klamp't world."""
    return new_cell(
        CellNew(
            re.sub(r"[^A-Za-z0-9_-]", "_", typed.out.name),
            typed.world,
            out=typed.out,
            flange=typed.flange,
            bin=typed.bin,
            tool=typed.tool,
            part=typed.part,
            json=typed.json,
        )
    )


def _read(typed: CellNew) -> tuple[RobotInPlace, Description]:
    """The robot with its original meshes, and its surroundings if the file describes them."""
    if typed.urdf == Path():
        raise InputError("no robot file is named: give the path of a URDF, xacro or Klamp't file")
    if typed.urdf.is_dir():
        raise InputError(_file_to_name(typed.urdf))
    kind = typed.urdf.suffix.lower()
    if kind == ".xml":
        world: RobotInPlace = from_extra("klampt.world_reader:read_klampt_world")(typed.urdf)
        return world, Description(world.robot)
    if kind == ".rob":
        found = Description(from_extra("klampt.robots:read_rob")(typed.urdf))
    else:
        found = read_description(
            typed.urdf,
            arguments=dict(split_option("--xacro", argument, ":=") for argument in typed.xacro),
            package_paths=typed.package_path,
            mesh_unit=typed.mesh_unit,
        )
    T_world_robot = pose_from_rpy(np.array(typed.position_mm) / 1000)
    return RobotInPlace(found.robot, T_world_robot, ()), found


def _file_to_name(folder: Path) -> str:
    """Which robot files a folder has, for who names the folder itself."""
    files = sorted(path for kind in ("*.urdf", "*.xacro") for path in folder.rglob(kind))
    if not files:
        return f"{folder} is a folder, and holds no .urdf or .xacro file"
    names = ", ".join(str(path.relative_to(folder)) for path in files[:MOST_NAMED])
    more = f" and {len(files) - MOST_NAMED} more" if len(files) > MOST_NAMED else ""
    return f"{folder} is a folder; name one of its files: {names}{more}"


@dataclass(frozen=True, slots=True, eq=False)
class _Arms:
    """A robot of which only the arms move, their flanges and hands, and what was left out."""

    robot: Robot
    flanges: tuple[str, ...]
    hands: tuple[Description | None, ...]
    gone: tuple[str, ...]
    notes: tuple[str, ...]


def _arms(typed: CellNew, found: Description) -> _Arms:
    if typed.flange:
        mounts = named_mounts(found.robot, typed.flange)
    else:
        mounts = mounts_of(found.robot, ends_of(found.robot, found.followers))
    flanges = mounts.flanges
    if not 1 <= len(flanges) <= 2:
        raise InputError(
            f"{len(flanges)} flanges are given; one or two are expected: more arms than these are "
            "written into cell.toml by hand"
        )
    if not typed.flange:
        flanges = right_first(flanges)
    hands = tuple(hand_beyond(found, mounts.robot, flange) for flange in flanges)
    robot, gone = without_hands(mounts.robot, flanges)
    there = {joint.name for joint in robot.joints}
    followers = [follower for follower in found.followers if follower.joint.name in there]
    moving = standing(robot, followers, flanges, _read_fixed(typed, found))
    return _Arms(moving.robot, flanges, hands, gone, (*mounts.notes, *moving.notes))


def _read_fixed(typed: CellNew, found: Description) -> dict[str, float]:
    """Where joints stand [rad, m], by name."""
    movable = {follower.joint.name: follower.joint for follower in found.followers}
    values: dict[str, float] = {}
    for assignment in typed.fix:
        name, value = split_option("--fix", assignment, "=")
        joint = movable.get(name) or found.robot.joint(name)
        try:
            number = float(value)
        except ValueError:
            number = np.nan
        if not np.isfinite(number):
            raise InputError(f"--fix {assignment!r}: a number is expected, in degrees or mm")
        values[name] = number / 1000 if joint.kind == "prismatic" else float(np.deg2rad(number))
    return values


def _standing(typed: CellNew, cell: Cell, world: RobotInPlace) -> Cell:
    """The cell with the still things of a world, one of them its bin if that is said."""
    things = {thing.name: thing for thing in world.things}
    if typed.bin is not None:
        if typed.bin not in things:
            known = ", ".join(things) or "nothing"
            raise InputError(f"--bin {typed.bin!r}: no such thing in the world (there is {known})")
        cell = replace(cell, bin=box_around(things.pop(typed.bin)))
    return replace(
        cell,
        T_world_robot=world.T_world_robot,
        fixtures=tuple(
            in_pieces(thing, tolerance=typed.tolerance_mm / 1000, most=typed.pieces)
            for thing in things.values()
        ),
    )


def _bare(typed: CellNew, robot: Robot, flanges: tuple[str, ...], tools: tuple[Tool, ...]) -> Cell:
    """A cell with arms and tools; where everything else is comes later."""
    has_fingers = any(tool.fingers for tool in tools)
    part = read_part(find("parts", typed.part or (HELD if has_fingers else SUCKED)))
    chains = [
        tuple(joint.name for joint in robot.chain(flange) if joint.kind != "fixed")
        for flange in flanges
    ]
    arms = tuple(
        Arm(
            name=name,
            controller_id=name[0].upper(),
            flange=flange,
            joints=joints,
            axis_order=tuple(range(len(joints))),
            axis_signs=(1,) * len(joints),
            home=_middle(robot, joints),
            acceleration=np.full(len(joints), np.deg2rad(ACCELERATION_DEG)),
            tool=tool,
        )
        for name, flange, joints, tool in zip(
            ("right", "left"), flanges, chains, tools, strict=False
        )
    )
    size = np.array([0.2, 0.3, 0.05]) if has_fingers else np.array([0.3, 0.4, 0.1])
    return Cell(
        name=typed.name,
        robot=robot,
        T_world_robot=pose_from_rpy((0, 0, 0)),
        arms=arms,
        bin=Bin(pose_from_rpy((0, 0, 0)), size),
        scanner=ScannerMount(pose_from_rpy((0, 0, 1))),
        controller=controller_by(usual_link()),
        parts=(part,),
        policy=POLICIES["thorough"],
    )


def _middle(robot: Robot, joints: tuple[str, ...]) -> Any:
    lower, upper, _ = robot.limits(joints)
    return np.clip(np.zeros(len(joints)), lower, upper)

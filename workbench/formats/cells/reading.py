"""`cell.toml` to a cell: millimetres and degrees in the file, metres and radians inside."""

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.cells.devices import read_controller, read_localizer, read_scanner
from workbench.formats.cells.tools import read_tool
from workbench.formats.files.shipped import exists, find
from workbench.formats.files.toml_keys import Table, read_toml
from workbench.formats.meshes.solids import read_pose, read_solid
from workbench.formats.parts.reading import read_part
from workbench.formats.robots.dh import read_dh
from workbench.formats.robots.urdf import read_srdf, read_urdf
from workbench.model.cell import (
    ORDER_NAMES,
    Arm,
    Bin,
    Cell,
    Fixture,
    LocalizerChoice,
    Policy,
    PosesFolder,
    Tool,
)
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.robot import Link, Robot
from workbench.plugins.planner import planner_names
from workbench.plugins.robot_link import controller_by, usual_link

ARM_NAMES = ("right", "left")

MOST_PLACES = 400
"""On one pallet."""

ROUNDED = 1e-6
"""[rad] What four digits of a degree may put a home beyond the limit at which it stands."""

MOST_APPROVERS = 4


def cell_path(name: str | Path) -> Path:
    """The file of a cell; see `read_cell`.

    Raises:
        FileError: there is none.
    """
    place = find("robots", str(name))
    return place / "cell.toml" if place.is_dir() else place


def read_cell(name: str | Path) -> Cell:
    """A cell by name under `robots/`, or by the path of its folder or `cell.toml`.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    table = read_toml(cell_path(name))
    robot_table = table.table("robot")
    robot = _robot(robot_table)
    T_world_robot = read_pose(robot_table)
    robot_table.finish()
    mounted = [read_tool(tool) for tool in table.tables("tool")]
    table.once("tool.name", (tool.name for tool in mounted))
    tools = {tool.name: tool for tool in mounted}
    arms = tuple(_arm(arm, robot, tools) for arm in table.tables("arm"))
    names = [arm.name for arm in arms]
    if not arms or len(set(names)) != len(names):
        raise table.error("arm", "one or two [[arm]] tables with different names are needed")
    # Messages to the controller call an arm by its letter alone.
    table.once("arm.letter", (arm.letter for arm in arms))
    policy, approvers = _policy(table.table("policy")) if table.has("policy") else (Policy(), 1)
    cell = Cell(
        name=table.text("name"),
        robot=robot,
        T_world_robot=T_world_robot,
        arms=arms,
        bin=_bin(table.table("bin")),
        scanner=read_scanner(table.table("scanner")),
        controller=read_controller(table.table("controller"))
        if table.has("controller")
        else controller_by(usual_link()),
        parts=tuple(_part(table, name) for name in table.texts("parts")),
        fixtures=tuple(_fixture(fixture) for fixture in table.tables("fixture")),
        poses_folder=read_poses_folder(table.table("detections"))
        if table.has("detections")
        else None,
        localizer=read_localizer(table.table("localizer"))
        if table.has("localizer")
        else LocalizerChoice(),
        policy=policy,
        approvers=approvers,
    )
    if not cell.parts:
        raise table.error("parts", "names no part; at least one is needed")
    table.once("fixture.name", (fixture.name for fixture in cell.fixtures))
    names = [part.name for part in cell.parts]
    table.once("parts", names)
    if cell.poses_folder is not None and cell.poses_folder.part not in ("", *names):
        raise table.error("detections.part", f"is not one of {', '.join(names)}")
    table.finish()
    return cell


def part_folders(path: Path, new: Iterable[str] = ()) -> dict[str, Path]:
    """Where the parts of a cell file lie, by their names.

    Args:
        path: of the cell file.
        new: names of parts that are not in the file yet.

    Raises:
        FileError: the file, or that of a part, cannot be read.
    """
    table = read_toml(path)
    places = [_place(table, name) for name in table.texts("parts")]
    files = [place / "part.toml" if place.is_dir() else place for place in places]
    named = {read_toml(file).text("name"): file.parent for file in files}
    return named | {name: _place(table, name) for name in new if name not in named}


def _part(table: Table, name: str) -> Part:
    return read_part(_place(table, name))


def _place(table: Table, name: str) -> Path:
    """A part named in a cell file: a path beside it, or a name under `parts/`."""
    beside = table.path.parent / name
    try:
        return beside if exists(beside) else find("parts", name)
    except FileError as error:
        raise table.error("parts", str(error)) from None


def _robot(table: Table) -> Robot:
    folder = table.path.parent
    if table.has("dh"):
        robot = read_dh(table.table("dh"), folder.name)
    else:
        robot = read_urdf(
            folder / table.text("urdf"),
            collision=table.text("collision", "as_is", among=("as_is", "hull")),  # type: ignore[arg-type]
            hull_except=table.texts("hull_except", ()),
        )
    for name in table.texts("without_geometry", ()):
        if name not in {link.name for link in robot.links}:
            raise table.error("without_geometry", f"{name!r} is no link of the URDF")
        robot = replace(
            robot,
            links=tuple(Link(name) if link.name == name else link for link in robot.links),
        )
    if not table.has("srdf"):
        return robot
    srdf = folder / table.text("srdf")
    pairs = read_srdf(srdf)
    known = {link.name for link in robot.links} | {f"{arm}_tool" for arm in ARM_NAMES}
    for pair in sorted(pairs):
        for link in pair:
            if link not in known:
                raise FileError(srdf, f"names link {link!r}, which the URDF does not have")
    return replace(robot, disabled_pairs=robot.disabled_pairs | pairs)


def _arm(table: Table, robot: Robot, tools: dict[str, Tool]) -> Arm:
    name = table.text("name", among=ARM_NAMES)
    flange, tool = table.text("flange"), table.text("tool")
    mounted = _known_tool(table, "tool", tool, tools)
    names = table.texts("tools", (tool,))
    if tool not in names or len(set(names)) != len(names):
        raise table.error("tools", f"must hold {tool!r}, which the arm carries, and each once")
    try:
        joints = tuple(j.name for j in robot.chain(flange) if j.kind != "fixed")
    except InputError as error:
        raise table.error("flange", str(error)) from None
    count = len(joints)
    if count == 0:
        raise table.error("flange", f"no movable joint leads to {flange!r}")
    axes = table.numbers("axes", count, list(range(1, count + 1))).astype(int)
    if sorted(axes.tolist()) != list(range(1, count + 1)):
        raise table.error("axes", f"must hold each of 1 to {count} once: the axis of each joint")
    wire_order = np.argsort(axes)
    signs = table.numbers("signs", count, [1] * count)
    if not np.all(np.abs(signs) == 1):
        raise table.error("signs", "may hold 1 and -1 only")
    home = np.empty(count)
    home[wire_order] = np.deg2rad(table.numbers("home_deg", count, low=-720, high=720)) * signs
    _check_home(table, robot, joints, home)
    arm = Arm(
        name=name,
        letter=table.text("letter", name[0].upper()),
        flange=flange,
        joints=joints,
        wire_order=tuple(int(k) for k in wire_order),
        wire_signs=tuple(int(sign) for sign in signs),
        home=home,
        acceleration=_acceleration(table, count),
        tool=mounted,
        Ts_world_place=tuple(T for place in table.tables("place") for T in _places(place)),
        keeps_parts=table.flag("keeps_parts", False),
        tools=tuple(_known_tool(table, "tools", one, tools) for one in names),
    )
    table.finish()
    if not re.fullmatch(r"[A-Z]", arm.letter):
        raise table.error("letter", f"{arm.letter!r} is not one capital letter")
    return arm


def _known_tool(table: Table, key: str, name: str, tools: dict[str, Tool]) -> Tool:
    if name not in tools:
        raise table.error(key, f"{name!r} is not one of {', '.join(tools) or 'no tools'}")
    return tools[name]


def _places(table: Table) -> tuple[pin.SE3, ...]:
    """One pose, or those of a `grid` of columns along its x and rows along its y."""
    T = read_pose(table)
    columns, rows = table.numbers("grid", 2, [1, 1], low=1, high=100).astype(int).tolist()
    pitch = table.numbers("pitch_mm", 2, [0, 0], low=-5000, high=5000) / 1000
    table.finish()
    if columns * rows > MOST_PLACES:
        raise table.error("grid", f"{columns * rows} places, {MOST_PLACES} are allowed")
    if (columns > 1 and pitch[0] == 0) or (rows > 1 and pitch[1] == 0):
        raise table.error("pitch_mm", "must not be 0 where there are several places")
    return tuple(
        T * pin.SE3(np.eye(3), np.array([column * pitch[0], row * pitch[1], 0.0]))
        for row in range(rows)
        for column in range(columns)
    )


def _acceleration(table: Table, count: int) -> Floats:
    each = table.number("acceleration_deg", 600, low=1, high=100_000)
    return np.full(count, np.deg2rad(each))


def _check_home(table: Table, robot: Robot, joints: tuple[str, ...], home: Floats) -> None:
    lower, upper, _ = robot.limits(joints)
    for joint, value, low, high in zip(joints, home, lower, upper, strict=True):
        if not low - ROUNDED <= value <= high + ROUNDED:
            raise table.error(
                "home_deg",
                f"{np.rad2deg(value):.1f} for {joint} is outside {np.rad2deg(low):.1f} to "
                f"{np.rad2deg(high):.1f}",
            )


def _bin(table: Table) -> Bin:
    found = Bin(
        read_pose(table),
        table.numbers("size_mm", 3, low=10, high=5000) / 1000,
        table.number("wall_mm", 3, low=0.5, high=100) / 1000,
    )
    table.finish()
    return found


def read_poses_folder(table: Table) -> PosesFolder:
    """The folder `path`, beside the cell file when it is not absolute."""
    table.text("source", "folder", among=("folder",))
    path = str((table.path.parent / table.text("path")).resolve())
    folder = PosesFolder(path, table.text("part", "", empty=True))
    table.finish()
    return folder


def _fixture(table: Table) -> Fixture:
    name = table.text("name")
    fixture = Fixture(
        name,
        read_pose(table),
        tuple(read_solid(solid, prefix=f"{name}_") for solid in table.tables("solid")),
    )
    table.finish()
    return fixture


def _policy(table: Table) -> tuple[Policy, int]:
    """The policy, and how many people have to approve."""
    usual = Policy()

    def length(key: str, default: float, high: float) -> float:
        return table.number(key, default * 1000, low=0, high=high) / 1000

    policy = Policy(
        margin=length("margin_mm", usual.margin, 1000),
        near_margin=length("near_margin_mm", usual.near_margin, 1000),
        self_margin=table.number("self_margin_mm", usual.self_margin * 1000, low=-20, high=1000)
        / 1000,
        lift_length=length("lift_length_mm", usual.lift_length, 2000),
        lift_lean=float(
            np.deg2rad(table.number("lift_lean_deg", np.rad2deg(usual.lift_lean), low=0, high=80))
        ),
        free_points=table.whole("free_points", usual.free_points, low=2, high=200),
        straight_points=table.whole("straight_points", usual.straight_points, low=2, high=200),
        speed=table.number("speed", usual.speed, low=0.01, high=1),
        zone=table.number("zone", usual.zone, low=0, high=0.45),
        threshold=length("threshold_mm", usual.threshold, 10_000),
        planner=table.text("planner", usual.planner, among=planner_names()),
        iterations=table.whole("iterations", usual.iterations, low=1, high=1_000_000),
        seconds=table.number("seconds", usual.seconds, low=0.01, high=24 * 3600),
        order=table.text("order", usual.order, among=ORDER_NAMES),  # type: ignore[arg-type]
        metric=table.number("metric", usual.metric, low=0.05, high=1),
        approval_minutes=table.number(
            "approval_minutes", usual.approval_minutes, low=0.1, high=24 * 60
        ),
    )
    approvers = table.whole("approvers", 1, low=1, high=MOST_APPROVERS)
    table.finish()
    return policy, approvers

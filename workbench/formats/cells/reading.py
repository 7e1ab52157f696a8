"""`cell.toml` to a cell: millimetres and degrees in the file, metres and radians inside."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.cells.arms import read_arms
from workbench.formats.cells.devices import (
    read_controller,
    read_localizer,
    read_scanner,
    refused_at,
)
from workbench.formats.cells.places import check_kinds, read_bins, read_stations
from workbench.formats.cells.recipes import check_recipes, read_recipes
from workbench.formats.cells.tools import check_grasp_tcps, check_slots
from workbench.formats.files.shipped import exists, find
from workbench.formats.files.toml_keys import Table, read_toml
from workbench.formats.meshes.solids import read_pose, read_solid
from workbench.formats.parts.reading import read_part
from workbench.formats.robots.arm_scanners import read_arm_scanner
from workbench.formats.robots.dh import read_dh
from workbench.formats.robots.urdf import read_srdf, read_urdf
from workbench.model.cell import (
    LIFT_NAMES,
    MOST_PICKS,
    ORDER_NAMES,
    Arm,
    Cell,
    Fixture,
    LiftName,
    Policy,
    ScannerMount,
)
from workbench.model.derived.by_view import with_view
from workbench.model.derived.policies import MOST_STIRS, POLICIES, picks_problem, stir_problem
from workbench.model.derived.speed_limits import effective_mass, limits_speed
from workbench.model.errors import FileError, InputError
from workbench.model.part import Part
from workbench.model.robot import Link, Robot
from workbench.model.scan import LocalizerChoice, PosesFolder
from workbench.model.tools.slots import standing_name
from workbench.plugins.misfit import link_problem
from workbench.plugins.planner import planner_names
from workbench.plugins.robot_link import (
    controller_by,
    link_named,
    usual_link,
)
from workbench.plugins.scanner import scanner_of

MOST_APPROVERS = 4

SPEED_KEYS = ("tcp_speed", "point_speed", "held_speed")
"""Largest speeds of a policy, which a file has in mm/s."""

SIDE_TOOLS = {"right_tool", "left_tool"}
"""The tools of a robot with two arms by their usual names, as an SRDF calls them."""


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
    arms = read_arms(table, robot)
    robot = _without_pairs(robot_table, robot, arms)
    robot_table.finish()
    policy, approvers = _policy(table.table("policy")) if table.has("policy") else (Policy(), 1)
    fixtures = tuple(_fixture(fixture) for fixture in table.tables("fixture"))
    called, (box, *other_bins) = table.text("name"), read_bins(table)
    # The page and world files know the other bins, and tools in their slots, as fixtures.
    names = [fixture.name for fixture in fixtures]
    names += [standing_name(arm, slot.tool) for arm in arms for slot in arm.tool_slots]
    table.once("fixture.name", names + [f"bin {each.name}" for each in (box, *other_bins)])
    scanner, arms = _scanner(table.table("scanner"), robot, T_world_robot, arms)
    cell = Cell(
        name=called,
        robot=robot,
        T_world_robot=T_world_robot,
        arms=arms,
        bin=box,
        scanner=scanner,
        controller=read_controller(table.table("controller"))
        if table.has("controller")
        else controller_by(usual_link()),
        parts=tuple(_part(table, name) for name in table.texts("parts")),
        fixtures=fixtures,
        poses_folder=read_poses_folder(table.table("detections"))
        if table.has("detections")
        else None,
        localizer=read_localizer(table.table("localizer"))
        if table.has("localizer")
        else LocalizerChoice(),
        policy=policy,
        approvers=approvers,
        stations=read_stations(table, fixtures),
        recipes=read_recipes(table),
        other_bins=tuple(other_bins),
    )
    with refused_at(table, "controller.protocol"):
        link_named(cell.controller.link).check(cell)
        if problem := link_problem(cell):
            raise InputError(problem)
    _check_speeds(table, cell)
    with refused_at(table, "scanner.source"):
        scanner_of(cell)
    if not cell.parts:
        raise table.error("parts", "names no part; at least one is needed")
    names = [part.name for part in cell.parts]
    table.once("parts", names)
    check_grasp_tcps(table, cell)
    check_slots(table, cell)
    if cell.poses_folder is not None and cell.poses_folder.part not in ("", *names):
        raise table.error("detections.part", f"is not one of {', '.join(names)}")
    for arm in cell.arms:
        check_kinds(table, arm.part_places, names)
    check_recipes(table, cell)
    _check_views(table, cell)
    table.finish()
    return with_view(cell, "")


def _check_views(table: Table, cell: Cell) -> None:
    """Whether each view names a bin, and each bin is seen, where an arm carries the scanner."""
    if cell.scanner.on_arm is None:
        return
    views, bins = cell.scanner.on_arm.views, [box.name for box in cell.bins]
    for view in views:
        if view.bin and view.bin not in bins:
            known = ", ".join(bins) if cell.other_bins else "none: the cell has a single bin"
            problem = f"{view.bin!r} of view {view.name!r} is not one of {known}"
            raise table.error("scanner.on_arm.view.bin", problem)
    for name in bins:
        if not any(view.bin in ("", name) for view in views):
            raise table.error("scanner.on_arm.view", f"no view sees bin {name!r}")


def _scanner(
    table: Table, robot: Robot, T_world_robot: pin.SE3, arms: tuple[Arm, ...]
) -> tuple[ScannerMount, tuple[Arm, ...]]:
    """The scanner, and the arms, of which the one that carries it waits at its view."""
    if not table.has("on_arm"):
        return read_scanner(table), arms
    carrier = read_arm_scanner(table.table("on_arm"), robot, T_world_robot, arms)
    waiting = (replace(a, home=carrier.view.q) if a.name == carrier.arm else a for a in arms)
    return read_scanner(table, carrier), tuple(waiting)


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
    """A part named in a cell file: a path next to it, or a name under `parts/`."""
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
    return robot


def _without_pairs(table: Table, robot: Robot, arms: tuple[Arm, ...]) -> Robot:
    """The robot with the pairs of its SRDF, if it has one, in which tools are called by arms."""
    if not table.has("srdf"):
        return robot
    srdf = table.path.parent / table.text("srdf")
    pairs = read_srdf(srdf)
    tools = {f"{arm.name}_tool" for arm in arms}
    if tools <= SIDE_TOOLS:
        # The SRDF of a robot with two arms also serves a cell with one of them.
        tools = SIDE_TOOLS
    links = {link.name for link in robot.links} | {f"{arm.name}_scanner" for arm in arms}
    for pair in sorted(pairs):
        for name in pair:
            if name not in links | tools:
                raise FileError(
                    srdf,
                    f"names link {name!r}, which the URDF does not have; the tool of an arm is "
                    f"called {' or '.join(sorted(tools))}",
                )
    return replace(robot, disabled_pairs=robot.disabled_pairs | pairs)


def read_poses_folder(table: Table) -> PosesFolder:
    """The folder `path`, next to the cell file when it is not absolute."""
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


def _lifts(table: Table, usual: tuple[LiftName, ...]) -> tuple[LiftName, ...]:
    """Names of lifts, at least one, none twice."""
    names = table.texts("lifts", usual)
    known = ", ".join(LIFT_NAMES)
    for name in names:
        if name not in LIFT_NAMES:
            raise table.error("lifts", f"{name!r:.40} is none of {known}")
    if not names or len(set(names)) < len(names):
        raise table.error("lifts", f"one or more of {known} are expected, each once")
    return names  # type: ignore[return-value]


def _speed(table: Table, key: str) -> float | None:
    """A largest speed [m/s]; None where the file says none."""
    speed = table.number(key, 1000.0, low=1, high=50_000) / 1000
    return speed if table.has(key) else None


def _check_speeds(table: Table, cell: Cell) -> None:
    """Refuse limits of speed that nothing would keep, and to stir where nobody could slowly."""
    for arm in cell.arms if cell.policy.contact_energy is not None else ():
        if effective_mass(cell, arm, False) is None:
            lacks = "moving_mass_kg" if arm.moving_mass is None else f"mass_g of {arm.tool.name}"
            raise table.error("policy.contact_energy_j", f"arm {arm.name} has no {lacks}")
    if cell.policy.stirs and (problem := stir_problem(cell)):
        raise table.error("policy.stirs", problem)
    if not limits_speed(cell):
        return
    keys = (f"{key}_mm" for key in SPEED_KEYS if getattr(cell.policy, key) is not None)
    other = "manual_speed" if cell.policy.manual_speed else "contact_energy_j"
    key = f"policy.{next(keys, other)}"
    if not cell.controller.motion.takes_share:
        link = cell.controller.link
        raise table.error(key, f"robot link {link} does not send times: it keeps no limit of speed")
    for arm in cell.arms:
        if arm.jerk is not None:
            raise table.error(
                key, f"arm {arm.name} has jerk_deg: a cell limits the speed of points or jerk"
            )
    slower = ("point_speed", cell.policy.point_speed), ("tcp_speed", cell.policy.tcp_speed)
    for name, speed in slower:
        held = cell.policy.held_speed
        if held is not None and speed is not None and held > speed:
            raise table.error("policy.held_speed_mm", f"is above {name}_mm: a part makes it slower")


def _policy(table: Table) -> tuple[Policy, int]:
    """The policy, and how many people have to approve."""
    usual = POLICIES[table.text("emptying", "as-needed", among=tuple(POLICIES))]

    def length(key: str, default: float, high: float) -> float:
        return table.number(key, default * 1000, low=0, high=high) / 1000

    air = length("least_air_mm", 0.0, 1000)
    energy = table.number("contact_energy_j", 1.0, low=0.001, high=10_000)
    lifts = _lifts(table, usual.lifts)
    # Whoever names some lifts, and nothing else, wants no others.
    is_limited = set(lifts) != set(usual.lifts) and set(lifts) != set(LIFT_NAMES)
    is_limited = is_limited and not table.has("emptying")
    policy = Policy(
        margin=length("margin_mm", usual.margin, 1000),
        near_margin=length("near_margin_mm", usual.near_margin, 1000),
        self_margin=table.number("self_margin_mm", usual.self_margin * 1000, low=-20, high=1000)
        / 1000,
        lift_length=length("lift_length_mm", usual.lift_length, 2000),
        lift_lean=float(
            np.deg2rad(table.number("lift_lean_deg", np.rad2deg(usual.lift_lean), low=0, high=80))
        ),
        sink=length("sink_mm", usual.sink, 100),
        release=length("release_mm", usual.release, 1000),
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
        lifts=lifts,
        as_needed=usual.as_needed and not is_limited,
        pair_gap=length("pair_gap_mm", usual.pair_gap, 1000),
        least_air=air if table.has("least_air_mm") else usual.least_air,
        picks=table.whole("picks", usual.picks, low=1, high=MOST_PICKS),
        manual_speed=table.flag("manual_speed", False),
        retry_without_scan=table.flag("retry_without_scan", False),
        contact_energy=energy if table.has("contact_energy_j") else None,
        stirs=table.whole("stirs", usual.stirs, low=0, high=MOST_STIRS),
        stir_speed=table.number("stir_speed_mm", usual.stir_speed * 1000, low=10, high=250) / 1000,
        slot_speed=table.number("slot_speed_mm", usual.slot_speed * 1000, low=10, high=250) / 1000,
        **{key: _speed(table, f"{key}_mm") for key in SPEED_KEYS},
    )
    if problem := picks_problem(policy):
        raise table.error("picks", problem)
    approvers = table.whole("approvers", 1, low=1, high=MOST_APPROVERS)
    table.finish()
    return policy, approvers

"""The arms of a cell file with the tools that they carry."""

import re

import numpy as np

from workbench.formats.cells.places import read_places
from workbench.formats.cells.tools import read_slots, read_tool
from workbench.formats.files.toml_keys import Table, quote
from workbench.model.cell import ARM_NAME, Arm, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.plan import STRATEGY_WORDS
from workbench.model.robot import AxisMapping, Robot

ROUNDED = 1e-6
"""[rad] What four digits of a degree may put a home beyond the limit at which it stands."""


def read_arms(table: Table, robot: Robot) -> tuple[Arm, ...]:
    """The arms of a cell, one or more, with their tools.

    Args:
        table: of the whole file.
        robot: whose chains they are.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    mounted = [read_tool(tool) for tool in table.tables("tool")]
    table.once("tool.name", (tool.name for tool in mounted))
    tools = {tool.name: tool for tool in mounted}
    arms = tuple(_arm(arm, robot, tools) for arm in table.tables("arm"))
    if not arms:
        raise table.error("arm", "is missing; at least one [[arm]] table is expected")
    known: dict[str, str] = {}
    for arm in arms:
        # People do not tell names apart by capitals, nor do all file systems.
        if (other := known.get(arm.name.lower())) is not None:
            raise table.error(
                "arm.name",
                f"{arm.name!r} is there beside {other!r}; names that differ in more than capitals "
                "are expected",
            )
        known[arm.name.lower()] = arm.name
    carries: dict[str, str] = {}
    for arm in arms:
        for joint in arm.joints:
            if (other := carries.get(joint)) is not None:
                raise table.error(
                    "arm.flange",
                    f"{other!r} and {arm.name!r} both hang on {joint}: arms that share a joint "
                    "cannot move apart; make it fixed in the URDF",
                )
            carries[joint] = arm.name
    # Messages to the controller call an arm by this alone.
    table.once("arm.controller_id", (arm.controller_id for arm in arms))
    return arms


def _arm(table: Table, robot: Robot, tools: dict[str, Tool]) -> Arm:
    name = _name(table)
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
    axes = table.wholes("axes", count, list(range(1, count + 1)))
    if sorted(axes) != list(range(1, count + 1)):
        raise table.error("axes", f"must hold each of 1 to {count} once: the axis of each joint")
    axis_order = np.argsort(axes)
    signs = table.numbers("signs", count, [1] * count)
    if not np.all(np.abs(signs) == 1):
        raise table.error("signs", "may hold 1 and -1 only")
    mapping = _mapping(table, [robot.joint(joints[k]).kind == "prismatic" for k in axis_order])
    shown = np.deg2rad(table.numbers("home_deg", count, low=-720, high=720))
    home = np.empty(count)
    home[axis_order] = (shown if mapping is None else mapping.from_controller(shown)) * signs
    _check_home(table, robot, joints, home)
    of_tool, of_part, place_names = read_places(table)
    id_key = table.current_name("controller_id", "letter")
    arm = Arm(
        name=name,
        controller_id=table.text(id_key, name[0].upper()),
        flange=flange,
        joints=joints,
        axis_order=tuple(int(k) for k in axis_order),
        axis_signs=tuple(int(sign) for sign in signs),
        home=home,
        acceleration=_acceleration(table, count),
        tool=mounted,
        Ts_world_place=of_tool,
        part_places=of_part,
        place_names=place_names,
        keeps_parts=table.flag("keeps_parts", False),
        needs_roll=table.flag("needs_roll", False),
        passes_parts_on=table.flag("passes_parts_on", False),
        jerk=_jerk(table, count),
        tools=tuple(_known_tool(table, "tools", tool_name, tools) for tool_name in names),
        moving_mass=_moving_mass(table),
        tool_slots=read_slots(table, names),
        mapping=mapping,
    )
    table.finish()
    if not re.fullmatch(r"[A-Z]", arm.controller_id):
        raise table.error(id_key, f"{arm.controller_id!r} is not one capital letter")
    if arm.keeps_parts and arm.passes_parts_on:
        raise table.error("passes_parts_on", "parts that are passed on do not stay: keeps_parts")
    if not arm.keeps_parts and any(place.pallet for place in arm.part_places):
        raise table.error(
            "keeps_parts", "must be true where places have layers: what lies beneath has to stay"
        )
    return arm


def _mapping(table: Table, slides: list[bool]) -> AxisMapping | None:
    """What the controller shows, by the axes in its order, of which some slide."""
    count = len(slides)
    coupling = table.rows("axis_coupling", count, np.eye(count).tolist())
    if len(coupling) != count:
        raise table.error("axis_coupling", f"{count} rows are expected, one for each axis")
    offsets = table.numbers("axis_offsets", count, [0] * count, low=-9999, high=9999)
    if not table.has("axis_coupling") and not table.has("axis_offsets"):
        return None
    mapping = AxisMapping(coupling, offsets * np.where(slides, 0.001, np.pi / 180))
    if problem := mapping.problem(slides):
        raise table.error("axis_coupling", problem)
    return mapping


def _name(table: Table) -> str:
    name = table.text("name", like=ARM_NAME)
    if not re.fullmatch(ARM_NAME, name):
        raise table.error(
            "name",
            f"{quote(name)} is no name of an arm: 1 to 40 letters, digits, - and _ are expected, "
            "the first of them no -",
        )
    if name.lower() in STRATEGY_WORDS:
        words = ", ".join(STRATEGY_WORDS)
        raise table.error("name", f"{name!r} names a strategy; any name but {words} is expected")
    return name


def _known_tool(table: Table, key: str, name: str, tools: dict[str, Tool]) -> Tool:
    if name not in tools:
        raise table.error(key, f"{name!r} is not one of {', '.join(tools) or 'no tools'}")
    return tools[name]


def _acceleration(table: Table, count: int) -> Floats:
    each = table.number("acceleration_deg", 600, low=1, high=100_000)
    return np.full(count, np.deg2rad(each))


def _moving_mass(table: Table) -> float | None:
    mass = table.number("moving_mass_kg", 1.0, low=0.01, high=10_000)
    return mass if table.has("moving_mass_kg") else None


def _jerk(table: Table, count: int) -> Floats | None:
    each = table.number("jerk_deg", 1e6, low=10, high=100_000_000)
    return np.full(count, np.deg2rad(each)) if table.has("jerk_deg") else None


def _check_home(table: Table, robot: Robot, joints: tuple[str, ...], home: Floats) -> None:
    lower, upper, _ = robot.limits(joints)
    for joint, value, low, high in zip(joints, home, lower, upper, strict=True):
        if not low - ROUNDED <= value <= high + ROUNDED:
            raise table.error(
                "home_deg",
                f"{np.rad2deg(value):.1f} for {joint} is outside {np.rad2deg(low):.1f} to "
                f"{np.rad2deg(high):.1f}",
            )

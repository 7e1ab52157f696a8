"""A tool of a cell file: by its solids and fingers, or by its kind and a few numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.formats.cells.devices import read_options, refused_at
from workbench.formats.cells.places import read_direction
from workbench.formats.files.toml_documents import number, numbers, text
from workbench.formats.files.toml_keys import Table
from workbench.formats.meshes.solids import read_pose, read_solid
from workbench.model.cell import Cell, Finger, Tool
from workbench.model.geometry import Floats, Mesh, Solid, transform
from workbench.model.load import load_problem
from workbench.model.messages.message import HELD_BODY
from workbench.model.robot import Tcp, ToolSlot
from workbench.plugins.found import load, names
from workbench.plugins.tool import made_tool

MOST_FORCE = 1e5
"""[N]"""

MOST_MASS = 1e6
"""[g]"""

MOST_TCPS = 8

NO_OUTPUT, MOST_OUTPUT = -1, 7
"""Digital outputs of a controller count from 0; of the first, that of the link's options."""

LOAD_KEYS = ("mass_g", "centre_of_gravity_mm", "inertia_kgm2")
"""Keys of every tool, of a kind or not."""

UNMODELLED_WITHIN = 0.1
"""[m] This far around its solids a tool may have parts that nobody has modelled."""

TENSOR = ((0, 3, 4), (3, 1, 5), (4, 5, 2))
"""Where xx, yy, zz, xy, xz and yz stand in a matrix of inertia."""


def read_tool(table: Table) -> Tool:
    """The table `[[tool]]`; see `plugins.tool` for kinds."""
    if table.has("kind"):
        kind, name = table.text("kind", among=names("workbench.tools")), table.text("name")
        with refused_at(table, "kind"):
            tool = made_tool(kind, name, read_options(table, load("workbench.tools", kind).Options))
        tool = _with_load(table, tool)
        table.finish()
        return tool
    first, *others = _read_tcps(table)
    fingers: list[Finger] = []
    for finger in table.tables("finger"):
        direction = finger.numbers("opens_along", 3)
        if abs(float(np.linalg.norm(direction)) - 1.0) > 1e-6:
            raise finger.error("opens_along", "must be a unit vector")
        fingers.append(Finger(read_solid(finger), direction))
    low, high = table.numbers("stroke_mm", 2, [0, 0], low=0, high=1000) / 1000
    if fingers and not low < high:
        raise table.error("stroke_mm", "must be [smallest, largest] opening")
    tool = Tool(
        name=table.text("name"),
        T_flange_tcp=first.T_flange_tcp,
        body=tuple(read_solid(solid) for solid in table.tables("body")),
        fingers=tuple(fingers),
        stroke=(float(low), float(high)),
        press=table.number("press_mm", 1.5, low=0, high=50) / 1000,
        force=table.number("force_n", 0.0, low=0.0, high=MOST_FORCE) or None,
    )
    if any(solid.name.startswith(HELD_BODY) for solid in tool.body):
        raise table.error("body", f"no solid may be called {HELD_BODY}, as what a hand drops back")
    if not tool.body and not tool.fingers:
        raise table.error("body", "is missing; [[tool.body]] or [[tool.finger]] is expected")
    if first.name:
        tool = replace(tool, tcps=(first, *others), tcp=first.name)
        _check_tcps(table, tool)
    tool = _with_load(table, tool)
    table.finish()
    return tool


def _read_tcps(table: Table) -> list[Tcp]:
    """The TCPs of a tool: one, which may have a name, or several, which need names."""
    if not table.is_array("tcp"):
        return [read_tcp(table.table("tcp"))]
    tables = list(table.tables("tcp"))
    if not 1 <= len(tables) <= MOST_TCPS:
        raise table.error("tcp", f"{len(tables)} TCPs, 1 to {MOST_TCPS} are expected")
    tcps = [read_tcp(each, is_one_of_several=len(tables) > 1) for each in tables]
    table.once("tcp.name", (tcp.name for tcp in tcps))
    return tcps


def read_tcp(table: Table, *, is_one_of_several: bool = False) -> Tcp:
    """The table of one TCP.

    Raises:
        FileError: names the key that is wrong.
    """
    name, touches = table.text("name", "", empty=True), table.texts("touches", ())
    output = table.whole("output", NO_OUTPUT, low=NO_OUTPUT, high=MOST_OUTPUT)
    if not name and (is_one_of_several or touches or output != NO_OUTPUT):
        problem = "is missing; each of several TCPs needs a name, and one with touches or output"
        raise table.error("name", problem)
    tcp = Tcp(name, read_pose(table), touches, None if output == NO_OUTPUT else output)
    table.finish()
    return tcp


def _check_tcps(table: Table, tool: Tool) -> None:
    """Whether named TCPs are at the tool, and touch with solids that it has."""
    if tool.fingers and len(tool.tcps) > 1:
        problem = "several TCPs are for tools without fingers, such as suction cups"
        raise table.error("tcp", problem)
    names = [solid.name for solid in (*tool.body, *(finger.solid for finger in tool.fingers))]
    for tcp in tool.tcps:
        if len(tool.tcps) > 1 and (problem := _far_from(tool, tcp.T_flange_tcp.translation)):
            raise table.error("tcp", f"{tcp.name!r} {problem}")
        for solid in tcp.touches:
            if solid not in names:
                problem = f"{tcp.name!r} touches {solid!r}, the tool has {', '.join(names)}"
                raise table.error("tcp", problem)


def read_slots(table: Table, tools: Sequence[str]) -> tuple[ToolSlot, ...]:
    """Where the tools of an arm stand while it does not carry them.

    Args:
        table: of the arm.
        tools: the names of all that it can carry.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    slots: list[ToolSlot] = []
    for slot in table.tables("tool_slot"):
        tool, T_world_flange = slot.text("tool"), read_pose(slot)
        if tool not in tools:
            problem = f"{tool!r} is not one of {', '.join(tools)}, which the arm can carry"
            raise slot.error("tool", problem)
        x, y, z = (float(value) for value in -T_world_flange.rotation[:, 2])
        leave = np.array(read_direction(slot, "leave", (x, y, z)))
        distance = slot.number("leave_mm", 100, low=1, high=1000) / 1000
        fixture = slot.text("fixture", "", empty=True)
        slot.finish()
        slots.append(ToolSlot(tool, T_world_flange, leave, distance, fixture))
    table.once("tool_slot.tool", (slot.tool for slot in slots))
    return tuple(slots)


def check_slots(table: Table, cell: Cell) -> None:
    """Refuse a slot in a fixture that the cell does not have.

    Raises:
        FileError: names the fixture and those there are.
    """
    known = [fixture.name for fixture in cell.fixtures]
    for slot in (slot for arm in cell.arms for slot in arm.tool_slots):
        if slot.fixture and slot.fixture not in known:
            problem = f"{slot.fixture!r} is not one of {', '.join(known) or 'no fixtures'}"
            raise table.error("arm.tool_slot.fixture", problem)


def slot_lines(slot: ToolSlot) -> Iterator[str]:
    """The table `[[arm.tool_slot]]`, line by line."""
    T = slot.T_world_flange
    yield from ("", "[[arm.tool_slot]]", f"tool = {text(slot.tool)}")
    yield f"position_mm = {numbers(np.round(T.translation * 1000, 4))}"
    yield f"rpy_deg = {numbers(np.round(np.rad2deg(pin.rpy.matrixToRpy(T.rotation)), 6))}"
    yield f"leave = {numbers(np.round(slot.leave, 9))}"
    yield f"leave_mm = {number(slot.distance * 1000)}"
    if slot.fixture:
        yield f"fixture = {text(slot.fixture)}"


def check_grasp_tcps(table: Table, cell: Cell) -> None:
    """Refuse grasps for a TCP that no tool has of those that they may be used with.

    Raises:
        FileError: names the grasp, its part, and the TCPs that there are.
    """
    tools = {tool.name: tool for arm in cell.arms for tool in (arm.tool, *arm.tools)}
    every = [(part, grasp) for part in cell.parts for grasp in part.library.grasps]
    for part, grasp in every:
        usable = [tool for tool in tools.values() if grasp.tool in ("", tool.name)]
        known = {tcp.name: tcp for tool in usable for tcp in tool.tcps}
        if usable and grasp.tcp and grasp.tcp not in known:
            there = f"tools have {', '.join(known)}" if known else "no tool names its TCP"
            problem = f"grasp {grasp.name!r} of {part.name} is for TCP {grasp.tcp!r}; {there}"
            raise table.error("parts", problem)


def _with_load(table: Table, tool: Tool) -> Tool:
    """The tool with what its table says of mass, centre of gravity and inertia."""
    mass = table.number("mass_g", 0.0, low=0.0, high=MOST_MASS) / 1000
    nothing = [0, 0, 0]
    centre = table.numbers("centre_of_gravity_mm", 3, nothing, low=-1e4, high=1e4) / 1000
    moments = table.numbers("inertia_kgm2", (3, 6), nothing, low=-1e3, high=1e3)
    if table.has("mass_g") and not mass:
        raise table.error("mass_g", "more than 0 is expected")
    for key in LOAD_KEYS[1:]:
        if table.has(key) and not mass:
            raise table.error("mass_g", f"is missing; {key} says nothing without it")
    if not mass:
        return tool
    if problem := _far_from(tool, centre):
        raise table.error("centre_of_gravity_mm", problem)
    inertia = np.append(moments, nothing)[list(map(list, TENSOR))]
    if problem := load_problem(mass, np.zeros(3), inertia):
        raise table.error("inertia_kgm2", problem)
    low, high = _box_of(tool)
    # Further than this from each other no two points of the tool are.
    most = mass * float(np.linalg.norm(high - low) + 2 * UNMODELLED_WITHIN) ** 2
    if float(np.abs(inertia).max()) > most:
        raise table.error(
            "inertia_kgm2",
            f"is more than a tool of {mass * 1000:g} g and this size can have, "
            f"{most:.2g} kg m2: is it in another unit?",
        )
    return replace(
        tool,
        mass=mass,
        centre_of_gravity=centre if table.has("centre_of_gravity_mm") else None,
        inertia=inertia if table.has("inertia_kgm2") else None,
    )


def _far_from(tool: Tool, point: Floats) -> str:
    """Why a point (3,) [m] in the flange's frame does not belong to a tool; empty where it may."""
    low, high = _box_of(tool)
    if np.all((point >= low - UNMODELLED_WITHIN) & (point <= high + UNMODELLED_WITHIN)):
        return ""
    return (
        f"lies more than {UNMODELLED_WITHIN * 1000:g} mm outside of the tool, which goes from "
        f"{_mm(low)} to {_mm(high)} mm in the flange's frame"
    )


def _box_of(tool: Tool) -> tuple[Floats, Floats]:
    """The corners (3,) [m] of a box in the flange's frame that the tool is in."""
    corners = [np.zeros((1, 3))]
    for solid in (*tool.body, *(finger.solid for finger in tool.fingers)):
        corners.append(_points_of(solid))
    points = np.concatenate(corners)
    return points.min(axis=0), points.max(axis=0)


def _points_of(solid: Solid) -> Floats:
    """Points (n, 3) [m] whose box holds a solid of a tool."""
    T, shape = solid.T_owner_shape, solid.shape
    if isinstance(shape, Mesh):
        return transform(T, shape.points)
    far = solid.reach - float(np.linalg.norm(T.translation))
    return T.translation + far * np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])


def _mm(point: Floats) -> str:
    return ", ".join(f"{1000 * value + 0.0:.0f}" for value in point)

"""A tool of a cell file: by its solids and fingers, or by its kind and a few numbers."""

from dataclasses import replace

import numpy as np

from workbench.formats.cells.devices import read_options, refused_at
from workbench.formats.files.toml_keys import Table
from workbench.formats.meshes.solids import read_pose, read_solid
from workbench.model.cell import Finger, Tool
from workbench.model.geometry import Floats, Mesh, Solid
from workbench.model.load import load_problem
from workbench.plugins.found import load, names
from workbench.plugins.tool import made_tool

MOST_FORCE = 1e5
"""[N]"""

MOST_MASS = 1e6
"""[g]"""

LOAD_KEYS = ("mass_g", "centre_of_gravity_mm", "inertia_kgm2")
"""Keys of every tool, of a kind or not."""

AROUND = 0.1
"""[m] This far beside its solids a tool may have parts that nobody has modelled."""

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
    tcp = table.table("tcp")
    T_flange_tcp = read_pose(tcp)
    tcp.finish()
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
        T_flange_tcp=T_flange_tcp,
        body=tuple(read_solid(solid) for solid in table.tables("body")),
        fingers=tuple(fingers),
        stroke=(float(low), float(high)),
        press=table.number("press_mm", 1.5, low=0, high=50) / 1000,
        force=table.number("force_n", 0.0, low=0.0, high=MOST_FORCE) or None,
    )
    if not tool.body and not tool.fingers:
        raise table.error("body", "is missing; [[tool.body]] or [[tool.finger]] is expected")
    tool = _with_load(table, tool)
    table.finish()
    return tool


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
    low, high = _box_of(tool)
    if np.any((centre < low - AROUND) | (centre > high + AROUND)):
        raise table.error(
            "centre_of_gravity_mm",
            f"lies more than {AROUND * 1000:g} mm beside the tool, which goes from "
            f"{_mm(low)} to {_mm(high)} mm in the flange's frame",
        )
    inertia = np.append(moments, nothing)[list(map(list, TENSOR))]
    if problem := load_problem(mass, np.zeros(3), inertia):
        raise table.error("inertia_kgm2", problem)
    # Further than this from each other no two points of the tool are.
    most = mass * float(np.linalg.norm(high - low) + 2 * AROUND) ** 2
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
        return shape.points @ T.rotation.T + T.translation
    far = solid.reach - float(np.linalg.norm(T.translation))
    return T.translation + far * np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])


def _mm(point: Floats) -> str:
    return ", ".join(f"{1000 * value + 0.0:.0f}" for value in point)

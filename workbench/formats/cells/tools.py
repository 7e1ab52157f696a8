"""A tool of a cell file: by its solids and fingers, or by its kind and a few numbers."""

import numpy as np

from workbench.formats.cells.options import read_options, refused_at
from workbench.formats.files.toml_keys import Table
from workbench.formats.meshes.solids import read_pose, read_solid
from workbench.model.cell import Finger, Tool
from workbench.plugins.found import load, names
from workbench.plugins.tool import made_tool

MOST_FORCE = 1e5
"""[N]"""


def read_tool(table: Table) -> Tool:
    """The table `[[tool]]`; see `plugins.tool` for kinds."""
    if table.has("kind"):
        kind, name = table.text("kind", among=names("workbench.tools")), table.text("name")
        with refused_at(table, "kind"):
            tool = made_tool(kind, name, read_options(table, load("workbench.tools", kind).Options))
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
    table.finish()
    if not tool.body and not tool.fingers:
        raise table.error("body", "is missing; [[tool.body]] or [[tool.finger]] is expected")
    return tool

"""Tools written into a cell file that people wrote: new ones, those that are gone, their TCPs."""

import hashlib
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from workbench.formats.cells.pose_edits import LOST, edit_pose
from workbench.formats.cells.writer import tool_lines
from workbench.formats.files.whole_files import make_folder, write_whole
from workbench.model.cell import Cell, Tool
from workbench.model.geometry import Floats, Mesh, Solid

TOOLS = "tools"
"""The folder of the meshes of new tools, next to the cell file."""

COMPARED_DIRECTIONS = np.array(
    [direction for direction in product((-1.0, 0.0, 1.0), repeat=3) if any(direction)]
)
"""In which it is compared how far convex meshes reach."""


def edit_tools(document: Any, old: Cell, new: Cell, folder: Path) -> None:
    """Write which tools the arms carry, and tools that are new, removed, or have another TCP.

    Meshes of new tools are written into the folder at once; their names are digests of their
    content, so they replace nothing.  The TCP is written for tools that the file describes by
    solids.  For other tools, reading the file again on trial finds the difference.

    Args:
        document: of the cell file.
        old: the cell as the file has it.
        new: as it should be read.
        folder: of the cell file.

    Raises:
        FileError: a mesh cannot be written.
    """
    for table, arm, other in zip(document["arm"], old.arms, new.arms, strict=True):
        if arm.tool.name != other.tool.name:
            table["tool"] = other.tool.name
        names = [tool.name for tool in other.tools]
        if [tool.name for tool in arm.tools] != names:
            table["tools"] = names
        if names == [other.tool.name] and len(arm.tools) > 1:
            del table["tools"]  # what it carries is all that it can
    were, are = (
        {tool.name: tool for arm in cell.arms for tool in (arm.tool, *arm.tools)}
        for cell in (old, new)
    )
    tables = document["tool"]
    for number in reversed(range(len(tables))):
        table = tables[number]
        name = str(table["name"])
        if name in were and name not in are:
            del tables[number]
        elif "tcp" in table and name in were:
            tcp = table["tcp"]
            first = tcp[0] if isinstance(tcp, list) else tcp
            edit_pose(first, were[name].T_flange_tcp, are[name].T_flange_tcp)
    for name, tool in are.items():
        if name not in were:
            tables.append(_table(tool, folder))


def _table(tool: Tool, folder: Path) -> Any:
    def put_mesh(name: str, content: bytes) -> str:
        # Of its content: what another save, or another person, has put there stays.
        file = f"{TOOLS}/{name}-{hashlib.sha256(content).hexdigest()[:12]}.stl"
        make_folder(folder / TOOLS)
        write_whole(folder / file, content)
        return file

    return tomlkit.parse("\n".join(tool_lines(tool, put_mesh)) + "\n\n")["tool"][0]  # type: ignore[index]


def all_as_written(tools: tuple[Tool, ...], others: tuple[Tool, ...]) -> tuple[Tool, ...]:
    """The tools, each as `as_written`, as far as there are as many."""
    if len(tools) != len(others):
        return tools
    return tuple(map(as_written, tools, others))


def as_written(tool: Tool, other: Tool) -> Tool:
    """The other tool, if the two differ only by the rounding of the file; otherwise this tool."""
    if tool.name != other.name:
        return tool
    mine, others = _numbers(tool), _numbers(other)
    is_alike = len(mine) == len(others) and bool(np.allclose(mine, others, rtol=0.0, atol=LOST))
    return other if is_alike else tool


def _numbers(tool: Tool) -> Floats:
    """What a tool is made of, in one row."""
    solids = [*tool.body, *(finger.solid for finger in tool.fingers)]
    return np.concatenate(
        [
            tool.T_flange_tcp.homogeneous.ravel(),
            (*tool.stroke, tool.press, tool.force or 0.0, tool.mass or 0.0, len(tool.body)),
            *(
                np.ravel(values)
                for values in (tool.centre_of_gravity, tool.inertia)
                if values is not None
            ),
            *(tcp.T_flange_tcp.homogeneous.ravel() for tcp in tool.tcps),
            *(finger.direction for finger in tool.fingers),
            *map(_of_solid, solids),
        ]
    )


def _of_solid(solid: Solid) -> Floats:
    shape = solid.shape
    if isinstance(shape, Mesh):
        measures = (np.asarray(shape.points) @ COMPARED_DIRECTIONS.T).max(axis=0)
    else:
        lengths = (getattr(shape, key, 0.0) for key in ("size", "radius", "length"))
        measures = np.concatenate([np.ravel(length) for length in lengths])
    return np.concatenate([solid.T_owner_shape.homogeneous.ravel(), measures])

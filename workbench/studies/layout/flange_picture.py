"""A picture of how each tool stands on its arm, to be turned in a browser."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from workbench.formats.meshes.triangles import surface_of
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, Solid, transform
from workbench.planning.kinematics.robot import Kinematics
from workbench.studies.plots import write_plot

LAST_LINKS = 3
"""Links with a body, from the flange back, that are drawn."""

LINK, TOOL, JOINT_AXIS = "#adb5bd", "#1c64b4", "#212529"
AXIS_COLOURS = ("#c92a2a", "#287d38", "#1c64b4")
"""Of x, y and z."""

ARROW = 0.08
"""[m] Length of a drawn axis of the flange."""


def draw_flanges(path: Path, cell: Cell) -> None:
    """Draw the last links of each arm, its tool, its last joint axis, and the axes of its flange.

    Args:
        path: an HTML file that needs nothing from elsewhere.
        cell: its arms stand at home.

    Raises:
        FileError: the file cannot be written.
    """
    titles = [f"{arm.name} arm: {arm.tool.name} on {arm.flange}" for arm in cell.arms]
    columns = len(cell.arms)
    scenes = [[{"type": "scene"}] * columns]
    figure = make_subplots(1, columns, specs=scenes, subplot_titles=titles)
    for column, arm in enumerate(cell.arms, start=1):
        for trace in _traces(cell, arm, with_legend=column == 1):
            figure.add_trace(trace, row=1, col=column)
    hidden = {"visible": False}
    figure.update_scenes(aspectmode="data", xaxis=hidden, yaxis=hidden, zaxis=hidden)
    write_plot(path, figure, f"{cell.name}: how the tools stand at home")


def _traces(cell: Cell, arm: Arm, *, with_legend: bool) -> list[go.Mesh3d | go.Scatter3d]:
    kinematics = Kinematics(cell)
    links = kinematics.link_poses(cell.joint_values({}))
    chain = cell.robot.chain(arm.flange)
    names = [arm.flange, *(joint.parent for joint in reversed(chain))]
    solids = {link.name: link.visual or link.collision for link in cell.robot.links}
    drawn = [name for name in names if solids[name]][:LAST_LINKS]
    T_world_flange = links[arm.flange]
    traces: list[go.Mesh3d | go.Scatter3d] = [
        _body(links[name], solids[name], LINK, name, with_legend) for name in drawn
    ]
    tool = (*arm.tool.body, *(finger.solid for finger in arm.tool.fingers))
    traces.append(_body(T_world_flange, tool, TOOL, "tool", with_legend))
    moving = next(joint for joint in reversed(chain) if joint.kind != "fixed")
    T_world_joint = links[moving.child]
    along = T_world_joint.rotation @ moving.axis
    middle = T_world_joint.translation
    ends = np.stack([middle - 2 * ARROW * along, middle + 3 * ARROW * along])
    traces.append(_line(ends, JOINT_AXIS, "last joint axis", with_legend, dash="dash"))
    for k, name in enumerate("xyz"):
        tip = T_world_flange.translation + ARROW * T_world_flange.rotation[:, k]
        ends = np.stack([T_world_flange.translation, tip])
        traces.append(_line(ends, AXIS_COLOURS[k], f"{name} of the flange", with_legend))
    return traces


def _body(
    T: pin.SE3, solids: tuple[Solid, ...], colour: str, name: str, with_legend: bool
) -> go.Mesh3d:
    surface = surface_of(solids)
    points = transform(T, np.asarray(surface.vertices))
    (x, y, z), (i, j, k) = points.T, np.asarray(surface.faces).T
    return go.Mesh3d(
        x=x, y=y, z=z, i=i, j=j, k=k, color=colour, opacity=0.6, name=name, flatshading=True,
        showlegend=with_legend, hoverinfo="name",
    )  # fmt: skip


def _line(
    ends: Floats, colour: str, name: str, with_legend: bool, dash: str = "solid"
) -> go.Scatter3d:
    x, y, z = ends.T.tolist()
    style = {"color": colour, "width": 8, "dash": dash}
    return go.Scatter3d(x=x, y=y, z=z, mode="lines", line=style, name=name, showlegend=with_legend)

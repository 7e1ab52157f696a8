"""Marks in the scene that people ask for: an arm's reach, and a distance."""

import numpy as np
import viser

from workbench.gui.scene.contacts import add_body, draw_meets
from workbench.gui.shared.colours import BAD, BRAND, BUSY, GOOD, rgb_of
from workbench.gui.shared.own import Visited
from workbench.gui.shared.solids import Colour
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.scan import RejectedHypothesis


def add_lines(
    scene: viser.SceneApi, name: str, lines: Floats, colour: Colour | np.ndarray, wide: float
) -> None:
    """Lines (n, 2, 3) [m], this many pixels wide from near and far; one colour, or (n, 2, 3)."""
    scene.add_line_segments(
        name, lines.astype(np.float32), colour, thickness=wide, thickness_units="screen"
    )


def draw_reach(scene: viser.SceneApi, reached: tuple[Floats, Floats] | None) -> None:
    """Places (n, 3) [m] an arm reaches: green with the tool at any turn, orange at some.

    With them comes the share (n,) of the turns.
    """
    scene.remove_by_name("/reach")
    if reached is None or not len(reached[0]):
        return
    places, shares = reached
    colours = np.where(shares[:, None] >= 1.0, rgb_of(GOOD), rgb_of(BUSY)).astype(np.uint8)
    scene.add_point_cloud(
        "/reach",
        places.astype(np.float32),
        colours,
        point_size=0.004,
        point_shape="circle",
        precision="float32",
    )


def draw_rejected(
    scene: viser.SceneApi, cell: Cell, rejected: tuple[RejectedHypothesis, ...]
) -> None:
    """Poses that a search has rejected, red and translucent."""
    scene.remove_by_name("/rejected")
    for number, hypothesis in enumerate(rejected):
        mesh = cell.part(hypothesis.part).mesh
        add_body(scene, f"/rejected/{number + 1}", mesh, hypothesis.T_world_part, rgb_of(BAD), 0.25)


def draw_measured(scene: viser.SceneApi, points: tuple[Floats, ...]) -> None:
    """One clicked point (3,) [m], or two with a line and their distance."""
    scene.remove_by_name("/measured")
    for number, p in enumerate(points):
        scene.add_icosphere(f"/measured/{number}", 0.004, rgb_of(BRAND), position=tuple(p.tolist()))
    if len(points) < 2:
        return
    first, second = points
    add_lines(scene, "/measured/line", np.array([[first, second]]), rgb_of(BRAND), 2.0)
    scene.add_label(
        "/measured/label",
        measured_text(first, second),
        font_screen_scale=0.8,
        position=tuple(((first + second) / 2).tolist()),
    )


def draw_visited(scene: viser.SceneApi, visited: Visited | None) -> None:
    """Two bodies of a plan where they are nearest, and where they are nearest to each other."""
    draw_meets(scene, "/nearest", () if visited is None else visited.spot.bodies, BUSY, 0.4, 0.0)
    scene.remove_by_name("/nearest_points")
    if visited is None:
        return
    points = visited.spot.points
    for number, p in enumerate(points):
        name = f"/nearest_points/{number}"
        scene.add_icosphere(name, 0.0025, rgb_of(BAD), position=tuple(p.tolist()))
    add_lines(scene, "/nearest_points/line", points[None], rgb_of(BAD), 3.0)
    scene.add_label(
        "/nearest_points/label",
        visited.says,
        font_screen_scale=0.9,
        anchor="bottom-center",
        depth_test=False,
        position=tuple((points.max(axis=0) + np.array([0.0, 0.0, 0.02])).tolist()),
    )


def measured_text(first: Floats, second: Floats) -> str:
    """The distance of two points (3,) [m], and how it lies along the axes of the world."""
    d = (second - first) * 1000
    return f"{np.linalg.norm(d):.1f} mm\nx {d[0]:+.1f}  y {d[1]:+.1f}  z {d[2]:+.1f} mm"

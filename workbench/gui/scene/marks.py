"""Marks in the scene: the pins of parts found, an arm's reach, a distance."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import viser

from workbench.gui.scene.contacts import add_body, draw_meets
from workbench.gui.scene.robot import quaternion
from workbench.gui.shared.colours import BAD, BRAND, BUSY, GOOD, PLATE, part_colour, rgb_of
from workbench.gui.shared.look import View
from workbench.gui.shared.own import ShownPlate, Visited
from workbench.gui.shared.solids import Colour
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.scan import Detection, RejectedHypothesis

PIN_HEIGHT, PIN_STEP, PIN_SPACING = 0.012, 0.018, 0.035
"""[m] How far a pin ends above its part.  Pins nearer to each other than `PIN_SPACING` differ in
height by `PIN_STEP` at least."""

HEAD = 0.003
"""[m] Radius of a pin's head."""


def pin_heights(tops: Floats) -> Floats:
    """Where the pins of parts end, so that labels of near parts do not cover each other.

    Args:
        tops: the highest point of each part in the world, above its middle, (n, 3) [m].

    Returns:
        z (n,) [m].
    """
    heights = np.zeros(len(tops))
    ended: list[int] = []
    for number in np.argsort(tops[:, 2], kind="stable").tolist():
        away = np.linalg.norm(tops[ended, :2] - tops[number, :2], axis=1)
        z = tops[number, 2] + PIN_HEIGHT
        for other in np.sort(heights[ended][away < PIN_SPACING]):
            if abs(z - other) < PIN_STEP:
                z = other + PIN_STEP
        heights[number] = z
        ended.append(number)
    return heights


class DrawnPins:
    """The pins of the parts found; they stand upright as parts turn.

    Concurrency: the renderer's thread.
    """

    def __init__(self, scene: viser.SceneApi):
        """None is drawn yet."""
        self._scene = scene
        self._pins: list[viser.FrameHandle] = []

    def add(self, cell: Cell, detections: Sequence[Detection]) -> None:
        """Draw a pin below the node of each part, which has taken away the one before."""
        self._pins = []
        for number, height in enumerate(pins_of(cell, detections)):
            name = f"/parts/part-{number + 1}/pin"
            head = np.array([0.0, 0.0, height])
            colour = rgb_of(part_colour(number))
            self._pins.append(self._scene.add_frame(name, show_axes=False))
            add_lines(self._scene, f"{name}/stem", np.array([[np.zeros(3), head]]), colour, 2.5)
            self._scene.add_icosphere(f"{name}/head", HEAD, colour, position=tuple(head.tolist()))
            label_pin(self._scene, number, height, is_chosen=False)

    def turn(self, Ts_world_part: Sequence[pin.SE3]) -> None:
        """Parts stand there now."""
        for node, T in zip(self._pins, Ts_world_part, strict=True):
            node.wxyz = quaternion(T.inverse())


def label_pin(scene: viser.SceneApi, number: int, height: float, *, is_chosen: bool) -> None:
    """The number of a part above its pin; that of the chosen one is larger, and over all else."""
    scene.add_label(
        label_name(number),
        f"{number + 1}",
        font_screen_scale=1.5 if is_chosen else 1.0,
        anchor="bottom-center",
        depth_test=not is_chosen,
        position=(0.0, 0.0, height + HEAD),
    )


def label_name(number: int) -> str:
    """The node of a pin's label."""
    return f"/parts/part-{number + 1}/pin/label"


def draw_chosen(scene: viser.SceneApi, old: View | None, new: View) -> None:
    """In the scene of one browser: the label of the part found that was chosen there."""
    remove_chosen(scene, old)
    now = _chosen(new)
    if now is not None:
        height = pins_of(new.state.cell, new.state.detections or ())[now]
        label_pin(scene, now, height, is_chosen=True)


def remove_chosen(scene: viser.SceneApi, view: View | None) -> None:
    """Remove that label, as it was drawn for a view; None: for none."""
    was = _chosen(view)
    if was is not None:
        scene.remove_by_name(label_name(was))


def _chosen(view: View | None) -> int | None:
    found = () if view is None else view.state.detections or ()
    return next((n for n, part in enumerate(found) if view and part is view.own.part), None)


def pins_of(cell: Cell, detections: Sequence[Detection]) -> Floats:
    """How high above the origin of its part each pin ends, (n,) [m]."""
    middles = np.array([detection.T_world_part.translation for detection in detections]).reshape(
        -1, 3
    )
    above = [
        (cell.part(detection.part).mesh.points @ detection.T_world_part.rotation[2]).max()
        for detection in detections
    ]
    tops = middles + np.outer(above, [0.0, 0.0, 1.0])
    return pin_heights(tops) - middles[:, 2]


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


def draw_plate(scene: viser.SceneApi, shown: ShownPlate | None) -> viser.FrameHandle | None:
    """The three balls of a plate in its frame, which is to be placed; None: nothing is drawn."""
    scene.remove_by_name("/plate")
    if shown is None:
        return None
    frame = scene.add_frame("/plate", show_axes=False)
    centres = shown.plate.centres
    for number, p in enumerate(centres):
        position, radius = tuple(p.tolist()), shown.plate.radius
        scene.add_icosphere(f"/plate/{number}", radius, PLATE, opacity=0.7, position=position)
    sides = np.stack([centres, np.roll(centres, -1, axis=0)], axis=1)
    add_lines(scene, "/plate/sides", sides, PLATE, 2.0)
    return frame


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

"""Ways to look at the cell that a key or a press brings back: default, top, front, bin, selected.

A click on a part chooses it; a double click brings what lies there into the middle.
"""

import itertools
import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from html import escape
from typing import Any

import numpy as np
from viser._messages import HotkeyKey

from workbench.app.core.state import State
from workbench.gui.page.triad import Triad
from workbench.gui.scene.measure import part_at, pointed_at
from workbench.gui.scene.stage import STAGE
from workbench.gui.scene.surroundings import ASPECT, FIELD_OF_VIEW, first_look, frame_camera
from workbench.gui.scene.surroundings import interesting_points as whole
from workbench.gui.shared.look import Look, View
from workbench.gui.shared.movable_frames import pose_of, things
from workbench.gui.shared.tables import clickable
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.scene import LegendText
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.message import plain

Camera = tuple[Floats, Floats]
"""Position of a camera and the point it looks at, each (3,) [m]."""

SEEN_AROUND = 0.12
"""[m] What is seen at least around what is selected, to all sides."""

DOUBLE_CLICK, SAME_RAY = 0.5, math.radians(1.0)
"""[s, rad] Two clicks within this time, and along rays that differ by no more, are a double one."""

KEYS: Mapping[str, tuple[HotkeyKey, str]] = {
    "Default view": ("1", "as the page begins"),
    "Top": ("2", "from above"),
    "Front": ("3", "from in front"),
    "Bin": ("4", "into the bin"),
    "Selected": ("5", "at the candidate or thing chosen last, or the parts"),
}
"""Each look by its name: its key, and what it shows."""


def camera_of(name: str, state: State, look: Look, thing: str = "") -> Camera:
    """From where a look is had.

    Args:
        name: one of `KEYS`.
        state: what there is.
        look: its candidate is selected, if it has one.
        thing: the thing of the cell that is selected instead of it; empty: none.

    Raises:
        InputError: nothing is there to look at.
    """
    cell = state.cell
    match name:
        case "Default view":
            return first_look(cell)
        case "Top":
            return _frame(whole(cell), _forward(cell) * 0.02, 1.0)
        case "Front":
            return _frame(whole(cell), _forward(cell), 0.12)
        case "Bin":
            return _frame(_bin(cell), _forward(cell) * 0.45, 1.0)
        case _:
            return _frame(_corners_of(state, look, thing), _forward(cell) * 0.8, 0.7)


def _forward(cell: Cell) -> Floats:
    """The level unit vector from the robot to the bin, (3,)."""
    away = cell.bin.T_world_bin.translation - cell.T_world_robot.translation
    azimuth = math.atan2(away[1], away[0])
    return np.array([math.cos(azimuth), math.sin(azimuth), 0.0])


def _frame(points: Floats, level: Floats, upwards: float) -> Camera:
    direction = level + np.array([0.0, 0.0, upwards])
    return frame_camera(points, direction / np.linalg.norm(direction), FIELD_OF_VIEW, ASPECT)


def _bin(cell: Cell) -> Floats:
    length, width, height = cell.bin.size
    return np.array(
        [
            cell.bin.T_world_bin.act(np.array([x * length / 2, y * width / 2, z * height]))
            for x, y, z in itertools.product((-1, 1), (-1, 1), (0, 1))
        ]
    )


def _corners_of(state: State, look: Look, thing: str) -> Floats:
    candidates, found = state.candidates or (), state.detections or ()
    if thing in things(state.cell):
        return _thing(state.cell, thing)
    if look.candidate is not None and look.candidate < len(candidates):
        middles = [candidates[look.candidate].T_world_tcp.translation]
    else:
        middles = [detection.T_world_part.translation for detection in found]
    if not middles:
        raise InputError("nothing is selected, and no part is found")
    corners = SEEN_AROUND * np.array(list(itertools.product((-1, 1), repeat=3)))
    return np.concatenate([middle + corners for middle in middles])


def _thing(cell: Cell, thing: str) -> Floats:
    """Points (n, 3) [m] around one of `things`."""
    match thing:
        case "bin":
            return _bin(cell)
        case "robot":
            return whole(cell)
        case _:
            solids = [
                s for fixture in cell.fixtures if fixture.name == thing for s in fixture.solids
            ]
            around = max([SEEN_AROUND, *(solid.reach for solid in solids)])
            corners = around * np.array(list(itertools.product((-1, 1), repeat=3)))
            return pose_of(cell, thing).translation + corners


def centre_camera(camera: Camera, point: Floats) -> Camera:
    """The camera moved, not turned, so that a point (3,) [m] is what it looks at."""
    position, centre = camera
    return position + point - centre, point


class Looks:
    """Keys, a row of buttons over the scene, and double clicks into it.

    Concurrency: clicks and keys move the camera of this browser alone.
    """

    def __init__(self, visitor: Visitor):
        """Add them."""
        self._visitor = visitor
        self._view: View | None = None
        self._click = (-math.inf, np.zeros(3))
        pressed: dict[str, Callable[[], None]] = {name: partial(self._go, name) for name in KEYS}
        buttons = {name: visitor.unseen(go) for name, go in pressed.items()}
        visitor.hide(buttons.values())
        shown = ""
        for name, (key, says) in KEYS.items():
            look = visitor.words.render(LegendText.LOOK(direction=plain(says)))
            visitor.on_key(key, look, partial(self._type, name))
            tip = visitor.words.render(LegendText.LOOK_KEY(direction=plain(says), key=key))
            shown += f'<span title="{escape(tip)}" {clickable(buttons[name])}>{name}</span>'
        visitor.gui.add_html(f'<div class="wb-looks">{shown}</div>')
        self._triad = Triad(visitor)
        scene = visitor.client.scene

        @scene.on_click()
        def click(event: Any) -> None:
            rays = np.array([event.ray_origin, event.ray_direction], dtype=np.float64)
            if np.all(np.isfinite(rays)) and np.linalg.norm(rays[1]) > 0.5:
                self._take_click(rays[0], rays[1], time.monotonic())

        visitor.on_end(lambda: scene.remove_click_callback(click), in_scene=True)

    def show(self, view: View) -> None:
        """This is what is seen now."""
        self._view = view
        self._triad.show()

    def _take_click(self, origin: Floats, direction: Floats, at: float) -> None:
        """A person has clicked along a ray, of which each is (3,) [m] in the world, at [s]."""
        before, way = self._click
        ray = direction / np.linalg.norm(direction)
        is_double = at - before <= DOUBLE_CLICK and ray @ way >= math.cos(SAME_RAY)
        self._click = (-math.inf, way) if is_double else (at, ray)
        if self._view is not None and not is_double:
            self._point_at(self._view, origin, ray)
        point = pointed_at(self._view, origin, ray) if is_double and self._view else None
        if point is None:
            return
        client = self._visitor.client
        seen = np.array(client.camera.position), np.array(client.camera.look_at)
        with client.atomic():
            client.camera.position, client.camera.look_at = centre_camera(seen, point)

    def _point_at(self, view: View, origin: Floats, ray: Floats) -> None:
        if self._visitor.client.scene.get_handle_by_name(STAGE) is not None:
            return  # the part stands alone: its grasps are clicked on
        number, found = part_at(view, origin, ray), view.state.detections or ()
        self._visitor.own.change(pointed=None if number is None else found[number])

    def _type(self, name: str) -> None:
        # While the part stands alone the same keys move its grasp.
        if self._visitor.client.scene.get_handle_by_name(STAGE) is None:
            self._go(name)

    def _go(self, name: str) -> None:
        visitor = self._visitor
        try:
            position, centre = camera_of(
                name, visitor.bench.state, visitor.look.now, visitor.own.now.thing
            )
        except InputError as error:
            visitor.notify("Nothing to look at", str(error))
            return
        camera = visitor.client.camera
        with visitor.client.atomic():
            camera.up_direction = (0.0, 0.0, 1.0)
            camera.position = position
            camera.look_at = centre

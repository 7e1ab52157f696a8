"""Whether the hands that move are in a browser's picture, and a look that holds them all along."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.gui.drawing.audience import Span
from workbench.gui.scene.surroundings import (
    FIELD_OF_VIEW,
    BrowserCamera,
    frame_camera,
    look_direction,
)
from workbench.gui.scene.surroundings import interesting_points as whole
from workbench.gui.shared.look import View
from workbench.gui.shared.playback import Run, interpolate, latest
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.scene import WatchText
from workbench.model.cell import Cell
from workbench.model.derived.by_tcp import by_taking
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.planning.kinematics.robot import Kinematics

SAMPLE_EVERY = 0.1
"""[s] Between two looks at where the hands of a plan are."""

HAND = 0.1
"""[m] So large a hand is at least."""

SMALLEST = 0.01
"""Of the picture's height: a hand that is drawn smaller is seen by nobody."""


CAMERA_WITHIN = 2.0
"""[s] A browser that does not say where its camera is now is not waited for any longer."""

THERE = 1e-3
"""[m] So exactly a camera stands where it was sent."""


@dataclass(frozen=True, slots=True)
class HandWays:
    """The hands of a row of plans as they move; made once for a cell and its timeline."""

    cell: Cell
    kinematics: Kinematics
    runs: tuple[Run, ...]

    def hands(self, time: float) -> Floats:
        """The tool centre points (k, 3) [m] of the arms that move at a time [s], in the world."""
        found: list[Floats] = []
        for arm in self.cell.arms:
            run = latest(self.runs, arm.name, time)
            if run is not None and time <= run.end:
                q = interpolate(run.leg.q, run.leg.t, time - run.start)
                by = by_taking(self.cell, run).arm(arm.name)
                found.append(self.kinematics.tcp_pose(by, q).translation)
        return np.array(found).reshape(-1, 3)

    def along(self, spans: Sequence[Span]) -> Floats:
        """All places (n, 3) [m] of moving hands in stretches of time [s]."""
        times = [
            time
            for begin, end in spans
            for time in np.linspace(begin, end, 2 + int((end - begin) / SAMPLE_EVERY)).tolist()
        ]
        return np.concatenate([np.zeros((0, 3)), *map(self.hands, times)])


def are_seen(camera: BrowserCamera, points: Floats) -> bool:
    """Whether all points (n, 3) [m] are in a camera's picture, and near enough to be made out."""
    if not len(points):
        return True
    w, x, y, z = camera.wxyz.tolist()
    R = pin.Quaternion(w, x, y, z).normalized().matrix()
    right, down, away = ((points - camera.position) @ R).T
    half = math.tan(camera.fov / 2)
    high = away * half
    is_large = SMALLEST * high <= HAND / 2
    is_inside = (np.abs(down) <= high) & (np.abs(right) <= high * camera.aspect)
    return bool(np.all((away > 0.0) & is_inside & is_large))


def look_at_hands(way: HandWays, points: Floats, camera: BrowserCamera) -> tuple[Floats, Floats]:
    """From where a camera holds the whole cell, and hands at these points (n, 3) [m].

    Returns:
        Its position and the point it looks at, each (3,) [m], as it has them at first.
    """
    around = HAND * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    hands = (points[:, None, :] + around).reshape(-1, 3)
    inside = np.concatenate([whole(way.cell), hands])
    return frame_camera(
        inside, look_direction(way.cell), camera.fov or FIELD_OF_VIEW, camera.aspect
    )


class InView:
    """Keeps a browser's camera on the hands as a plan begins to play, and looks whether it is.

    Concurrency: the renderer's thread.
    """

    def __init__(self) -> None:
        self._way: HandWays | None = None
        self._asked: tuple[Floats, float, float] | None = None
        self._were_out = False

    def bring(self, view: View, visitor: Visitor, begin: float, unseen: Sequence[Span]) -> None:
        """Move the camera to where it holds the hands, if they or the bin leave its picture.

        Args:
            view: whose plan is played.
            visitor: the browser that plays it.
            begin: from when [s] on.
            unseen: stretches of the plan that have still to be seen, from and to [s].
        """
        self._asked, self._were_out = None, False
        camera, way = visitor.client.camera, self._way_of(view)
        left = [(max(first, begin), last) for first, last in unseen if last > begin]
        hands = way.along(left)
        bin = view.state.cell.bin.T_world_bin.translation
        if are_seen(camera, np.concatenate([hands, bin[None]])):
            return
        position, target = look_at_hands(way, hands, camera)
        with visitor.client.atomic():
            camera.up_direction = (0.0, 0.0, 1.0)
            camera.position = position
            camera.look_at = target
        self._asked = position, camera.update_timestamp, time.monotonic() + CAMERA_WITHIN

    def is_on_its_way(self, visitor: Visitor) -> bool:
        """Whether the browser has still to say that its camera is where it was sent."""
        if self._asked is None:
            return False
        position, set_at, until = self._asked
        camera = visitor.client.camera
        is_updated = camera.update_timestamp > set_at
        is_there = bool(np.allclose(camera.position, position, atol=THERE))
        if (is_updated and is_there) or time.monotonic() > until:
            self._asked = None
        return self._asked is not None

    def are_out(self, view: View, visitor: Visitor, begin: float, end: float) -> bool:
        """Whether hands were out of the picture between two drawings, at these times [s]."""
        are_out = not are_seen(visitor.client.camera, self._way_of(view).hands(end))
        were_out, self._were_out = self._were_out, are_out
        return (were_out or are_out) and begin < end

    def _way_of(self, view: View) -> HandWays:
        way, cell = self._way, view.state.cell
        if way is None or way.cell is not cell or way.runs is not view.runs:
            way = self._way = HandWays(cell, Kinematics(cell), view.runs)
        return way


def hidden_message(spans: Sequence[Span]) -> Message | None:
    """What to do about stretches [s] of a plan in which its hands were out of the picture."""
    if not spans:
        return None
    found = span_messages(spans)
    if len(spans) == 1:
        return WatchText.OUT_OF_VIEW(span=found[0])
    return WatchText.OUT_OF_VIEW_SEVERAL(spans=found)


def span_messages(spans: Sequence[Span]) -> list[Message]:
    """Stretches [s] of a plan, each with its begin and its end."""
    return [WatchText.SPAN(begin=begin, end=end) for begin, end in spans]

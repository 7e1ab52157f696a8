"""Drags of a gizmo, as far as they can be believed and were ended by the one who drags.

A browser that draws slowly may let a person take hold of a gizmo whose own pose it has not set
yet: then what it sends begins at the origin, not where the gizmo stands (viser 1.1.1, seen with two
frames a
second).  A bin would be moved by half a metre by somebody who meant a centimetre.  And when a
browser goes in the middle of a drag, viser ends the drag where it was: nobody has let go there.
"""

import threading
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import pinocchio as pin
import viser

from workbench.gui.scene.robot import pose_of_node, quaternion
from workbench.gui.shared.viser_server import is_connected
from workbench.gui.shared.visitor import Visitor
from workbench.model.errors import InputError

MOST_AT_ONCE = 0.12
"""[m] A hand does not move a gizmo farther than this until the first message comes."""

NOT_BELIEVED = (
    "Drag it again",
    "This browser drew too slowly and sent another place than the one seen; nothing was moved.",
)
"""What a person reads."""


class GizmoDrag:
    """One drag after the other of one gizmo.

    Concurrency: one thread at a time.
    """

    def __init__(self) -> None:
        self._is_new = True
        self._is_believed = True
        self._is_over = False

    def is_believed(
        self, phase: Literal["start", "update", "end"], T_before: pin.SE3, T_now: pin.SE3
    ) -> bool:
        """Whether an event belongs to a drag that began where the gizmo stood.

        Args:
            phase: of the event.
            T_before: where it stood before the drag.
            T_now: where the browser says that it is.
        """
        if phase == "start":
            self._is_new = self._is_believed = True
            self._is_over = False
            return True
        if self._is_over:
            # Overtaken by the end of its drag.
            return False
        self._is_over = phase == "end"
        if self._is_new:
            self._is_new = False
            shift = float(np.linalg.norm(T_now.translation - T_before.translation))
            self._is_believed = shift <= MOST_AT_ONCE
        return self._is_believed


def add_gizmo(
    visitor: Visitor, name: str, size: float, T: pin.SE3
) -> viser.TransformControlsHandle:
    """A gizmo at `T`, its pose in what its name is below of, in one browser; so large [m]."""
    return visitor.client.scene.add_transform_controls(
        name, size, position=T.translation, wxyz=quaternion(T), depth_test=False
    )


def follow(
    gizmo: viser.TransformControlsHandle,
    visitor: Visitor,
    *,
    stood: Callable[[], pin.SE3],
    moved: Callable[[pin.SE3, bool], None],
    began: Callable[[], None],
    put_back: Callable[[], None],
) -> None:
    """Follow the drags of a gizmo.

    viser calls back from several threads, which may overtake each other: here they queue.

    Args:
        gizmo: in the scene of one browser.
        visitor: whose browser.
        stood: states where the gizmo stood before the drag.
        moved: called with where the gizmo is now, and whether the person has let go of it.
        began: called when the person takes hold of it, before `moved`.
        put_back: called when a drag has ended that does not count.
    """
    drag, queue = GizmoDrag(), threading.Lock()

    @gizmo.on_update
    def _(event: Any) -> None:
        is_over = event.phase == "end"
        if is_over and not is_connected(visitor.client):
            return
        with queue:
            if event.phase == "start":
                began()
            try:
                T_now = pose_of_node(gizmo)
            except InputError as error:
                if is_over:
                    put_back()
                    visitor.notify("Refused", str(error))
                return
            if drag.is_believed(event.phase, stood(), T_now):
                moved(T_now, is_over)
            elif is_over:
                put_back()
                visitor.notify(*NOT_BELIEVED)

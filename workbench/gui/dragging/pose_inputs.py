"""A pose by numbers and by gizmo: for whatever a person may move."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pinocchio as pin
import viser

from workbench.gui.dragging.gizmo_drag import add_gizmo, follow
from workbench.gui.dragging.verdicts import LiveVerdicts
from workbench.gui.dragging.views import VerdictRoom, dragged_html
from workbench.gui.scene.robot import place
from workbench.gui.shared.look import DraggedThing, View
from workbench.gui.shared.movable_frames import ANGLES, shown_pose, typed_pose
from workbench.gui.shared.own import Carried
from workbench.gui.shared.visitor import Visitor


class PoseInputs:
    """Position, angles, a button that applies them, and a gizmo in this browser's scene.

    Concurrency: callbacks of viser and the renderer's thread; handles only.
    """

    def __init__(
        self,
        visitor: Visitor,
        name: str,
        size: float,
        *,
        command: type,
        meant: Callable[[pin.SE3], bool],
        otherwise: Callable[[pin.SE3], Mapping[str, Any] | None],
        carried: Callable[[pin.SE3], Mapping[str, pin.SE3]],
    ):
        """Add the controls.

        Args:
            visitor: whose browser.
            name: of the gizmo in the scene.
            size: of the gizmo [m].
            command: that a person gives who wants it elsewhere.
            meant: called with the pose that a person wants; whether it was carried out.
            otherwise: what would be other with it at a pose, for verdicts while it is dragged
                (`LiveVerdicts.ask`); None: no verdict would.
            carried: what is drawn elsewhere with it at a pose (`Carried`).
        """
        self._visitor = visitor
        self._name, self._size = name, size
        self._meant, self._otherwise, self._carried = meant, otherwise, carried
        self._verdicts = LiveVerdicts(visitor, command)
        self._T = self._T_world_frame = pin.SE3.Identity()
        self._gizmo: viser.TransformControlsHandle | None = None
        gui = visitor.gui
        self._position = gui.add_vector3(
            "Position [mm]",
            (0.0, 0.0, 0.0),
            step=0.1,
            hint="In the world frame; a TCP in that of the flange.",
        )
        self._angles = gui.add_vector3(
            "Angles [deg]", (0.0, 0.0, 0.0), step=0.1, hint="Roll, pitch, yaw: fixed axes."
        )
        visitor.name(self._angles, ANGLES)
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._apply = gui.add_button("Move it there", icon=viser.Icon.CHECK)
        self._switch = gui.add_button("Show gizmo", color="gray")
        self._told = gui.add_html("")
        self._apply.on_click(lambda _: self._end(self._typed_pose()))
        self._switch.on_click(lambda _: self._turn())
        visitor.on_end(self._hide, in_scene=True)

    def show(
        self, T: pin.SE3 | None, *, problem: str, T_world_frame: pin.SE3 | None = None
    ) -> None:
        """What it is about is there; None: there is nothing to move.

        Args:
            T: its pose in the world.
            problem: why it cannot be moved; empty when it can.
            T_world_frame: of the frame that its numbers are in; None: the world.
        """
        problem = problem or ("nothing is chosen that could be moved" if T is None else "")
        for button in (self._apply, self._switch):
            self._visitor.allow(button, problem)
        self._position.disabled = self._angles.disabled = bool(problem)
        if T is None:
            self._hide()
            return
        frame = pin.SE3.Identity() if T_world_frame is None else T_world_frame
        are_same = [
            np.array_equal(new.homogeneous, old.homogeneous)
            for new, old in ((T, self._T), (frame, self._T_world_frame))
        ]
        if not all(are_same):
            self._T_world_frame = frame
            self._put(T)

    def is_typed(self) -> bool:
        """Whether numbers were typed to which nothing was moved."""
        typed = (self._position.value, self._angles.value)
        return typed != shown_pose(self._T_world_frame.actInv(self._T))

    def show_drag(self, old: View | None, new: View) -> None:
        """Show the values of a drag from `old` to `new`."""
        if (
            old is None
            or old.own.dragged is not new.own.dragged
            or old.state.detections is not new.state.detections
        ):
            self._show_verdicts()

    def _put(self, T: pin.SE3) -> None:
        self._T = pin.SE3(T)
        self._show_numbers(T)
        if self._gizmo is not None:
            place(self._gizmo, T)

    def _show_verdicts(self) -> None:
        """The text about the candidates; with a gizmo there is room for it before a drag."""
        room = VerdictRoom.NONE if self._gizmo is None else VerdictRoom.EMPTY
        if self._gizmo is not None and self._visitor.bench.state.detections:
            room = VerdictRoom.HINT
        content = dragged_html(self._visitor.own.now.dragged, room, self._visitor.words)
        if self._told.content != content:
            self._told.content = content

    def _show_numbers(self, T: pin.SE3) -> None:
        self._position.value, self._angles.value = shown_pose(self._T_world_frame.actInv(T))

    def _typed_pose(self) -> pin.SE3:
        return self._T_world_frame * typed_pose(self._position.value, self._angles.value)

    def _end(self, T: pin.SE3) -> None:
        if not self._meant(T):
            self._put(self._T)

    def _hide(self) -> None:
        if self._gizmo is not None:
            self._verdicts.end()
            self._gizmo.remove()
            self._gizmo, self._switch.label = None, "Show gizmo"
            self._show_verdicts()

    def _turn(self) -> None:
        """Show the gizmo in this browser, or take it away."""
        if self._gizmo is not None:
            self._hide()
            return
        gizmo = add_gizmo(self._visitor, self._name, self._size, self._T)
        self._gizmo, self._switch.label = gizmo, "Hide gizmo"
        self._verdicts.prepare()
        self._show_verdicts()

        follow(
            gizmo,
            self._visitor,
            stood=lambda: self._T,
            moved=self._on_dragged,
            began=self._verdicts.begin,
            put_back=self._put_back,
        )

    def _on_dragged(self, T: pin.SE3, is_over: bool) -> None:
        # From the numbers that are shown: what a person reads is what is meant.
        self._show_numbers(T)
        visitor = self._visitor
        held = DraggedThing(visitor.person.name, visitor.number, self._typed_pose())
        visitor.look.change(held=None if is_over else held)
        if is_over:
            self._verdicts.end()
            self._end(self._typed_pose())
            visitor.own.change(carried=None)
            return
        state = visitor.bench.state
        visitor.own.change(carried=Carried(self._carried(held.T_world_held), state))
        if (otherwise := self._otherwise(held.T_world_held)) is not None:
            self._verdicts.ask(otherwise, held.T_world_held)

    def _put_back(self) -> None:
        held = self._visitor.look.now.held
        if held is not None and held.browser == self._visitor.number:
            self._visitor.look.change(held=None)
        self._verdicts.end()
        self._visitor.own.change(carried=None)
        self._put(self._T)

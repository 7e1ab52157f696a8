"""What somebody drags, as everybody else sees it, and what hands held that nobody hears of."""

from collections.abc import Mapping

import pinocchio as pin
import viser

from workbench.app.core.state import Phase
from workbench.gui.scene.contacts import add_body
from workbench.gui.scene.robot import place
from workbench.gui.shared.colours import NOT_REPORTED
from workbench.gui.shared.look import DraggedThing, View
from workbench.gui.shared.playback import in_hands
from workbench.model.geometry import Mesh
from workbench.planning.kinematics.robot import Kinematics

AXIS_LENGTH = 0.12
"""[m] Length of the frame's axes: the gizmo in the hands of who drags covers them."""


class DrawnHeld:
    """A frame that is added when a drag begins, and only moved until it ends.

    Concurrency: the renderer's thread.
    """

    def __init__(self, scene: viser.SceneApi):
        """Nothing is dragged yet."""
        self._scene = scene
        self._frame: viser.FrameHandle | None = None
        self._name = ""

    def draw(self, held: DraggedThing | None) -> None:
        """Show what is dragged now; None: nothing is."""
        if held is None or held.name != self._name:
            self._scene.remove_by_name("/held")
            self._frame, self._name = None, ""
        if held is None:
            return
        if self._frame is None:
            self._name = held.name
            self._frame = self._scene.add_frame(
                "/held", axes_length=AXIS_LENGTH, axes_radius=AXIS_LENGTH * 0.02
            )
            self._scene.add_label(
                "/held/name", held.name, font_screen_scale=0.8, anchor="bottom-center"
            )
        place(self._frame, held.T_world_held)


class DrawnLost:
    """The parts in the hands of a robot that does not report any more, once its plan is gone.

    Until then the film of the plan has them; the part is as unsure as the robot, and as grey.

    Concurrency: the renderer's thread.
    """

    def __init__(self, scene: viser.SceneApi):
        """No hand holds anything."""
        self._scene = scene
        self._held: Mapping[str, tuple[Mesh, pin.SE3]] = {}
        self._heard_at = 0.0
        self._is_drawn: bool | None = False

    def draw(self, view: View, kinematics: Kinematics) -> None:
        """Show what hands held when their robot was heard of last, until it is heard of again."""
        state, cell = view.state, view.state.cell
        if state.phase is Phase.FAULT and view.look.follows:
            held = in_hands(cell, state.plans, view.runs, view.look.time)
            self._held = {arm: (cell.part(part).mesh, T) for arm, (part, T) in held.items()}
            self._heard_at = view.live.reported_at
        is_lost = view.was_reported and view.live.reported_at == self._heard_at
        if state.phase is not Phase.FAULT and not is_lost:
            self._held = {}
        is_wanted = bool(self._held) and is_lost and not state.plans
        if is_wanted == self._is_drawn:
            return
        self._is_drawn = None  # until it is drawn
        self._scene.remove_by_name("/lost")
        for arm, (mesh, T_tcp_part) in self._held.items() if is_wanted else ():
            T_world_tcp = kinematics.tcp_pose(cell.arm(arm), view.real[arm].q)
            add_body(self._scene, f"/lost/{arm}", mesh, T_world_tcp * T_tcp_part, NOT_REPORTED)
        self._is_drawn = is_wanted

"""What somebody drags, as everybody else sees it: a frame with that person's name."""

import viser

from workbench.gui.scene.robot import place
from workbench.gui.shared.look import Held

AXES = 0.12
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

    def draw(self, held: Held | None) -> None:
        """Show what is dragged now; None: nothing is."""
        if held is None or held.name != self._name:
            self._scene.remove_by_name("/held")
            self._frame, self._name = None, ""
        if held is None:
            return
        if self._frame is None:
            self._name = held.name
            self._frame = self._scene.add_frame("/held", axes_length=AXES, axes_radius=AXES * 0.02)
            self._scene.add_label(
                "/held/name", held.name, font_screen_scale=0.8, anchor="bottom-center"
            )
        place(self._frame, held.T_world_held)

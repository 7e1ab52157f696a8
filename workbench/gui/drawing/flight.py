"""The camera of one browser flies to what its person has chosen in a table."""

import threading
import time

import numpy as np

from workbench.gui.scene.stage import STAGE
from workbench.gui.shared.visitor import Visitor
from workbench.model.geometry import Floats

FLIGHT, FRAMES = 0.25, 8
"""[s] How long it takes, and the pictures on the way."""

NEAREST_VIEW, FARTHEST_VIEW = 0.35, 0.9
"""[m] The camera ends between these away from what was chosen: it sees the hand and the bin."""

TINY = 1e-9
"""[m] A camera that stands at the point it looks at has no direction."""

Camera = tuple[Floats, Floats]
"""Position of a camera and the point it looks at, each (3,) [m]."""


def camera_near(seen: Camera, point: Floats) -> Camera:
    """The camera that looks at a point (3,) [m] along the same direction, from not too far."""
    position, centre = seen
    away = position - centre
    distance = max(float(np.linalg.norm(away)), TINY)
    return point + away / distance * float(np.clip(distance, NEAREST_VIEW, FARTHEST_VIEW)), point


def camera_between(begin: Camera, end: Camera, share: float) -> Camera:
    """The camera on its way, after a share 0..1 of the time; it starts and ends gently."""
    eased = share * share * (3.0 - 2.0 * share)
    position, centre = (a + (b - a) * eased for a, b in zip(begin, end, strict=True))
    return position, centre


class CameraFlight:
    """Takes the camera of one browser along; a newer flight ends an older one.

    Concurrency: any thread; each flight is a short thread of its own.
    """

    def __init__(self, visitor: Visitor):
        """The camera stays where it is."""
        self._visitor = visitor
        self._number = 0

    def fly_to(self, point: Floats) -> None:
        """Fly to a point (3,) [m] in the world, unless the person sees something else now.

        While a plan is played the view decides whether it counts as watched; while the part stands
        alone there is no cell.
        """
        visitor, client = self._visitor, self._visitor.client
        is_alone = client.scene.get_handle_by_name(STAGE) is not None
        if is_alone or visitor.look.now.is_playing or client.camera.update_timestamp == 0.0:
            return
        begin = np.array(client.camera.position), np.array(client.camera.look_at)
        self._number += 1
        frames = 1 if visitor.wants_less_motion else FRAMES
        arguments = (self._number, begin, camera_near(begin, point), frames)
        threading.Thread(target=self._fly, args=arguments, name="camera", daemon=True).start()

    def _fly(self, number: int, begin: Camera, end: Camera, frames: int) -> None:
        client = self._visitor.client
        for frame in range(1, frames + 1):
            if number != self._number:
                return
            with client.atomic():
                client.camera.position, client.camera.look_at = camera_between(
                    begin, end, frame / frames
                )
            if frame < frames:
                time.sleep(FLIGHT / FRAMES)

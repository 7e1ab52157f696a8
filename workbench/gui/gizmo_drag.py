"""Drags of a gizmo that can be believed.

A browser that draws slowly may let a person take hold of a gizmo whose own pose it has not set
yet: then what it sends begins at the origin, not where the gizmo stands (viser 1.1.1, seen with two
frames a second).  A bin would be moved by half a metre by somebody who meant a centimetre.
"""

from typing import Literal

import numpy as np
import pinocchio as pin

MOST_AT_ONCE = 0.12
"""[m] A hand does not move a gizmo farther than this until the first message comes."""

NOT_BELIEVED = (
    "Drag it again",
    "This browser drew too slowly and sent another place than the one seen; nothing was moved.",
)
"""What a person is told."""


class GizmoDrag:
    """One drag after the other of one gizmo.

    Concurrency: callbacks of viser, which may overtake each other; flags only.
    """

    def __init__(self) -> None:
        self._is_new = True
        self._is_believed = True

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
        elif self._is_new:
            self._is_new = False
            shift = float(np.linalg.norm(T_now.translation - T_before.translation))
            self._is_believed = shift <= MOST_AT_ONCE
        return self._is_believed

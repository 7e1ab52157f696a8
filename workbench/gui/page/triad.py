"""The axes of the world as the camera of one browser sees them, small, in a corner of the scene."""

import numpy as np
import pinocchio as pin

from workbench.gui.shared.visitor import Visitor
from workbench.model.geometry import Floats

SIZE, LENGTH, LETTER = 60, 18.0, 25.0
"""[px] The side of the drawing, how long an axis is, and how far its letter is from the middle."""

AXES = (("x", "#d6303f"), ("y", "#23863a"), ("z", "#1f6fd0"))
"""Each axis with its colour, as the frames in the scene have it."""

SAME_WITHIN = 1e-3
"""Of a quaternion: a camera that turns by less is not drawn anew."""


class Triad:
    """Follows the camera of its browser at each drawing.

    Concurrency: the renderer's thread.
    """

    def __init__(self, visitor: Visitor):
        """Nothing is seen until the browser has said where its camera is."""
        self._client = visitor.client
        self._drawn = np.zeros(4)
        self._html = visitor.gui.add_html("")

    def show(self) -> None:
        """Draw the axes as the camera is turned now."""
        camera = self._client.camera
        if camera.update_timestamp == 0.0:
            return
        turn = np.asarray(camera.wxyz, dtype=np.float64)
        if np.abs(turn - self._drawn).max() < SAME_WITHIN or np.linalg.norm(turn) < 0.5:
            return
        self._drawn = turn.copy()
        self._html.content = triad_html(turn)


def triad_html(turn: Floats) -> str:
    """The axes as SVG for a camera; what is near is drawn last.

    Args:
        turn: of the camera's frame, which looks along z with y down: a quaternion (4,), no unit.
    """
    w, x, y, z = turn.tolist()
    seen = pin.Quaternion(w, x, y, z).normalized().matrix().T
    lines = [
        (float(seen[2, k]), _axis(name, colour, seen[:2, k]))
        for k, (name, colour) in enumerate(AXES)
    ]
    drawn = "".join(line for _, line in sorted(lines, reverse=True))
    middle = SIZE / 2
    return (
        f'<div class="wb-triad" title="Axes of the world"><svg width="{SIZE}" height="{SIZE}" '
        f'viewBox="{-middle} {-middle} {SIZE} {SIZE}" aria-hidden="true">{drawn}</svg></div>'
    )


def _axis(name: str, colour: str, along: Floats) -> str:
    """A line from the middle, and the letter behind its end; `along` (2,), no unit, is the axis."""
    (x, y), (u, v) = along * LENGTH, along * LETTER
    return (
        f'<line x2="{x:.1f}" y2="{y:.1f}" stroke="{colour}" stroke-width="2.5" '
        f'stroke-linecap="round"/><text x="{u:.1f}" y="{v:.1f}" fill="{colour}">{name}</text>'
    )

"""A point on the surface of the part, moved by keys: what a click does with a pointer."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pinocchio as pin

from workbench.gui.grasps.views import POINT_KEYS, point_box, point_line
from workbench.gui.scene.stage import T_WORLD_STAGE, GraspStage
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
from workbench.model.geometry import Floats, Mesh
from workbench.model.part import Part
from workbench.planning.grasps.grasp_frames import outward_normal
from workbench.planning.grasps.part_rays import NO_TRIANGLE, first_hits

KEY_STEP, FINE_KEY_STEP = 0.002, 0.0002
"""[m] Steps of the arrow keys, and those with Shift, across what is seen."""

Met = tuple[Floats, Floats]
"""A point of a surface (3,) [m], and the outward unit normal (3,) there."""


class SurfaceKeys:
    """The box that takes the keys, the mark on the part, and the line that says where it is.

    Concurrency: callbacks of viser; the point and its part are replaced as a whole.
    """

    def __init__(
        self,
        visitor: Visitor,
        stage: GraspStage,
        taken: Callable[[Floats, Floats], object],
        ended: Callable[[], object],
    ):
        """Add the box, which nobody sees before `show`.

        Args:
            visitor: whose browser.
            stage: where the part is drawn.
            taken: called with point (3,) [m] and outward normal (3,) where a grasp is wanted.
            ended: called when none is wanted.
        """
        self._visitor, self._stage, self._taken, self._ended = visitor, stage, taken, ended
        self._part: Part | None = None
        self._met: Met | None = None
        gui = visitor.gui
        self._box, self._said = gui.add_html(""), gui.add_html(point_line(""))
        steps = [
            partial(self._move, across, down, step)
            for step in (KEY_STEP, FINE_KEY_STEP)
            for across, down in ((-1, 0), (1, 0), (0, -1), (0, 1))
        ]
        pressed = (*steps, self._take, lambda: self._ended())
        self._buttons = dict(zip(POINT_KEYS, map(visitor.unseen, pressed), strict=True))
        visitor.hide(self._buttons.values())

    def show(self, part: Part | None) -> None:
        """Mark the middle of what is seen of a part, and take keys; None: no more."""
        if part is self._part:
            return
        self._part, self._met = part, None
        self._box.content = "" if part is None else point_box(self._buttons)
        if part is None:
            self._said.content = point_line("")
            self._stage.mark(None)
            return
        points = np.asarray(part.mesh.points)
        self._go_to((points.min(axis=0) + points.max(axis=0)) / 2)

    def _move(self, across: int, down: int, step: float) -> None:
        if self._met is None:
            return
        w, x, y, z = self._visitor.client.camera.wxyz
        R = pin.Quaternion(w, x, y, z).normalized().matrix()
        self._go_to(self._met[0] + step * (across * R[:, 0] + down * R[:, 1]))

    def _go_to(self, aim: Floats) -> None:
        """Mark what is seen in the direction of a point (3,) [m], if the part is there."""
        if self._part is None:
            return
        eye = np.asarray(self._visitor.client.camera.position) - T_WORLD_STAGE.translation
        met = seen_at(self._part.mesh, eye, aim)
        self._met = met or self._met
        if self._met is None:
            return
        x, y, z = self._met[0].tolist()
        text = GraspText.POINT if met else GraspText.POINT_AT_EDGE
        self._said.content = point_line(self._visitor.words.render(text(x=x, y=y, z=z)))
        self._stage.mark(self._met[0])

    def _take(self) -> None:
        if self._met is not None:
            self._taken(*self._met)


def seen_at(mesh: Mesh, eye: Floats, aim: Floats) -> Met | None:
    """The first point of a surface on the ray from `eye` through `aim`, each (3,) [m]; or None."""
    ray = aim - eye
    far = float(np.linalg.norm(ray))
    if far == 0.0:
        return None
    distances, met = first_hits(mesh, eye[None], (ray / far)[None])
    if met[0] == NO_TRIANGLE:
        return None
    return eye + distances[0] / far * ray, outward_normal(mesh, int(met[0]))

"""Verdicts while something is dragged, over what all see: strokes, parts in colour, and words."""

import numpy as np
import viser

from workbench.app.picking.glance import Glance
from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.candidate import strokes_of
from workbench.gui.scene.marks import add_lines
from workbench.gui.shared.colours import BAD, GOOD, rgb_of, verdict_colour
from workbench.gui.shared.own import Dragged
from workbench.gui.shared.solids import with_hard_edges
from workbench.model.candidate import kind_said

WORDS = "/dragged"

ABOVE = 0.06
"""[m] The words stand so far above what is dragged."""


class DrawnVerdicts:
    """A stroke for each candidate as it would be judged, and each part green that one would take.

    In viser a node of one browser takes the place of the shared one of that name: the strokes and
    the surfaces of the parts that all see are back once these are removed.

    Concurrency: the renderer's thread.
    """

    def __init__(self, scene: viser.SceneApi):
        """Nothing is dragged."""
        self._scene = scene
        self._words: viser.LabelHandle | None = None
        self._meshes: dict[int, viser.MeshHandle] = {}

    def draw(self, dragged: Dragged | None) -> None:
        """Show what would come of it; None: nothing is dragged any more."""
        if dragged is None:
            self._clear()
            return
        glance = dragged.glance
        if len(glance.tips):
            colours = [rgb_of(verdict_colour(kind)) for kind in kinds_in(glance)]
            strokes, painted = strokes_of(glance.tips, glance.approaches, np.array(colours))
            add_lines(self._scene, "/grasps", strokes, painted, 2.0)
        self._paint_parts(dragged)
        if self._words is None:
            self._words = self._scene.add_label(
                WORDS, "", font_screen_scale=1.0, anchor="bottom-center", depth_test=False
            )
        text = live_words(glance)
        if self._words.text != text:
            self._words.text = text
        self._words.position = dragged.T_world_words.translation + np.array([0.0, 0.0, ABOVE])

    def _paint_parts(self, dragged: Dragged) -> None:
        glance, cell = dragged.glance, dragged.state.cell
        able = set(glance.detections[glance.working].tolist())
        for number, one in enumerate(dragged.state.detections or ()):
            colour = rgb_of(GOOD if number in able else BAD)
            if number not in self._meshes:
                points, triangles = with_hard_edges(triangles_of(cell.part(one.part).mesh))
                self._meshes[number] = self._scene.add_mesh_simple(
                    f"/parts/part-{number + 1}/mesh", points, triangles, color=colour, opacity=0.9
                )
            elif self._meshes[number].color != colour:
                self._meshes[number].color = colour

    def _clear(self) -> None:
        if self._words is None:
            return
        for number in self._meshes:
            self._scene.remove_by_name(f"/parts/part-{number + 1}/mesh")
        self._scene.remove_by_name("/grasps")
        self._scene.remove_by_name(WORDS)
        self._words, self._meshes = None, {}


def kinds_in(glance: Glance) -> list[str]:
    """What is said of each candidate."""
    return [
        kind_said(reason, is_apart=is_apart)
        for reason, is_apart in zip(glance.reasons, glance.is_apart.tolist(), strict=True)
    ]


def live_words(glance: Glance) -> str:
    """How many would work, and how far that was looked at, in one sentence."""
    count, whole = int(glance.working.sum()), len(glance.reasons)
    return f"while you drag: {count} of {whole} work, as far as hand, reach and place say"

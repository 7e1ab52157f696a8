"""While something is dragged, over what all see: the thing, strokes, parts in colour, and words."""

import itertools

import numpy as np
import viser

from workbench.app.picking.glance import Glance
from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.candidate import strokes_of
from workbench.gui.scene.marks import add_lines
from workbench.gui.scene.robot import place
from workbench.gui.scene.stage import T_WORLD_STAGE
from workbench.gui.scene.surroundings import BrowserCamera
from workbench.gui.shared.colours import BAD, GOOD, rgb_of, verdict_colour
from workbench.gui.shared.own import Carried, Dragged
from workbench.gui.shared.solids import with_hard_edges
from workbench.gui.texts.scene import PosePageText
from workbench.model.candidate import Reason, kind_of
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message

WORDS = "/dragged"

STAGE_SIZE = 100.0
"""[m] Around where a part stands alone there is nothing else."""

TEXT_OFFSET = 0.02
"""[m] The words stand this far beside the bin and what is dragged."""


class DrawnVerdicts:
    """A stroke for each candidate as it would be judged, and each part green that one would take.

    In viser a node of one browser takes the place of the shared one of that name: the strokes and
    the surfaces of the parts that all see are back once these are removed.

    Concurrency: the renderer's thread.
    """

    def __init__(self, scene: viser.SceneApi, camera: BrowserCamera):
        """Nothing is dragged.

        Args:
            scene: of one browser.
            camera: of that browser.
        """
        self._scene, self._camera = scene, camera
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
                WORDS, "", font_screen_scale=1.0, anchor="center-left", depth_test=False
            )
        text = str(short_message(glance))
        if self._words.text != text:
            self._words.text = text
        self._words.position = right_of(self._camera, _corners_around(dragged))

    def _paint_parts(self, dragged: Dragged) -> None:
        glance, cell = dragged.glance, dragged.state.cell
        able = set(glance.detections[glance.working].tolist())
        for number, detection in enumerate(dragged.state.detections or ()):
            colour = rgb_of(GOOD if number in able else BAD)
            if number not in self._meshes:
                points, triangles = with_hard_edges(triangles_of(cell.part(detection.part).mesh))
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


class DrawnCarried:
    """What a person drags, where it is dragged to, in one browser alone.

    As `DrawnVerdicts`: frames of this browser take the place of those that all see, and what
    hangs below them follows.

    Concurrency: the renderer's thread.
    """

    def __init__(self, scene: viser.SceneApi):
        """Nothing is dragged."""
        self._scene = scene
        self._frames: dict[str, viser.FrameHandle] = {}

    def draw(self, carried: Carried | None) -> None:
        """Show it there; None: all is where everybody sees it."""
        Ts_node = carried.Ts_node if carried is not None else {}
        for name in self._frames.keys() - Ts_node.keys():
            self._scene.remove_by_name(name)
            del self._frames[name]
        for name, T in Ts_node.items():
            if name not in self._frames:
                self._frames[name] = self._scene.add_frame(name, show_axes=False)
            place(self._frames[name], T)


def _corners_around(dragged: Dragged) -> Floats:
    """Corners (n, 3) [m] around what words must not lie upon: bin and parts, or one part alone."""
    cell, at = dragged.state.cell, dragged.T_world_words.translation
    unit = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    reach = {
        part.name: float(np.linalg.norm(part.mesh.points, axis=1).max()) for part in cell.parts
    }
    if np.linalg.norm(at - T_WORLD_STAGE.translation) < STAGE_SIZE:
        return T_WORLD_STAGE.translation + max(reach.values()) * unit
    half, T = np.asarray(cell.bin.size) / 2, cell.bin.T_world_bin
    corners = [(unit * half + [0.0, 0.0, half[2]]) @ T.rotation.T + T.translation, at[None]]
    for detection in dragged.state.detections or ():
        corners.append(detection.T_world_part.translation + reach[detection.part] * unit)
    return np.concatenate(corners)


def right_of(camera: BrowserCamera, points: Floats) -> Floats:
    """A point (3,) [m] at the right of all points (n, 3) [m], as a camera sees them."""
    away = points.mean(axis=0) - camera.position
    right = np.cross(away, camera.up_direction)
    right /= max(float(np.linalg.norm(right)), 1e-9)
    offsets = points - points.mean(axis=0)
    # What is nearer to the camera is seen farther from the middle.
    depth = np.linalg.norm(away)
    nearer = depth / np.maximum(depth + offsets @ away / depth, 0.1 * depth)
    return points.mean(axis=0) + (float((offsets @ right * nearer).max()) + TEXT_OFFSET) * right


def kinds_in(glance: Glance) -> list[Reason]:
    """What is said of each candidate."""
    return [
        kind_of(reason, is_apart=is_apart)
        for reason, is_apart in zip(glance.reasons, glance.is_apart.tolist(), strict=True)
    ]


def live_message(glance: Glance) -> Message:
    """How many would work, and how far that was checked, in one sentence."""
    return PosePageText.DRAGGED(count=int(glance.working.sum()), total=len(glance.reasons))


def short_message(glance: Glance) -> Message:
    """The same in the scene, where there is little room beside the bin; the panel says it whole."""
    return PosePageText.WORKING(count=int(glance.working.sum()), total=len(glance.reasons))

"""Where the hand of the chosen grasp is: numbers, gizmo, keys, and the surface to snap to."""

from collections.abc import Callable, Mapping

import numpy as np
import pinocchio as pin
import viser
from viser._messages import HotkeyKey

from workbench.app.core.cell.part_edits import EditPart
from workbench.gui.dragging.gizmo_drag import add_gizmo, follow
from workbench.gui.dragging.verdicts import LiveVerdicts
from workbench.gui.dragging.views import dragged_html
from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.views import no_grasp
from workbench.gui.scene.robot import place
from workbench.gui.scene.stage import T_WORLD_STAGE
from workbench.gui.shared.look import View
from workbench.gui.shared.movable_frames import ANGLES, shown_pose, typed_pose
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
from workbench.model.digest import digest_of
from workbench.model.errors import WorkbenchError
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.commands import GraspEditText
from workbench.model.messages.message import plain
from workbench.model.part import Entry
from workbench.model.part_edits import grasp_of
from workbench.planning.grasps.grasp_frames import snap_to_surface

TOOL_AXES, PART_AXES = "the tool", "the part"

SNAP_DISTANCE, SNAP_ANGLE = 0.001, np.deg2rad(5.0)
"""[m, rad] Of the gizmo when it goes in steps, and of the keys."""

GIZMO = 0.45
"""Size of the gizmo by that of the part."""

NUDGES: Mapping[HotkeyKey, tuple[str, tuple[float, float, float]]] = {
    "4": ("-x", (-SNAP_DISTANCE, 0.0, 0.0)),
    "6": ("+x", (SNAP_DISTANCE, 0.0, 0.0)),
    "2": ("-y", (0.0, -SNAP_DISTANCE, 0.0)),
    "8": ("+y", (0.0, SNAP_DISTANCE, 0.0)),
    "3": ("-z, away", (0.0, 0.0, -SNAP_DISTANCE)),
    "9": ("+z, into the part", (0.0, 0.0, SNAP_DISTANCE)),
}
"""Keys that move the hand along the tool's axes."""


class GraspPose:
    """Position and angles of the hand in the part's frame, and what moves it.

    Concurrency: callbacks of viser and the renderer's thread; handles, and the entry as this
    browser has seen it, which an edit replaces.
    """

    def __init__(self, visitor: Visitor, editing: Editing, moving: Callable[[pin.SE3], None]):
        """Add the controls; `moving` is called with where the hand is while it is dragged."""
        self._visitor, self._editing, self._moving = visitor, editing, moving
        self._verdicts = LiveVerdicts(visitor, EditPart)
        self._seen: Entry | None = None
        self._T = pin.SE3.Identity()
        self._R_off = np.eye(3)
        self._gizmo: viser.TransformControlsHandle | None = None
        gui = visitor.gui
        self._position = gui.add_vector3(
            "Position [mm]",
            (0.0, 0.0, 0.0),
            step=0.1,
            hint="Of the tool's tip, in the part's frame.",
        )
        self._angles = gui.add_vector3(
            "Angles [deg]", (0.0, 0.0, 0.0), step=0.1, hint="Roll, pitch, yaw: fixed axes."
        )
        visitor.name(self._angles, ANGLES)
        self._axes = gui.add_dropdown(
            "Gizmo along", (TOOL_AXES, PART_AXES), hint="Whose axes the gizmo moves along."
        )
        self._steps = gui.add_checkbox(
            "Snap", False, hint="The gizmo moves by whole 1 mm and turns by whole 5 degrees."
        )
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._apply = gui.add_button("Move it there", icon=viser.Icon.CHECK)
        self._snap = gui.add_button(
            "Snap to surface",
            icon=viser.Icon.MAGNET,
            color="gray",
            hint="Square to the surface where the tool comes in, as deep as fingers hold well.",
        )
        self._told = gui.add_html("")
        self._apply.on_click(lambda _: self._end(self._read_pose(), GraspEditText.MOVED_BY_NUMBERS))
        self._snap.on_click(lambda _: self._on_snap())
        self._axes.on_update(lambda _: self._place_gizmo())
        for key, (says, step) in NUDGES.items():
            label = visitor.words.render(GraspText.NUDGE(direction=plain(says)))
            visitor.on_key(key, label, lambda step=step: self._nudge(step))

    def show(self, entry: Entry | None, *, problem: str, is_open: bool, size: float) -> None:
        """The chosen grasp is `entry` now; the gizmo is there while the stage is open."""
        problem = problem or no_grasp(entry)
        can = not problem
        for button in (self._apply, self._snap):
            self._visitor.allow(button, problem)
        self._position.disabled = self._angles.disabled = not can
        is_other = digest_of(entry) != digest_of(self._seen)
        self._seen = entry
        if entry is not None and is_other:
            self._put(grasp_of(entry).T_part_tcp)
        if can and is_open and self._gizmo is None:
            self._add_gizmo(size)
        elif not (can and is_open):
            self.hide()

    def on_typed(self, observer: Callable[[], None]) -> None:
        """Have something called after a number of the pose has changed."""
        for numbers in (self._position, self._angles):
            numbers.on_update(lambda _: observer())

    def is_typed(self) -> bool:
        """Whether numbers were typed to which the hand was not moved."""
        typed = (self._position.value, self._angles.value)
        return self._seen is not None and typed != shown_pose(self._T)

    def revert(self) -> None:
        """Show the numbers of the chosen grasp again."""
        self._put(self._T)

    def show_drag(self, old: View | None, new: View) -> None:
        """Show the values as the hand is dragged from `old` to `new`."""
        if old is None or old.own.dragged is not new.own.dragged:
            self._told.content = dragged_html(new.own.dragged, words=self._visitor.words)

    def hide(self) -> None:
        """Take the gizmo away."""
        gizmo, self._gizmo = self._gizmo, None
        if gizmo is not None:
            self._verdicts.end()
            gizmo.remove()

    def _put(self, T: pin.SE3) -> None:
        self._T = pin.SE3(T)
        self._position.value, self._angles.value = shown_pose(T)
        self._place_gizmo()

    def _place_gizmo(self) -> None:
        is_of_tool = self._axes.value == TOOL_AXES
        self._R_off = np.eye(3) if is_of_tool else np.array(self._T.rotation)
        if self._gizmo is not None:
            R = self._T.rotation if is_of_tool else np.eye(3)
            place(self._gizmo, pin.SE3(np.array(R), self._T.translation))

    def _read_pose(self) -> pin.SE3:
        return typed_pose(self._position.value, self._angles.value)

    def _nudge(self, step: tuple[float, float, float]) -> None:
        if self._gizmo is not None:
            self._end(self._T * pose_from_rpy(step), GraspEditText.NUDGED)

    def _on_snap(self) -> None:
        try:
            T = self._editing.with_checker(lambda checker: snap_to_surface(checker, self._T))
        except WorkbenchError as error:
            self._visitor.notify("Refused", str(error))
            return
        self._end(T, GraspEditText.SNAPPED)

    def _end(self, T: pin.SE3, says: GraspEditText) -> None:
        """A person wants the hand there."""
        entry = self._seen
        if entry is None:
            return
        if not self._editing.move(entry, T, says(grasp=entry.name)):
            self._put(self._T)

    def _add_gizmo(self, size: float) -> None:
        self._gizmo = gizmo = add_gizmo(self._visitor, "/stage/gizmo", GIZMO * size, self._T)
        self._place_gizmo()
        self._verdicts.prepare()
        follow(
            gizmo,
            self._visitor,
            stood=lambda: self._T,
            moved=self._on_dragged,
            began=self._verdicts.begin,
            put_back=self._put_back,
        )

    def _on_dragged(self, T_part_gizmo: pin.SE3, is_over: bool) -> None:
        T = pin.SE3(T_part_gizmo.rotation @ self._R_off, T_part_gizmo.translation)
        if self._steps.value:
            T = in_steps(self._T, T)
        # From the numbers that are shown: what a person reads is what is meant.
        self._position.value, self._angles.value = shown_pose(T)
        self._moving(self._read_pose())
        if is_over:
            self._verdicts.end()
            self._end(self._read_pose(), GraspEditText.MOVED_BY_GIZMO)
        elif self._seen is not None:
            change = self._editing.moving(self._seen, self._read_pose())
            self._verdicts.ask({"change": change}, T_WORLD_STAGE * self._read_pose())

    def _put_back(self) -> None:
        self._verdicts.end()
        self._put(self._T)


def in_steps(T_from: pin.SE3, T_to: pin.SE3) -> pin.SE3:
    """The pose nearest to `T_to` that is whole steps away from `T_from`, along its axes."""
    difference = T_from.actInv(T_to)
    shift = np.round(difference.translation / SNAP_DISTANCE) * SNAP_DISTANCE
    turn = pin.log3(difference.rotation)
    angle = float(np.linalg.norm(turn))
    whole = round(angle / SNAP_ANGLE) * SNAP_ANGLE
    R = pin.exp3(turn * (whole / angle)) if angle > 1e-9 else np.eye(3)
    return T_from * pin.SE3(R, shift)

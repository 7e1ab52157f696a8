"""The hand of the chosen grasp put where another grasp has it, and some way from there."""

import viser

from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.views import no_grasp
from workbench.gui.shared.movable_frames import ANGLES, shown_pose, typed_pose
from workbench.gui.shared.visitor import Visitor
from workbench.model.digest import digest_of
from workbench.model.messages.commands import GraspEditText
from workbench.model.part import Entry, Part
from workbench.model.part_edits import grasp_of

NONE: str = "no other grasp"


class GraspOffset:
    """An offset in the frame of another grasp's hand; what is kept is the pose, no link.

    Concurrency: callbacks of viser and the renderer's thread; handles, and the entry as this
    browser has seen it, which an edit replaces.
    """

    def __init__(self, visitor: Visitor, editing: Editing):
        """Add the controls."""
        self._visitor, self._editing = visitor, editing
        self._seen: Entry | None = None
        self._filled = ""
        gui = visitor.gui
        self._from = gui.add_dropdown(
            "Relative to",
            (NONE,),
            hint="Another grasp of the part, in whose hand's frame it is.",
        )
        self._shift = gui.add_vector3(
            "Offset [mm]", (0.0, 0.0, 0.0), step=0.1, hint="Along x, y and z of that grasp's hand."
        )
        self._turn = gui.add_vector3(
            "Turn [deg]", (0.0, 0.0, 0.0), step=0.1, hint="Roll, pitch, yaw: fixed axes."
        )
        visitor.name(self._turn, ANGLES)
        self._put = gui.add_button(
            "Apply offset",
            icon=viser.Icon.ARROWS_RIGHT_DOWN,
            color="gray",
            hint="Once: the grasp stays there when the other one is moved.",
        )
        self._from.on_update(lambda _: self._fill())
        self._put.on_click(lambda _: self._take())

    def show(self, part: Part, entry: Entry | None, *, problem: str) -> None:
        """The chosen grasp is `entry` now; the offset is where it is, until one is typed."""
        self._seen = entry
        others = tuple(
            known_entry.name
            for known_entry in part.library.entries
            if entry is None or known_entry.name != entry.name
        )
        names = others or (NONE,)
        if self._from.options != names:
            self._from.options = names
        lacks = "" if others else "there is no other grasp"
        self._visitor.allow(self._put, problem or no_grasp(entry) or lacks)
        for control in (self._from, self._shift, self._turn):
            control.disabled = bool(problem or lacks)
        self._fill()

    def _reference(self) -> Entry | None:
        entries = {entry.name: entry for entry in self._editing.part.library.entries}
        return entries.get(self._from.value)

    def _fill(self) -> None:
        """Fill in where the grasp is as seen from the other one, once for each pair of poses."""
        entry, other = self._seen, self._reference()
        if entry is None or other is None:
            return
        T_part_tcp, T_part_other = grasp_of(entry).T_part_tcp, grasp_of(other).T_part_tcp
        key = digest_of((entry.name, T_part_tcp, other.name, T_part_other))
        if key != self._filled:
            self._filled = key
            self._shift.value, self._turn.value = shown_pose(T_part_other.actInv(T_part_tcp))

    def _take(self) -> None:
        entry, other = self._seen, self._reference()
        if entry is not None and other is not None:
            T_other_tcp = typed_pose(self._shift.value, self._turn.value)
            T_part_tcp = grasp_of(other).T_part_tcp * T_other_tcp
            self._editing.move(
                entry, T_part_tcp, GraspEditText.OFFSET(grasp=entry.name, other=other.name)
            )

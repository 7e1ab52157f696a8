"""The tab in which grasps are put on the part: by clicking on it, gizmo, numbers, patterns."""

import logging
import threading
from concurrent.futures import ThreadPoolExecutor

import pinocchio as pin
import viser

from workbench.app.core.cell.changes import RedoCell, UndoCell
from workbench.app.core.cell.part_edits import EditPart
from workbench.app.statistics.grasp_use import NO_USES, Uses
from workbench.gui.grasps.copies import GraspCopies
from workbench.gui.grasps.coverage import CoverageControls
from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.fields import GraspFields
from workbench.gui.grasps.filling import FillControls
from workbench.gui.grasps.ideas import Suggestions, SymmetryControls
from workbench.gui.grasps.library import LibraryControls, PairControls
from workbench.gui.grasps.offset import GraspOffset
from workbench.gui.grasps.part_upload import PartUpload
from workbench.gui.grasps.pose import GraspPose
from workbench.gui.grasps.stepping import CopySteps
from workbench.gui.grasps.surface_keys import SurfaceKeys, seen_at
from workbench.gui.grasps.views import MOST_ROWS, check_line, grasps_html, no_grasp
from workbench.gui.help.groups import group
from workbench.gui.scene.stage import GraspStage, nearest_entry, size_of
from workbench.gui.shared.look import View
from workbench.gui.shared.views import not_redone, not_undone
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
from workbench.model.digest import digest_of
from workbench.model.geometry import Floats
from workbench.model.messages.commands import GraspEditText
from workbench.model.part import Entry, Grasp, Part, grasps_of
from workbench.model.part_edits import grasp_of
from workbench.planning.grasps.grasp_check import GraspCheck
from workbench.planning.grasps.grasp_frames import PLAY, fitted_opening, frame_at

log = logging.getLogger(__name__)

WIDEST_OPENING = PLAY
"""[m] Opening and grip of a grasp with nothing between its fingers."""


class GraspsPanel:
    """The list of grasps, the stage, and the controls of the chosen grasp.

    Concurrency: callbacks of viser, the renderer's thread, and one thread that looks at all
    grasps of the part; what they change are handles, and `_checks` as a whole.  The stage is drawn
    on under `_drawing`.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._editing = Editing(visitor)
        self._stage = GraspStage(visitor.client)
        self._is_adding = False
        self._checks: dict[str, GraspCheck | None] = {}
        self._checked = ""
        self._uses: Uses = NO_USES
        self._drawing = threading.RLock()
        self._has_ended = False
        self._looker = ThreadPoolExecutor(1, thread_name_prefix="grasp checks")
        gui, editing = visitor.gui, self._editing
        with group(gui, "New part from a CAD file", expand_by_default=False):
            self._upload = PartUpload(visitor)
        parts = tuple(part.name for part in visitor.cell.parts)
        self._part = gui.add_dropdown("Part", parts, hint="Whose grasps are listed and edited.")
        self._tool = gui.add_dropdown(
            "Tool", tuple(editing.tools), hint="What grasps are tried with.",
            visible=len(editing.tools) > 1,
        )  # fmt: skip
        gui.add_html('<div class="wb-buttons wb-three"></div>')
        self._open = gui.add_button("Edit grasps", icon=viser.Icon.CUBE)
        self._undo = gui.add_button("Undo", icon=viser.Icon.ARROW_BACK_UP, color="gray")
        self._redo = gui.add_button("Redo", icon=viser.Icon.ARROW_FORWARD_UP, color="gray")
        self._table = gui.add_html("")
        self._line = gui.add_html("")
        self._add = gui.add_button(
            "Add grasp",
            icon=viser.Icon.PLUS,
            hint="Then click on the surface of the part, or move a point by the arrow keys.",
        )
        self._duplicate = gui.add_button("Duplicate", icon=viser.Icon.COPY, color="gray")
        self._delete = gui.add_button("Delete", icon=viser.Icon.TRASH, color="red")
        self._keep = gui.add_button(
            "Keep mine",
            icon=viser.Icon.COPY,
            color="orange",
            visible=False,
            hint="As a copy beside what somebody else made of it.",
        )
        self._point = SurfaceKeys(visitor, self._stage, self._put, self._end_adding)
        self._steps = CopySteps(visitor, editing, self._on_step, lambda: self._stage.is_open)
        with group(gui, "Where the hand is") as pose:
            self._pose = GraspPose(visitor, editing, self._moving)
            self._offset = GraspOffset(visitor, editing)
        with group(gui, "How it takes the part", expand_by_default=False) as fields:
            self._fields = GraspFields(visitor, editing)
        with group(gui, "Copies and patterns", expand_by_default=False) as copies:
            self._copies = GraspCopies(visitor, editing)
        self._of_grasp = (pose, fields, copies)
        with group(gui, "Suggestions", expand_by_default=False):
            self._suggestions = Suggestions(visitor, editing, self._preview)
            self._filling = FillControls(visitor, editing)
        with group(gui, "Coverage of resting poses", expand_by_default=False):
            self._coverage = CoverageControls(visitor, editing, self._stage)
        with group(gui, "Symmetry of the part", expand_by_default=False):
            self._symmetry = SymmetryControls(visitor, editing)
        with group(gui, "Pairs for two arms", expand_by_default=False):
            self._pairs = PairControls(visitor, editing)
        with group(gui, "Save and versions"):
            self._library = LibraryControls(visitor, editing, self._not_applied)
        self._rows = visitor.rows(MOST_ROWS, self._chose)
        self._react()

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        look = new.look
        if look.is_playing and look.browser == self._visitor.number and self._stage.is_open:
            # Who lets the plan play wants to see the cell.
            self._turn()
        is_counted = old is None or old.statistics is not new.statistics
        if is_counted:
            self._uses = new.statistics.grasps()
        if is_counted or old is None or old.state is not new.state:
            self._draw()
        self._pose.show_drag(old, new)

    def _react(self) -> None:
        visitor, editing = self._visitor, self._editing
        self._part.on_update(lambda _: self._other_part(self._part.value))
        self._tool.on_update(lambda _: editing.choose(tool=self._tool.value))
        self._open.on_click(lambda _: self._turn())
        self._add.on_click(lambda _: self._begin_to_add())
        self._duplicate.on_click(lambda _: self._copies.duplicate())
        self._delete.on_click(lambda _: self._on_delete())
        self._keep.on_click(lambda _: self._on_keep())
        visitor.on_press(self._undo, UndoCell)
        visitor.on_press(self._redo, RedoCell)
        visitor.on_key("G", "Open the part to put grasps on it, or go back", self._turn)
        editing.on_change(self._draw)
        for form in (self._fields, self._pose):
            form.on_typed(self._library.follow_typed)
        editing.not_applied = self._not_applied
        visitor.add_form(self._not_applied)
        visitor.on_end(self._end_drawing)
        visitor.on_end(self._leave_stage, in_scene=True)

    def _chose(self, number: int) -> None:
        entries = self._editing.part.library.entries
        if number < len(entries):
            chosen = self._editing.entry
            if chosen is not None and entries[number].name == chosen.name:
                self._pose.revert()
                self._editing.choose(entry=chosen.name)
                return
            self._editing.turn_to(entry=entries[number].name)

    def _not_applied(self) -> str:
        """What a person does first with what is typed for the chosen grasp; empty: nothing."""
        entry = self._editing.entry
        if entry is None:
            return ""
        words = self._visitor.words
        if self._fields.is_typed():
            return words.render(GraspText.APPLY_FIRST(name=entry.name))
        if self._pose.is_typed():
            return words.render(GraspText.MOVE_FIRST(name=entry.name))
        return ""

    def _other_part(self, name: str) -> None:
        if self._not_applied() and name == self._editing.part.name:
            return
        entries = self._visitor.cell.part(name).library.entries
        if not self._editing.turn_to(part=name, entry=entries[0].name if entries else ""):
            self._part.value = self._editing.part.name
            return
        with self._drawing:
            if self._stage.is_open:
                self._stage.close()
                self._stage.open(self._editing.part, self._on_click)
                self._label_add()
                self._draw()

    def _draw(self) -> None:
        """Show the part's grasps as they are now."""
        with self._drawing:
            if not self._has_ended:
                self._draw_all()

    def _end_drawing(self) -> None:
        """Nothing is drawn from now on: a look at the grasps may end after these controls have."""
        with self._drawing:
            self._has_ended = True
        self._looker.shutdown(wait=False, cancel_futures=True)

    def _draw_all(self) -> None:
        self._list_things()  # which may be a choice
        state, part, entry = self._visitor.bench.state, self._editing.part, self._editing.entry
        cannot = self._visitor.obstacle(state, EditPart)
        name = entry.name if entry is not None else ""
        copy = self._steps.show(state, part, entry)
        self._upload.show(state)
        self._look_at_all(part)
        self._table.content = grasps_html(
            part, name, self._checks, self._rows, self._uses, self._visitor.words
        )
        self._line.content = check_line(name, self._checks.get(name), self._visitor.words)
        admit = self._visitor.admit
        admit(self._add, state, EditPart)
        for button in (self._duplicate, self._delete):
            admit(button, state, EditPart, otherwise=no_grasp(entry))
        admit(self._undo, state, UndoCell, otherwise=not_undone(state))
        admit(self._redo, state, RedoCell, otherwise=not_redone(state))
        for folder in self._of_grasp:
            folder.visible = entry is not None
        self._keep.visible = self._editing.lost is not None
        is_open, size = self._stage.is_open, size_of(part)
        self._pose.show(entry, problem=cannot, is_open=is_open, size=size)
        self._offset.show(part, entry, problem=cannot)
        self._fields.show(entry, problem=cannot)
        self._copies.show(entry, problem=cannot)
        self._suggestions.show(part)
        self._filling.show(problem=cannot)
        self._coverage.show(part, problem=cannot)
        self._symmetry.show(part, problem=cannot)
        self._pairs.show(part, problem=cannot)
        self._library.show(state, part, problem=cannot)
        next_step = self._open if state.is_saved and not self._stage.is_open else None
        visitor = self._visitor
        visitor.emphasise(next_step if state.is_saved else self._library.save_button, "Grasps")
        if is_open:
            bad = frozenset(n for n, check in self._checks.items() if check and not check.is_ok)
            self._stage.draw(part, name, bad)
            self._show_tool(entry)
        if copy is not None:
            self._preview(copy)

    def _list_things(self) -> None:
        """Follow the cell's parts and tools; the part asked for here is taken in hand."""
        tools = tuple(self._editing.tools)
        if self._tool.options != tools:
            self._tool.options, self._tool.visible = tools, len(tools) > 1
        names = tuple(part.name for part in self._visitor.cell.parts)
        if self._part.options != names:
            is_made = self._upload.asked in set(names) - set(self._part.options)
            self._part.options = names
            wanted = self._upload.asked if is_made else self._editing.part.name
            if self._part.value != wanted:
                self._part.value = wanted

    def _show_tool(self, entry: Entry | None) -> None:
        if entry is None:
            self._stage.hide_tool()
            return
        grasp, check = grasp_of(entry), self._checks.get(entry.name)
        is_ok = check is None or check.is_ok
        self._stage.show_tool(self._editing.tool, grasp.T_part_tcp, grasp.opening, is_ok)

    def _look_at_all(self, part: Part) -> None:
        """Have all grasps of the part checked, once for each library and tool."""
        key = digest_of((part.digest, self._editing.tool.name))
        if key != self._checked:
            self._checked = key
            known = {entry.name for entry in part.library.entries}
            self._checks = {n: check for n, check in self._checks.items() if n in known}
            self._looker.submit(self._look, part, key)

    def _look(self, part: Part, key: str) -> None:
        found: dict[str, GraspCheck | None] = {}
        try:
            for entry in part.library.entries:
                if key != self._checked or self._has_ended:
                    return
                checks = [self._editing.check(grasp) for grasp in grasps_of(entry)]
                found[entry.name] = next((check for check in checks if not check.is_ok), checks[0])
            if key == self._checked:
                self._checks = found
                self._draw()
        except Exception:
            # A rim: grasps that cannot be looked at stay in the list, as not looked at.
            log.exception("the grasps of a part could not be looked at")

    def _turn(self) -> None:
        """To the part alone, or back to the cell."""
        with self._drawing:
            self._is_adding = False
            if self._stage.is_open:
                self._leave_stage()
                self._open.label = "Edit grasps"
            else:
                self._visitor.turn_away()
                self._stage.open(self._editing.part, self._on_click)
                self._open.label = "Back to cell"
            self._label_add()
            self._draw()

    def _on_step(self) -> None:
        """Another copy of the chosen grasp is viewed: with the part alone."""
        if self._stage.is_open:
            self._draw()
        else:
            self._turn()

    def _leave_stage(self) -> None:
        with self._drawing:
            if self._stage.is_open:
                self._pose.hide()
                self._stage.close()

    def _begin_to_add(self) -> None:
        if not self._stage.is_open:
            self._turn()
        self._is_adding = not self._is_adding
        self._label_add()

    def _end_adding(self) -> None:
        self._is_adding = False
        self._label_add()

    def _label_add(self) -> None:
        self._add.label = "Now click" if self._is_adding else "Add grasp"
        self._point.show(self._editing.part if self._is_adding else None)

    def _on_click(self, origin: Floats, direction: Floats) -> None:
        """Somebody clicks: a grasp is put there, or the one whose mark is there is chosen."""
        part = self._editing.part
        if not self._is_adding:
            name = nearest_entry(part, origin, direction, size_of(part))
            if name:
                self._editing.turn_to(entry=name)
            return
        met = seen_at(part.mesh, origin, origin + direction)
        if met is not None:
            self._put(*met)

    def _put(self, point: Floats, normal: Floats) -> None:
        """A grasp is wanted at a point (3,) [m] of the surface with this outward normal (3,)."""
        self._end_adding()
        T = self._editing.with_checker(lambda checker: frame_at(checker, point, normal))
        fitted = self._editing.with_checker(lambda checker: fitted_opening(checker, T))
        low, high = self._editing.tool.stroke
        opening, grip = (
            (fitted.opening, fitted.grip) if fitted else (min(low + WIDEST_OPENING, high), low)
        )
        grasp = Grasp(self._editing.free_name("grasp"), T, min(opening, high), min(grip, high))
        self._editing.add((grasp,), GraspEditText.ON_SURFACE(grasp=grasp.name))

    def _on_delete(self) -> None:
        entry = self._editing.entry
        if entry is not None:
            self._editing.remove(entry, (), GraspEditText.DELETED(grasp=entry.name))

    def _on_keep(self) -> None:
        self._editing.keep_lost()

    def _moving(self, T_part_tcp: pin.SE3) -> None:
        """The hand is dragged: show it there, and what speaks against it."""
        entry = self._editing.entry
        if entry is None:
            return
        grasp = self._editing.at(entry, T_part_tcp)
        self._preview(grasp)

    def _preview(self, grasp: Grasp) -> None:
        """Show a grasp that is not, or not yet, in the library."""
        check = self._editing.check(grasp)
        self._line.content = check_line(grasp.name, check, self._visitor.words)
        with self._drawing:
            if self._stage.is_open:
                tool = self._editing.tool
                self._stage.show_tool(tool, grasp.T_part_tcp, grasp.opening, check.is_ok)

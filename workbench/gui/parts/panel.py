"""The tab with the parts found: what speaks for and against each, and a person's word on it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from threading import Timer
from typing import Any

import pinocchio as pin
import viser

from workbench.app.calibration.calibration import check_stands
from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.command import Command
from workbench.app.core.cycle.outcomes import ForgetAvoided
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.formats.files.whole_files import sent_name
from workbench.gui.dragging.pose_inputs import PoseInputs
from workbench.gui.drawing.flight import CameraFlight
from workbench.gui.help.groups import group
from workbench.gui.parts.fates import part_fates
from workbench.gui.parts.keeping import KeepInputs
from workbench.gui.parts.views import (
    avoided_html,
    parts_html,
    rejected_html,
    remarks_html,
)
from workbench.gui.scene.searches import SearchInputs
from workbench.gui.shared.look import View
from workbench.gui.shared.tables import MOST_PARTS
from workbench.gui.shared.views import line, sentence
from workbench.gui.shared.viser_server import taken_upload
from workbench.gui.shared.visitor import Visitor
from workbench.gui.uploads.reading import fitted_scanner, sent_poses, sent_scan
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import InputError, JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.commands import EditText
from workbench.model.messages.message import FoundPart
from workbench.model.scan import Detection
from workbench.plugins.progress import Cancelled

Made = Callable[[str, bytes, Cancelled], Command]
"""Makes a command of a file's name and content."""

SLOW = 1.0
"""[s] After which somebody who waits for a file is informed that it is being read."""

GIZMO = 0.09
"""[m] Size of the gizmo that corrects a part."""

CHOOSE = "choose a part in the table first"
NOT_DONE = "nothing was done to the parts found that could be undone"


class PartsPanel:
    """Scans and poses from files, the list of parts, and a part's veto or correction.

    The choice is a part, not a row: when others change the list it stays with the part, and is
    dropped with it.

    Concurrency: clicks come from viser's threads and replace `_chosen` or give commands; the
    renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._flight = CameraFlight(visitor)
        self._chosen: Detection | None = None
        self._pointed: Detection | None = None
        self._shown: tuple[Detection, ...] = ()
        self._sent: object = None
        gui = visitor.gui
        self._add_files(gui)
        self._add_table(gui)
        self._inputs = PoseInputs(
            visitor,
            "/part_gizmo",
            GIZMO,
            command=UseDetections,
            meant=self._correct,
            otherwise=self._otherwise,
            carried=self._poses_carried,
        )
        self._kind = gui.add_dropdown(
            "Kind", _kinds(visitor.cell), hint="Of a part placed by hand, and of poses from HALCON."
        )
        self._veto = gui.add_button("Veto", icon=viser.Icon.TRASH, color="red")
        self._add = gui.add_button(
            "Place a part by hand",
            icon=viser.Icon.PLUS,
            color="gray",
            hint="In the middle of the bin; then move it to where it lies.",
        )
        self._undo = gui.add_button(
            "Undo",
            icon=viser.Icon.ARROW_BACK_UP,
            color="gray",
            hint="Takes back the last veto, correction or part placed by hand.",
        )
        self._avoided = gui.add_html("")
        self._forget = gui.add_button("Avoid no more", icon=viser.Icon.REFRESH, color="gray")
        self._remarks = gui.add_html("")
        with group(gui, "Search again in this scan", expand_by_default=False):
            self._searches = SearchInputs(visitor)
        self._keeping = KeepInputs(visitor)
        self._rows = visitor.rows(MOST_PARTS, self._choose)
        self._react()

    def _add_files(self, gui: viser.GuiApi) -> None:
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._scan = gui.add_upload_button(
            "Scan from file",
            icon=viser.Icon.UPLOAD,
            hint="A PLY or PCD file in the scanner's frame and the cell's unit.",
        )
        self._poses = gui.add_upload_button(
            "Poses from file",
            icon=viser.Icon.UPLOAD,
            color="gray",
            hint="Our JSON, or a HALCON tuple file: rows of [R|t] in the world frame, mm.",
        )
        self._fit = gui.add_upload_button(
            "Fit scanner to file",
            icon=viser.Icon.RULER_2,
            color="gray",
            hint="Finds unit, axes and range of a first scan, the scanner's pose and the size of "
            "the bin, then takes the scan; Undo and Save are in the Cell tab.",
        )
        self._scan_colours = gui.add_checkbox(
            "Scan colours",
            False,
            visible=False,
            hint="As the scanner gives them, for everybody; otherwise by height and by part.",
        )

    def _add_table(self, gui: viser.GuiApi) -> None:
        self._table = gui.add_html("")
        self._rejected = gui.add_html("", visible=False)
        self._show_rejected = gui.add_checkbox(
            "Show rejected poses",
            False,
            visible=False,
            hint="Red and translucent in the scene, for everybody.",
        )

    def _react(self) -> None:
        visitor = self._visitor
        self._scan.on_upload(lambda event: self._upload(event, self._scan_of))
        self._poses.on_upload(lambda event: self._upload(event, self._poses_of))
        self._fit.on_upload(lambda event: self._upload(event, self._fitted))
        visitor.on_end(self._read_no_more)
        visitor.on_press(self._veto, self._without)
        visitor.on_press(self._undo, self._undone)
        self._add.on_click(lambda _: self._add_one())
        visitor.on_press(self._forget, ForgetAvoided)
        visitor.by_hand(
            self._show_rejected, lambda shown: visitor.look.change(rejected=bool(shown))
        )
        visitor.by_hand(
            self._scan_colours, lambda shown: visitor.look.change(scan_colours=bool(shown))
        )

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        self._draw_discarded(old, new)
        if self._scan_colours.value != new.look.scan_colours:
            self._scan_colours.value = new.look.scan_colours
        self._inputs.show_drag(old, new)
        state = new.state
        found = state.detections or ()
        self._searches.show(old, new)
        self._keeping.show(old, new)
        self._avoided.content = avoided_html(state, new.at, self._visitor.words)
        if old is not None and old.state is state:
            self._follow_click(found)
            return
        self._forget.visible = bool(state.avoided)
        kinds = _kinds(state.cell)
        if self._kind.options != kinds:
            self._kind.options = kinds
        self._kind.visible = len(kinds) > 1
        self._visitor.admit(self._forget, state, ForgetAvoided)
        self._visitor.admit(self._scan, state, UseScan)
        self._visitor.admit(self._poses, state, UseDetections)
        self._visitor.admit(self._fit, state, ChangeCell)
        self._visitor.admit(self._add, state, UseDetections)
        self._follow(found)
        missing = CHOOSE if self._chosen is None else ""
        self._visitor.admit(self._veto, state, UseDetections, otherwise=missing)
        missing = "" if state.parts_before else NOT_DONE
        self._visitor.admit(self._undo, state, UseDetections, otherwise=missing)
        may_look = not self._visitor.lacks(state, TakeScan)
        self._show_rejected.disabled = self._scan_colours.disabled = not may_look
        self._scan_colours.visible = state.scan is not None and state.scan.colours is not None
        self._remarks.content = remarks_html(
            state.remarks, state.cell.poses_folder, self._visitor.words
        )
        self._draw(found)

    def _draw_discarded(self, old: View | None, new: View) -> None:
        if old is None or old.rejected is not new.rejected:
            self._rejected.content = rejected_html(new.rejected, self._visitor.words)
            self._rejected.visible = self._show_rejected.visible = bool(new.rejected)
        if self._show_rejected.value != new.look.rejected:
            self._show_rejected.value = new.look.rejected

    def _follow(self, found: tuple[Detection, ...]) -> None:
        """Keep the choice among these parts; where there were none, the first is chosen."""
        if not self._shown and found:
            self._chosen = self._chosen or found[0]
        if _place(found, self._chosen) is None:
            self._chosen = None
        self._shown = found

    def _follow_click(self, found: tuple[Detection, ...]) -> None:
        """Choose what was clicked on in the scene since."""
        pointed = self._visitor.own.now.pointed
        if pointed is self._pointed:
            return
        self._pointed = pointed
        if _place(found, pointed) is not None:
            self._chosen = pointed
            self._visitor.admit(self._veto, self._visitor.bench.state, UseDetections)
            self._draw(found)

    def _draw(self, found: tuple[Detection, ...]) -> None:
        chosen, visitor = self._chosen, self._visitor
        if visitor.own.now.part is not chosen:
            visitor.own.change(part=chosen)
        if found:
            fates = part_fates(visitor.bench.state)
            # Parts that a click in the scene chooses may be of a state that is newer.
            fates = fates if len(fates) == len(found) else ()
            place, rows = _place(found, chosen), self._rows
            self._table.content = parts_html(found, place, rows, visitor.words, fates)
        else:
            hint = "The parts found appear here; any can be vetoed or corrected."
            self._table.content = line(hint, kind="hint")
        T = None if chosen is None else chosen.T_world_part
        problem = visitor.obstacle(visitor.bench.state, UseDetections)
        self._inputs.show(T, problem=problem or (CHOOSE if T is None else ""))

    def _choose(self, number: int) -> None:
        state, shown = self._visitor.bench.state, self._shown
        if number < len(shown):
            self._chosen = shown[number]
            self._flight.fly_to(self._chosen.T_world_part.translation)
            self._visitor.admit(self._veto, state, UseDetections)
            self._draw(shown)

    @property
    def _found(self) -> tuple[Detection, ...]:
        return self._visitor.bench.state.detections or ()

    def _correct(self, T: pin.SE3) -> bool:
        """A person knows better where the chosen part is."""

        def move() -> Command:
            found, number = self._with_chosen_at(T), self._number
            self._chosen = found[number]
            return UseDetections(found, EditText.PART_CORRECTED(found=FoundPart(number)))

        return self._ask_choosing(move)

    def _otherwise(self, T: pin.SE3) -> Mapping[str, Any] | None:
        """What is other while the chosen part is dragged."""
        if _place(self._found, self._chosen) is None:
            return None
        return {"detections": self._with_chosen_at(T)}

    def _poses_carried(self, T: pin.SE3) -> Mapping[str, pin.SE3]:
        """What follows the hand that drags the chosen part."""
        place = _place(self._found, self._chosen)
        return {} if place is None else {f"/parts/part-{place + 1}": T}

    def _with_chosen_at(self, T: pin.SE3) -> tuple[Detection, ...]:
        found, number = list(self._found), self._number
        found[number] = Detection(found[number].part, T)
        return tuple(found)

    @property
    def _number(self) -> int:
        place = _place(self._found, self._chosen)
        if place is None:
            raise InputError(CHOOSE)
        return place

    def _without(self) -> Command:
        found, number = self._found, self._number
        rest = found[:number] + found[number + 1 :]
        if not rest:
            raise InputError("the last part cannot be vetoed: take a new scan instead")
        says = EditText.PART_VETOED(found=FoundPart(number), part=found[number].part)
        return UseDetections(rest, says)

    def _undone(self) -> Command:
        before = self._visitor.bench.state.parts_before
        if not before:
            raise InputError(NOT_DONE)
        return UseDetections(before[0], EditText.PARTS_UNDONE())

    def _add_one(self) -> None:
        """Place a part and choose it, so that it is the one that is moved next."""
        self._ask_choosing(self._with_one_more)

    def _ask_choosing(self, command: Callable[[], Command]) -> bool:
        """Give a command whose making chooses a part, unless it is refused."""
        before = self._chosen
        is_done = self._visitor.ask(command)
        if not is_done:
            self._chosen = before
        return is_done

    def _with_one_more(self) -> Command:
        cell = self._visitor.cell
        middle = cell.bin.T_world_bin * pose_from_rpy((0, 0, float(cell.bin.size[2]) / 2))
        self._chosen = detection = Detection(self._kind.value, middle)
        says = EditText.PART_ADDED(part=detection.part)
        return UseDetections((*self._found, detection), says)

    def _read_no_more(self) -> None:
        self._sent = None

    def _upload(self, event: Any, made: Made) -> None:
        """Read a file; another one that is chosen meanwhile takes its place."""
        name, content = taken_upload(event.target)
        self._sent = sent = object()
        slow = Timer(
            SLOW, lambda: self._visitor.notify(name, "This file is being read.", color="blue")
        )
        slow.start()
        try:
            self._visitor.attempt(
                lambda: self._read(made, name, content, lambda: self._sent is not sent)
            )
        finally:
            slow.cancel()

    def _read(self, made: Made, name: str, content: bytes, cancelled: Cancelled) -> None:
        try:
            command = made(sent_name(name), content, cancelled)
        except JobCancelled:
            return
        self._visitor.give(command)

    def _scan_of(self, name: str, content: bytes, cancelled: Cancelled) -> Command:
        return UseScan(sent_scan(name, content, self._visitor.cell.scanner, cancelled=cancelled))

    def _fitted(self, name: str, content: bytes, cancelled: Cancelled) -> Command:
        """The scan, by a scanner that fits it from now on; what is left to do is stated."""
        visitor, cell = self._visitor, self._visitor.cell
        check_stands(cell)
        fitted = fitted_scanner(name, content, cell, cancelled=cancelled)
        scan = sent_scan(name, content, fitted.mount, cancelled=cancelled)
        after = replace(cell, scanner=fitted.mount, bin=fitted.bin)
        if after.digest != cell.digest:
            says = EditText.SCANNER_FITTED(file=name)
            if digest_of(fitted.bin) != digest_of(cell.bin):
                size = " x ".join(f"{1000 * side:.0f}" for side in fitted.bin.size)
                says = EditText.BIN_FITTED(file=name, size=size)
            visitor.give(ChangeCell(after, says, was=cell.digest))
        for left in fitted.left:
            visitor.notify(name, sentence(visitor.words.render(left)), color="blue")
        return UseScan(scan)

    def _poses_of(self, name: str, content: bytes, cancelled: Cancelled) -> Command:
        detections = sent_poses(name, content, self._kind.value, cancelled=cancelled)
        says = EditText.POSES_FROM(count=len(detections), file=name)
        return UseDetections(detections, says)


def _place(found: Sequence[Detection], chosen: Detection | None) -> int | None:
    """Where a part stands in a list; None: it does not."""
    return next((number for number, detection in enumerate(found) if detection is chosen), None)


def _kinds(cell: Cell) -> tuple[str, ...]:
    return tuple(part.name for part in cell.parts)

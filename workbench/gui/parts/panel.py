"""The tab with the parts found: what speaks for and against each, and a person's word on it."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pinocchio as pin
import viser

from workbench.app.core.commands import Command, ForgetAvoided, TakeScan, UseDetections, UseScan
from workbench.formats.clouds.scans import parse_scan
from workbench.formats.plans.pose_files import parse_poses
from workbench.gui.parts.views import (
    MOST_ROWS,
    avoided_html,
    discarded_html,
    parts_html,
    remarks_html,
)
from workbench.gui.scene.pose_inputs import PoseInputs
from workbench.gui.scene.searches import SearchInputs
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection

GIZMO = 0.09
"""[m] Size of the gizmo that corrects a part."""


class PartsPanel:
    """Scans and poses from files, the list of parts, and a part's veto or correction.

    Concurrency: clicks come from viser's threads and replace `_chosen` or give commands; the
    renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._chosen = 0
        gui = visitor.gui
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
        self._table = gui.add_html("")
        self._discarded = gui.add_html("", visible=False)
        self._show_discarded = gui.add_checkbox(
            "Show discarded poses",
            False,
            visible=False,
            hint="Red and translucent in the scene, for everybody.",
        )
        self._inputs = PoseInputs(visitor, "/part_gizmo", GIZMO, self._correct)
        self._kind = gui.add_dropdown(
            "Kind", _kinds(visitor.cell), hint="Of a part that is added, and of poses from HALCON."
        )
        self._veto = gui.add_button("Veto", icon=viser.Icon.TRASH, color="red")
        self._add = gui.add_button("Add a part", icon=viser.Icon.PLUS, color="gray")
        self._avoided = gui.add_html("")
        self._forget = gui.add_button("Avoid no more", icon=viser.Icon.REFRESH, color="gray")
        self._remarks = gui.add_html("")
        with gui.add_folder("Search again in this scan", expand_by_default=False):
            self._searches = SearchInputs(visitor)
        self._rows = [visitor.unseen(partial(self._choose, number)) for number in range(MOST_ROWS)]
        visitor.hide(self._rows)
        self._scan.on_upload(lambda event: self._uploaded(event, self._scan_of))
        self._poses.on_upload(lambda event: self._uploaded(event, self._poses_of))
        visitor.on_press(self._veto, self._without)
        self._add.on_click(lambda _: self._add_one())
        visitor.on_press(self._forget, ForgetAvoided)

        @self._show_discarded.on_update
        def _(event: Any) -> None:
            if event.client is not None:
                visitor.look.change(discarded=bool(event.target.value))

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        self._draw_discarded(old, new)
        state = new.state
        found = state.detections or ()
        self._searches.show(old, new)
        self._chosen = min(self._chosen, max(len(found) - 1, 0))
        self._avoided.content = avoided_html(state, new.at)
        if old is not None and old.state is state:
            return
        self._forget.visible = bool(state.avoided)
        kinds = _kinds(state.cell)
        if self._kind.options != kinds:
            self._kind.options = kinds
        self._kind.visible = len(kinds) > 1
        self._visitor.admit(self._forget, state, ForgetAvoided)
        can = not self._visitor.obstacle(state, UseDetections)
        self._visitor.admit(self._scan, state, UseScan)
        self._visitor.admit(self._poses, state, UseDetections)
        self._visitor.admit(self._add, state, UseDetections)
        self._visitor.admit(self._veto, state, UseDetections, is_ready=bool(found))
        self._show_discarded.disabled = bool(self._visitor.lacks(state, TakeScan))
        self._remarks.content = remarks_html(state.remarks, state.cell.poses_folder)
        self._draw(found, can)

    def _draw_discarded(self, old: View | None, new: View) -> None:
        if old is None or old.discarded is not new.discarded:
            self._discarded.content = discarded_html(new.discarded)
            self._discarded.visible = self._show_discarded.visible = bool(new.discarded)
        if self._show_discarded.value != new.look.discarded:
            self._show_discarded.value = new.look.discarded

    def _draw(self, found: tuple[Detection, ...], can: bool) -> None:
        if found:
            self._table.content = parts_html(found, self._chosen, self._rows)
        else:
            hint = "The parts found appear here; one can be vetoed, corrected, or added."
            self._table.content = line(hint, kind="hint")
        T = found[self._chosen].T_world_part if found else None
        self._inputs.show(T, is_enabled=can)

    def _choose(self, number: int) -> None:
        state = self._visitor.bench.state
        if number < len(state.detections or ()):
            self._chosen = number
            self._draw(state.detections or (), not self._visitor.obstacle(state, UseDetections))

    @property
    def _found(self) -> tuple[Detection, ...]:
        return self._visitor.bench.state.detections or ()

    def _correct(self, T: pin.SE3) -> bool:
        """A person knows better where the chosen part is."""
        found, number = list(self._found), self._chosen
        if number >= len(found):
            return False
        found[number] = Detection(found[number].part, T)
        says = f"part-{number + 1} was corrected by hand"
        return self._visitor.ask(lambda: UseDetections(tuple(found), says))

    def _without(self) -> Command:
        found, number = self._found, self._chosen
        if number >= len(found):
            raise InputError("there is no part to veto")
        rest = found[:number] + found[number + 1 :]
        if not rest:
            raise InputError("the last part cannot be vetoed: take a new scan instead")
        return UseDetections(rest, f"part-{number + 1} ({found[number].part}) was vetoed")

    def _add_one(self) -> None:
        """Add a part and choose it, so that it is the one that is moved next."""
        before, self._chosen = self._chosen, len(self._found)
        if not self._visitor.ask(self._with_one_more):
            self._chosen = before

    def _with_one_more(self) -> Command:
        cell = self._visitor.cell
        middle = cell.bin.T_world_bin * pose_from_rpy((0, 0, float(cell.bin.size[2]) / 2))
        one = Detection(self._kind.value, middle)
        return UseDetections((*self._found, one), f"a {one.part} was added by hand")

    def _uploaded(self, event: Any, made: Any) -> None:
        file = event.target.value
        self._visitor.ask(lambda: made(Path(file.name).name, file.content))

    def _scan_of(self, name: str, content: bytes) -> Command:
        scan = parse_scan(Path(name), content, self._visitor.cell.scanner)
        return UseScan(replace(scan, source=name))

    def _poses_of(self, name: str, content: bytes) -> Command:
        detections = parse_poses(Path(name), content, self._kind.value)
        return UseDetections(detections, f"{len(detections)} poses taken from {name}")


def _kinds(cell: Cell) -> tuple[str, ...]:
    return tuple(part.name for part in cell.parts)

"""The tab that finds out where the scanner hangs: poses of a plate, their fit, before and after."""

import time
from dataclasses import replace

import numpy as np
import pinocchio as pin
import viser

from workbench.app.calibration.calibration import compute_calibration, with_calibration
from workbench.app.core.cell.changes import ChangeCell, SaveCell
from workbench.app.core.command import Command
from workbench.app.core.cycle.scanning import SightPlate, UseObservations
from workbench.app.core.state import State
from workbench.app.core.value_checks import MOST_OBSERVATIONS
from workbench.gui.calibration.checks import ChecksGroups, arm_joints
from workbench.gui.calibration.drift import NAME_MISSING, DriftGroup
from workbench.gui.help.groups import group
from workbench.gui.shared.calibrating import solve
from workbench.gui.shared.calibration_views import (
    answer_html,
    next_html,
    overlay_line,
    poses_html,
    record_line,
)
from workbench.gui.shared.look import View
from workbench.gui.shared.own import ShownPlate
from workbench.gui.shared.views import line, not_saved
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.calibration import CalibrationText
from workbench.model.calibration import BallArtefact, BallPlate, Calibration, PlateObservation
from workbench.model.cell import Arm, Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.commands import EditText
from workbench.model.messages.message import Message

MOST_ROWS = MOST_OBSERVATIONS

SUGGESTED = 12
"""Poses that are suggested one after the other."""

ADVISED = 8
"""Poses that an answer should have."""

SUGGEST = "Suggest a pose"

CHOOSE = "choose a pose in the list first"


class CalibrationPanel:
    """Plate, poses, their residuals with a light each, the answer, and its use.

    Concurrency: callbacks come from viser's threads, change this browser's own look, or give
    commands; suggestions are worked out in the callback's thread.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._suggested: tuple[object, list[tuple[Floats, str]]] = (None, [])
        gui, cell, plate = visitor.gui, visitor.cell, BallPlate()
        self._record = gui.add_html("")
        with group(gui, "1 · Plate", expand_by_default=False):
            self._ball = gui.add_number(
                "Ball diameter [mm]",
                plate.radius * 2000,
                min=4,
                max=400,
                step=0.01,
                hint="Of each of the three balls, as certified.",
            )
            self._sides = gui.add_vector3(
                "Distances [mm]",
                np.round(np.array(plate.sides) * 1000, 3),
                step=0.01,
                hint="Centre to centre: ball 1 to 2, 2 to 3, 3 to 1; all different.",
            )
            visitor.name(self._sides, ("1 to 2", "2 to 3", "3 to 1"))
        with group(gui, "2 · Poses"):
            self._where = gui.add_html("")
            self._arm = gui.add_dropdown(
                "Arm",
                tuple(arm.name for arm in cell.arms),
                visible=len(cell.arms) > 1 and cell.scanner.on_arm is None,
                hint="Which arm holds the plate.",
            )
            gui.add_html('<div class="wb-buttons wb-two"></div>')
            self._suggest = gui.add_button(
                SUGGEST,
                icon=viser.Icon.BULB,
                color="gray",
                hint="Jogs the robot on the page to where the scanner should see the plate.",
            )
            self._take = gui.add_button("Scan the plate", icon=viser.Icon.SCAN)
            self._way = gui.add_html("")
            self._table = gui.add_html("")
            self._leave = gui.add_button("Leave out", color="gray")
            self._remove = gui.add_button("Remove", icon=viser.Icon.TRASH, color="red")
        with group(gui, "3 · Review and apply"):
            self._after = gui.add_checkbox(
                "Show with new calibration", False, hint="Off: where the cell has the scanner now."
            )
            self._overlay = gui.add_html("")
            self._answer = gui.add_html("")
            # Who is logged in has said it already.
            self._name = gui.add_text(
                "Your name",
                visitor.person.name if visitor.is_known else "",
                hint="Kept with the calibration.",
                visible=not visitor.is_known,
            )
            gui.add_html('<div class="wb-buttons wb-two"></div>')
            self._apply = gui.add_button("Apply", icon=viser.Icon.CHECK)
            self._save = gui.add_button("Save to file", icon=viser.Icon.DEVICE_FLOPPY)
        self._drift = DriftGroup(visitor, lambda: self._name_typed)
        self._checks = ChecksGroups(visitor, self._artefact)
        self._rows = visitor.rows(MOST_ROWS, self._look_at)
        self._react()

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state, chosen = new.state, new.own.observation
        self._drift.show(new)
        self._checks.show(new)
        carrier = state.cell.scanner.on_arm
        self._where.content = self._says_where(new)
        # Nothing is shown as calibrated before there is a calibration.
        is_after = new.own.is_calibrated and isinstance(new.calibration, Calibration)
        if self._after.value != is_after:
            self._after.value = is_after
        self._admit_apply(state, new.calibration)
        self._visitor.emphasise(self._next_button(new), "Calibration")
        if old is not None and old.own.jog is not None and new.own.jog is None:
            self._way.content = ""
        is_same = (
            old is not None
            and old.state is state
            and old.own.observation == chosen
            and old.calibration is new.calibration
            and old.overlay is new.overlay
        )
        if is_same:
            return
        observations, found, words = state.observations, new.calibration, self._visitor.words
        if old is None or old.state.observations is not observations:
            self._way.content = ""
        self._record.content = record_line(state.cell, new.at, words)
        self._table.content = poses_html(observations, found, chosen, self._rows, words)
        self._answer.content = answer_html(state.cell, found, len(observations), words)
        is_carried = carrier is not None
        over = overlay_line(new.overlay, is_carried=is_carried, words=words)
        self._overlay.content = over if observations else ""
        admit = self._visitor.admit
        admit(self._take, state, SightPlate)
        for button in (self._leave, self._remove):
            admit(button, state, UseObservations, otherwise=CHOOSE if chosen is None else "")
        if chosen is not None and chosen < len(observations):
            self._leave.label = "Leave out" if observations[chosen].is_used else "Use again"
        self._after.disabled = not isinstance(found, Calibration)
        admit(self._save, state, SaveCell, otherwise=not_saved(state))

    def _next_button(self, view: View) -> viser.GuiButtonHandle:
        """Of the next step: poses until the answer has those that are advised, its use, Save."""
        found, state = view.calibration, view.state
        if state.cell.scanner.calibration is not None and not state.is_saved:
            return self._save
        if isinstance(found, Calibration) and found.used >= ADVISED:
            return self._apply
        return self._suggest if view.own.jog is None else self._take

    def _admit_apply(self, state: State, found: Calibration | Message | str) -> None:
        """Enable Apply where there is a calibration and a name; else it states what is missing."""
        missing = "" if isinstance(found, Calibration) else found or "scan the plate first"
        if not missing and not self._name_typed:
            missing = NAME_MISSING
        text = missing if isinstance(missing, str) else self._visitor.words.render(missing)
        self._visitor.admit(self._apply, state, ChangeCell, otherwise=text)

    @property
    def _name_typed(self) -> str:
        """The name of the person; empty where nobody has logged in or typed it."""
        visitor = self._visitor
        return visitor.person.name if visitor.is_known else self._name.value.strip()

    def _says_where(self, view: View) -> str:
        carrier, where = view.state.cell.scanner.on_arm, line(self._scan_place(view), kind="hint")
        if carrier is None:
            return where
        text = CalibrationText.CARRIED(arm=carrier.arm)
        if len(view.state.cell.arms) == 1:
            text = CalibrationText.CARRIED_BY_ONLY_ARM()
        return line(self._visitor.words.render(text)) + where

    def _scan_place(self, view: View) -> str:
        if view.state.cell.scanner.source != "simulated":
            if not view.live.joints:
                return "The controller reports no joint values, so no pose can be scanned here."
            return "A scan is taken where the controller reports the robot to be."
        if view.own.jog is not None:
            return "A scan is taken of the robot as it is jogged on the page."
        return "A scan is taken where the robot stands; jog it, or have a pose suggested."

    def _react(self) -> None:
        visitor, own = self._visitor, self._visitor.own
        visitor.on_press(self._take, self._wanted_scan)
        visitor.on_press(self._leave, self._left_out)
        visitor.on_press(self._remove, self._remove_pose)
        visitor.on_press(self._apply, self._apply_calibration)
        self._save.on_click(lambda _: self._save_cell())
        self._suggest.on_click(lambda _: self._suggest_next())
        visitor.by_hand(self._name, lambda _: own.change())
        visitor.by_hand(self._after, lambda after: own.change(is_calibrated=bool(after)))

    def _look_at(self, number: int) -> None:
        """Look at a pose of the table, or away from it."""
        own = self._visitor.own
        if number < len(self._visitor.bench.state.observations):
            self._visitor.turn_away()
            own.change(observation=None if own.now.observation == number else number)

    def _plate(self) -> BallPlate:
        return BallPlate(float(self._ball.value) / 2000, np.array(self._sides.value) / 1000)

    def _artefact(self) -> BallArtefact:
        plate = self._plate()
        return BallArtefact(plate.radius, plate.sides)

    def _wanted_scan(self) -> Command:
        state = self._visitor.bench.state
        arm = self._moved_arm(state.cell)
        q = arm_joints(self._visitor, arm)
        self._visitor.own.change(observation=None)
        return SightPlate(arm.name, q, self._plate(), seed=state.number)

    def _moved_arm(self, cell: Cell) -> Arm:
        """The arm that carries the scanner, or the one that was chosen to hold the plate."""
        carrier = cell.scanner.on_arm
        return cell.arm(self._arm.value if carrier is None else carrier.arm)

    def _suggest_next(self) -> None:
        """Jog to the next of the suggested poses; they are worked out when poses have changed.

        Once there is an answer they are those that would tell most, with the way there in words.
        """
        visitor = self._visitor
        if self._suggest.disabled:
            return
        self._suggest.disabled, self._suggest.label = True, "Looking …"
        try:
            cell, arm = visitor.cell, self._moved_arm(visitor.cell)
            state = visitor.bench.state
            observations, found = state.observations, solve(state)
            answer = None
            if isinstance(found, Calibration) and observations[-1].arm == arm.name:
                answer = found
            known, left = self._suggested
            key = (cell.digest, arm.name, self._ball.value, self._sides.value)
            if cell.scanner.on_arm is not None:
                key = (*key, bool(observations))
            if answer is not None:
                key = (
                    *key,
                    *((observation.name, observation.is_used) for observation in observations),
                )
            if known != key or not left:
                left = self._worked_out(arm, answer)
                self._suggested = (key, left)
            if not left:
                is_only = len(cell.arms) == 1
                text = CalibrationText.NO_POSE_OF_ONLY_ARM() if is_only else None
                raise InputError(text or CalibrationText.NO_POSE(arm=arm.name))
        except InputError as error:
            visitor.notify("No suggestion", visitor.words.render(error.message))
            return
        finally:
            self._suggest.disabled, self._suggest.label = False, SUGGEST
        q, way = left.pop(0)
        jog = {other.name: np.asarray(other.home) for other in cell.arms} | {arm.name: q}
        visitor.turn_away()
        shown = ShownPlate(arm.name, self._plate(), self._held(arm, answer))
        visitor.own.change(jog=jog, plate=shown, observation=None)
        self._way.content = self._pose_line(cell) + way

    def _held(self, arm: Arm, found: Calibration | None) -> pin.SE3:
        """`T_flange_plate` that the suggested poses assume."""
        # Open3D takes a second to load: the page does not wait for it.
        from workbench.app.calibration.ball_plate import seen_plate, simulated_plate

        cell, observations = self._visitor.cell, self._visitor.bench.state.observations
        if found is not None:
            return found.T_flange_plate
        if cell.scanner.on_arm is not None and observations:
            return seen_plate(cell, observations[-1])
        return simulated_plate(cell, arm, self._plate())

    def _pose_line(self, cell: Cell) -> str:
        is_simulated = cell.scanner.source == "simulated"
        text = CalibrationText.POSE_SIMULATED if is_simulated else CalibrationText.POSE_REAL
        return line(self._visitor.words.render(text()))

    def _worked_out(self, arm: Arm, found: Calibration | None) -> list[tuple[Floats, str]]:
        """Poses to suggest and the way to each; the best first where there is an answer."""
        # Open3D takes a second to load: the page does not wait for it.
        from workbench.app.calibration import ball_plate
        from workbench.app.calibration.next_pose import next_poses

        cell, observations = self._visitor.cell, self._visitor.bench.state.observations
        if found is None:
            qs = ball_plate.first_poses(
                cell, arm, self._plate(), SUGGESTED, seed=0, observations=observations
            )
            return [(q, "") for q in qs]
        best = next_poses(cell, observations, found, seed=len(observations))
        is_carried, words = cell.scanner.on_arm is not None, self._visitor.words
        return [(pose.q, next_html(pose, is_carried=is_carried, words=words)) for pose in best]

    @property
    def _chosen(self) -> tuple[int, tuple[PlateObservation, ...]]:
        observations, number = (
            self._visitor.bench.state.observations,
            self._visitor.own.now.observation,
        )
        if number is None or number >= len(observations):
            raise InputError(CHOOSE)
        return number, observations

    def _left_out(self) -> Command:
        number, observations = self._chosen
        observation = observations[number]
        changed = replace(observation, is_used=not observation.is_used)
        says = EditText.POSE_USED if changed.is_used else EditText.POSE_LEFT_OUT
        after = (*observations[:number], changed, *observations[number + 1 :])
        return UseObservations(after, says(pose=observation.name))

    def _remove_pose(self) -> Command:
        number, observations = self._chosen
        self._visitor.own.change(observation=None)
        rest = observations[:number] + observations[number + 1 :]
        return UseObservations(rest, EditText.POSE_REMOVED(pose=observations[number].name))

    def _who(self) -> str:
        if not (by := self._name_typed):
            raise InputError(NAME_MISSING)
        return by

    def _save_cell(self) -> None:
        self._visitor.save(lambda: SaveCell("calibrated"))

    def _apply_calibration(self) -> Command:
        by = self._who()
        state = self._visitor.bench.state
        found = compute_calibration(state.cell, state.observations)
        cell = with_calibration(state.cell, found, time.time(), by)
        says = EditText.CALIBRATED(by=by, used=found.used)
        return ChangeCell(cell, says, was=state.cell.digest)

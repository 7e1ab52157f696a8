"""The tab that finds out where the scanner hangs, without a browser."""

import threading
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from waiting import PATIENCE

import workbench.app.calibration.ball_plate
from workbench.app.core.value_checks import MOST_OBSERVATIONS
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.gui.calibration.panel import ADVISED, SUGGEST, CalibrationPanel
from workbench.gui.shared.calibrating import solve
from workbench.gui.shared.calibration_views import answer_html
from workbench.gui.shared.own import Own
from workbench.gui.shared.visitor import Visitor
from workbench.model.calibration import BallPlate, Calibration, PlateObservation, PoseResidual
from workbench.model.messages.calibration import PlateText

OBSERVATION = PlateObservation(
    "pose 1", "right", np.zeros(7), BallPlate(), np.eye(3), 0.0001, np.ones((4, 3))
)


def test_every_pose_that_may_be_scanned_has_a_row(visitor):
    assert len(CalibrationPanel(visitor)._rows) == MOST_OBSERVATIONS


def test_a_second_click_while_a_pose_is_looked_for_does_nothing(visitor, monkeypatch):
    begun, may_end, calls = threading.Event(), threading.Event(), []

    def slow(cell, arm, plate, count, *, seed):
        calls.append(seed)
        begun.set()
        assert len(calls) > 1 or may_end.wait(PATIENCE)
        return [np.asarray(arm.home)]

    monkeypatch.setattr(workbench.app.calibration.ball_plate, "suggested_poses", slow)
    panel = CalibrationPanel(visitor)
    first = threading.Thread(target=panel._suggest_next)
    first.start()
    assert begun.wait(PATIENCE)
    assert panel._suggest.disabled and panel._suggest.label != SUGGEST
    panel._suggest_next()
    may_end.set()
    first.join(PATIENCE)
    assert (panel._suggest.label, panel._suggest.disabled) == (SUGGEST, False)
    assert len(calls) == 1


def test_nothing_is_shown_as_calibrated_before_there_is_a_calibration(visitor, states, view_of):
    panel = CalibrationPanel(visitor)
    view = view_of(states.idle)
    panel.show(None, view)
    assert view.own.is_calibrated and not panel._after.value and panel._after.disabled


def test_too_few_poses_reach_the_page_as_progress(states):
    found = solve(replace(states.idle, observations=(OBSERVATION,)))
    assert found.text is PlateText.TOO_FEW_POSES
    assert "wb-hint" in answer_html(states.idle.cell, found, 1)


def test_apply_needs_a_name_and_says_so(visitor, states, view_of, monkeypatch):
    monkeypatch.setattr(Visitor, "is_known", False)
    panel = CalibrationPanel(visitor)
    T = states.idle.cell.scanner.T_world_scanner
    residuals = (PoseResidual("pose 1", 0.0004, 0.001, "good", ""),)
    found = Calibration(T, T, residuals, 0.0004, np.diag([1e-8] * 3 + [1e-6] * 3))
    panel.show(None, old := replace(view_of(states.idle), calibration=found))
    assert panel._apply.disabled and "Type your name" in panel._apply.hint
    panel._name.value = "Ada"
    panel.show(old, old)
    assert not panel._apply.disabled
    panel._name.value = "  "
    panel.show(old, old)
    assert panel._apply.disabled


@pytest.mark.parametrize(
    ("source", "text"),
    [("simulated", "In simulation the scan is taken there"), ("folder", "Drive the robot there")],
)
def test_a_suggestion_says_what_the_blue_robot_is(visitor, monkeypatch, cell, source, text):
    scanner = replace(cell.scanner, source=source, address="scans")
    monkeypatch.setattr(Visitor, "cell", replace(cell, scanner=scanner))
    panel = CalibrationPanel(visitor)
    panel._worked_out = lambda arm, answer: [(np.asarray(arm.home), "<p>way</p>")]
    panel._suggest_next()
    assert "The blue robot shows the pose." in panel._way.content
    assert text in panel._way.content and panel._way.content.endswith("<p>way</p>")


def test_the_line_on_a_suggestion_goes_when_jogging_ends(visitor, states, view_of):
    panel = CalibrationPanel(visitor)
    view = view_of(states.idle)
    jogged = replace(view, own=replace(view.own, jog={"right": np.zeros(7)}))
    panel.show(None, jogged)
    panel._way.content = "The blue robot shows the pose."
    panel.show(jogged, jogged)
    assert panel._way.content
    panel.show(jogged, view)
    assert not panel._way.content


def test_the_arm_with_the_scanner_is_named_only_where_there_are_two(visitor, states, view_of):
    panel, state = CalibrationPanel(visitor), states.idle
    cell = read_cell(find("robots", "tx2_90") / "on_arm.toml")
    view = view_of(replace(state, cell=cell))
    assert "The arm carries the scanner." in panel._says_where(view)
    assert "the plate must not move" in panel._says_where(view)
    both = replace(cell, arms=(*cell.arms, replace(cell.arms[0], name="other")))
    two = replace(view, state=replace(state, cell=both))
    assert f"The {cell.arms[0].name} arm carries" in panel._says_where(two)


def test_one_button_is_filled_the_next_of_a_calibration(visitor, states, view_of):
    panel, view = CalibrationPanel(visitor), view_of(states.idle)
    assert panel._next_button(view) is panel._suggest
    home = {arm.name: np.asarray(arm.home) for arm in view.state.cell.arms}
    jogged = replace(view, own=Own(jog=home))
    assert panel._next_button(jogged) is panel._take
    residuals = tuple(
        PoseResidual(f"pose {number}", 1e-4, 1e-3, "good") for number in range(ADVISED)
    )
    found = Calibration(pin.SE3.Identity(), pin.SE3.Identity(), residuals, 1e-4, np.eye(6) * 1e-8)
    assert panel._next_button(replace(jogged, calibration=found)) is panel._apply
    few = replace(found, residuals=residuals[1:])
    assert panel._next_button(replace(jogged, calibration=few)) is panel._take
    panel.show(None, view)
    visitor.show_button_texts()
    assert visitor._style.content.count("--wb-fill:var(--wb-primary)") == 1

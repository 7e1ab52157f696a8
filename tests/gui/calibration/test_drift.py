"""The look at recorded scans on the calibration's tab, without a browser."""

from threading import Event

import numpy as np
import pytest
from waiting import wait_until

import workbench.app.review.drift_process
import workbench.app.review.scanner_drift
from workbench.app.review.scanner_drift import RecordedDrift
from workbench.gui.calibration.drift import LOOK, DriftGroup, course_html
from workbench.model.errors import InputError, JobCancelled
from workbench.perception.calibration.refinement import Drift


def test_what_was_found_can_be_taken_over_once_it_is_there(visitor, monkeypatch):
    drift = Drift((), ("table",), False, (), np.full(6, 1e-3), np.eye(6) * 1e-8, 0)
    found = RecordedDrift(drift, 3, 20, ("monday: is not whole",))
    monkeypatch.setattr(workbench.app.review.drift_process, "drift_apart", lambda *args: found)
    monkeypatch.setattr(
        workbench.app.review.scanner_drift, "refined_cell", lambda cell, drift, at, by: (cell, by)
    )
    group = DriftGroup(visitor, lambda: "Ada")
    with pytest.raises(InputError, match="first"):
        group._take_drift()
    group._look_for_drift(Event())
    assert "20 scans of 3 sessions" in group._says.content
    assert "monday: is not whole" in group._says.content
    assert (group._look.disabled, group._look.label) == (False, LOOK)
    command = group._take_drift()
    assert command.cell == (visitor.cell, "Ada")
    assert str(command.says).startswith("Ada moved the scanner")


@pytest.mark.extensive
def test_a_scanner_that_was_never_calibrated_is_said(visitor):
    told = []
    visitor.notify = lambda *said: told.append(said)
    group = DriftGroup(visitor, lambda: "Ada")
    group._look_for_drift(Event())
    assert "was never calibrated" in told[0][1]
    assert not group._look.disabled


def test_a_look_can_be_given_up(visitor):
    given_up = Event()
    given_up.set()
    group = DriftGroup(visitor, lambda: "Ada")
    group._look_for_drift(given_up)
    assert "The look was cancelled" in group._says.content
    assert (group._take.visible, group._cancel.visible) == (True, False)


def test_days_are_drawn_with_what_they_tell():
    moved = np.full((3, 6), np.nan)
    moved[:, 2] = (0, 1e-3, 2e-3)
    html = course_html("table", np.array([4, 5, 9]), moved)
    assert "Shift, by table" in html and html.count("<path") == 1
    assert "Turn" not in html
    assert course_html("table", np.array([4]), moved[:1]) == ""


def test_a_look_at_recorded_scans_ends_with_its_browser(visitor, monkeypatch):
    began, ended = Event(), []

    def wait_until_given_up(bench, given_up):
        began.set()
        ended.append(given_up.wait(30))
        raise JobCancelled("given up")

    drift = DriftGroup(visitor, lambda: "Ada")
    monkeypatch.setattr(drift, "_read_change", wait_until_given_up)
    drift._began()
    assert began.wait(30)
    drift._began()  # one at a time
    visitor.end(is_gone=True)
    wait_until(lambda: ended, "the end of the look")
    assert ended == [True]


def test_the_scanner_is_moved_in_nobodys_name(visitor, bench):
    name = [""]
    group = DriftGroup(visitor, lambda: name[0])
    group._found = bench.state.cell.digest, lambda at, by: bench.state.cell
    group._admit(bench.state)
    assert group._take.disabled and group._take.hint.startswith("Type your name")
    name[0] = "Ada"
    group._admit(bench.state)
    assert not group._take.disabled

"""The tab that finds out where the scanner hangs, without a browser."""

import threading

import numpy as np
from waiting import PATIENCE

import workbench.app.calibration.ball_plate
from workbench.app.core.value_checks import MOST_OBSERVATIONS
from workbench.gui.calibration.panel import SUGGEST, CalibrationPanel


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

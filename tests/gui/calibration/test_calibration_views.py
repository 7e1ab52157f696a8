"""What the page says of calibration, bin, searches and remarks."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench.app.core.state import State
from workbench.gui.parts.views import remarks_html
from workbench.gui.scene.searches import searches_html
from workbench.gui.shared.calibration_views import (
    answer_html,
    bin_html,
    calibration_warning,
    poses_html,
    record_line,
)
from workbench.model.calibration import (
    BallPlate,
    BinCheck,
    Calibration,
    CalibrationRecord,
    PlateObservation,
    PoseResidual,
)
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.calibration import PlateText
from workbench.model.messages.message import plain
from workbench.model.scan import PosesFolder, Remark, SearchOverrides, SearchRecord

STATIC = Path(__file__).parents[3] / "static"

NOW = 1_760_000_000.0
DAY = 86_400.0


def with_record(cell, days, source="folder"):
    record = CalibrationRecord(NOW - days * DAY, "<Anna>", 8, 0.00012)
    mount = replace(cell.scanner, calibration=record, source=source, address="scans")
    return replace(cell, scanner=mount)


def test_an_old_or_missing_calibration_is_warned_of(cell):
    assert calibration_warning(cell, NOW) is None, "a simulated scanner hangs where the cell says"
    real = replace(cell, scanner=replace(cell.scanner, source="folder", address="scans"))
    assert "never calibrated" in str(calibration_warning(real, NOW))
    merged = replace(cell, scanner=replace(cell.scanner, source="merged", address="views"))
    assert calibration_warning(merged, NOW) is None, "its views are refused without a calibration"
    assert calibration_warning(with_record(cell, 89), NOW) is None
    assert "91 days ago; limit: 90 days" in str(calibration_warning(with_record(cell, 91), NOW))
    assert "&lt;Anna&gt;: 8 poses, 0.12 mm RMS" in record_line(with_record(cell, 1), NOW)
    assert "wb-bad" in record_line(with_record(cell, 91), NOW)


def test_the_bin_has_a_light_and_a_sentence(cell):
    good = BinCheck(cell.bin.T_world_bin, 0.0001, 0.0, 0.05, 0.0, "good", ())
    state = State(cell)
    assert 'data-light="good"' in bin_html(state, good, NOW)
    assert "The bin is where it should be, within 0.1 mm, 5% full." in bin_html(state, good, NOW)
    old = State(with_record(cell, 100))
    assert 'data-light="warning"' in bin_html(old, good, NOW)
    assert "100 days ago" in bin_html(old, good, NOW)
    gone = BinCheck(None, 0.0, 0.0, None, 0.0, "bad", (plain("the rim of the bin is not seen"),))
    assert 'data-light="bad"' in bin_html(state, gone, NOW)
    assert bin_html(state, None, NOW) == ""


@pytest.fixture
def observations():
    one = PlateObservation(
        "pose 1", "right", np.zeros(7), BallPlate(), np.eye(3), 0.0001, np.ones((4, 3))
    )
    return one, replace(one, name="pose <2>", is_used=False)


def test_poses_have_residuals_lights_and_reasons(cell, observations):
    assert "Eight are advised" in poses_html((), "", None, ())
    html = poses_html(observations, "too few", 1, ("a", "b"))
    assert "pose &lt;2&gt;" in html and "left out by a person" in html
    residuals = (
        PoseResidual("pose 1", 0.00042, np.deg2rad(0.05), "good", "", (0.00061, np.deg2rad(0.07))),
        PoseResidual("pose <2>", 0.012, 0.05, "bad", "does not agree: 12.0 mm <off>"),
    )
    T = cell.scanner.T_world_scanner * pose_from_rpy((0.003, 0.004, 0), (0, 0, np.deg2rad(2)))
    found = Calibration(T, T, residuals, 0.0004, np.diag([1e-8] * 3 + [1e-6] * 3))
    html = poses_html(observations, found, None, ("a", "b"))
    heads = ("Residual [mm]", "Residual [deg]", "Cross-check [mm, deg]")
    assert all(head in html for head in heads) and "°" not in html
    assert ">0.61, 0.07<" in html and ">open<" in html
    assert ">0.42<" in html and ">2.86<" in html and "12.0 mm &lt;off&gt;" in html
    answer = answer_html(cell, found, 2)
    assert "5.0 mm and 2.00 deg" in answer and "8 poses are better than 1" in answer
    assert "worst: pose 1, 0.61 mm, 0.07 deg" in answer
    assert "Front left" in answer and answer.count("<tr><td>") == 4
    assert "Needs &lt;4&gt;." in answer_html(cell, "needs <4>", 2)
    assert answer_html(cell, "needs 4", 0) == ""
    few = PlateText.TOO_FEW_POSES(fewest=4, advised=8, count=1)
    assert "1 of 4 poses at least; 8 are better." in answer_html(cell, few, 1)
    assert "wb-hint" in answer_html(cell, few, 1) and "wb-bad" in answer_html(cell, "needs 4", 1)


def test_heads_of_the_poses_break_so_that_their_units_are_seen():
    css = (STATIC / "tables.css").read_text(encoding="utf-8")
    assert ".wb-poses .wb-table thead th { white-space: normal" in css


def test_searches_stand_side_by_side(detections):
    assert "to be compared" in searches_html((), None, ())
    searches = (
        SearchRecord(3, 0, SearchOverrides(), detections, 0.25),
        SearchRecord(7, 5, SearchOverrides(1.5, 0.8), detections[:1], 0.5),
    )
    html = searches_html(searches, 7, ("a", "b"))
    assert html.count("<tr") == 3 and html.count("wb-chosen") == 1
    assert "150%" in html and "0.50 s" in html and "none below 0.80" in html


def test_remarks_tell_who_did_what():
    remarks = (Remark(NOW, "Ben", "part-1 was vetoed"), Remark(NOW + 60, "<b>", "corrected"))
    html = remarks_html(remarks, PosesFolder("/in/<poses>", ""))
    assert html.index("&lt;b&gt;") < html.index("Ben"), "the latest first"
    assert "part-1 was vetoed" in html and "/in/&lt;poses&gt;" in html
    assert remarks_html((), None) == ""

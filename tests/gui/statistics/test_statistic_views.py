"""The statistics on the page, and that names from outside become no HTML."""

import pinocchio as pin

from workbench.app.statistics.cycles import CycleRecord, PickRecord
from workbench.app.statistics.remaining import RemainingPart
from workbench.app.statistics.statistics import Statistics
from workbench.gui.statistics.views import statistics_html
from workbench.model.scan import Detection


def cycle(*results: str, grasp: str = "side-1") -> CycleRecord:
    picks = tuple(
        PickRecord(number, "peg", grasp, "right", result)  # type: ignore[arg-type]
        for number, result in enumerate(results)
    )
    return CycleRecord(2, 0.0, 36.0, "right", "done", picks, {"plan": 0.25})


def test_hours_are_told_in_the_zone_that_all_times_are_told_in():
    text = statistics_html(Statistics((cycle("picked"),)))
    assert "Parts taken in each hour [UTC]" in text and ">00:00<" in text


def test_without_a_cycle_there_is_a_hint():
    assert "counted here" in statistics_html(Statistics())


def test_success_and_causes_stand_beside_their_bars():
    html = statistics_html(Statistics((cycle("picked", "failed"),), (("tool collision", 40),)))
    assert "1, 1 failed" in html and "100, without pauses" in html
    assert "1 of 2" in html and "width:50.0%" in html
    assert "tool in collision" in html and "0.25 s, most 0.25 s" in html


def test_parts_that_were_left_are_told_with_what_is_in_the_way():
    left = RemainingPart((Detection("peg", pin.SE3.Identity()),), 0, "walls")
    html = statistics_html(Statistics((cycle("picked"),), remaining=(left, left)))
    assert "2 peg beside a wall of the bin" in html
    assert "Parts left" not in statistics_html(Statistics((cycle("picked"),)))


def test_long_times_have_fewer_digits():
    long = CycleRecord(2, 0.0, 36.0, "right", "done", (), {"plan": 9.25, "approve": 189.91})
    html = statistics_html(Statistics((long,)))
    assert "9.25 s, most 9.25 s" in html and "189.9 s, most 189.9 s" in html


def test_parts_of_which_nothing_is_known_have_no_bar():
    assert "Success by" not in statistics_html(Statistics((cycle("unknown"),)))


def test_names_are_escaped():
    html = statistics_html(Statistics((cycle("picked", grasp="<img src=x>"),)))
    assert "<img" not in html and "&lt;img" in html

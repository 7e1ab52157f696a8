"""The moment of the plan belongs to the state, whatever way it came about."""

from dataclasses import replace

import pytest

from workbench.app.core.state import State
from workbench.app.runtime.live import Live
from workbench.gui.drawing.following import keep_up
from workbench.gui.shared.look import SharedLook
from workbench.gui.shared.playback import joint_values, moments, timeline
from workbench.model.scan import SearchOverrides, SearchRecord


@pytest.fixture
def look():
    return SharedLook(lambda: None)


@pytest.fixture
def go(look, result):
    """Goes from the state before to another one, the robot `at` a time of the plan [s]."""
    before: list[State | None] = [None]
    runs = timeline(result.plan)

    def step(state: State, at: float | None = None) -> float:
        cell = state.cell
        live = Live() if at is None else Live(joints=joint_values(cell, moments(cell, runs, at)))
        keep_up(look, before[0], state, live, runs if state.plan is not None else ())
        before[0] = state
        return look.now.time

    return step


def test_a_hand_on_the_scrubber_as_sending_begins_does_not_hold_the_picture(look, states, go):
    go(states.approved)
    go(states.sending, 0.0)
    assert go(states.sending, 0.4) == pytest.approx(0.4, abs=0.05)
    # It was on its way before sending began, so nobody could refuse it.
    look.change(time=7.0, is_playing=False, by=1)
    assert go(states.sending, 0.8) == pytest.approx(0.8, abs=0.05)
    assert look.now.follows and look.now.by is None


def test_without_reports_the_scrubber_holds_nothing_either(look, states, go):
    go(states.approved)
    go(states.sending)
    look.change(time=7.0, is_playing=True, by=1)
    assert go(states.sending) == 0.0
    assert look.now.follows and not look.now.is_playing


def test_a_cycle_that_was_done_before_the_page_began_is_seen_at_its_end(look, states, go, result):
    assert go(states.done, 0.0) == pytest.approx(result.plan.cycle_seconds)
    assert look.now.follows
    # What is looked at after that is nobody's to take away.
    look.change(time=1.0, is_playing=False, by=1)
    assert go(replace(states.done, message="a pick is reported"), 0.0) == 1.0


def test_one_moment_of_a_recording_looks_the_same_from_both_sides(look, states, go, result):
    end = pytest.approx(result.plan.cycle_seconds)
    order = ("idle", "localized", "planned", "approved", "sending", "done")
    forth = {name: go(getattr(states, name)) for name in order}
    back = {name: go(getattr(states, name)) for name in reversed(order)}
    assert forth == back
    assert forth["done"] == end and forth["approved"] == 0.0
    for name in order:
        assert go(states.done) == end, f"from {name}"
        assert go(getattr(states, name)) == forth[name], f"from the end to {name}"
    go(states.fault)
    look.change(time=2.0, is_playing=False, by=1)
    assert go(states.planned) == 0.0


def test_a_preview_before_sending_goes_on_as_the_state_does(look, states, go):
    go(states.planned)
    look.change(time=2.0, is_playing=False, by=1)
    assert go(states.approved) == 2.0
    assert not look.now.follows


def test_a_preview_after_a_fault_ends_where_the_robot_was(look, states, go):
    go(states.approved)
    go(states.sending, 0.0)
    there = go(states.sending, 0.6)
    go(states.fault, 0.6)
    look.change(time=5.0, is_playing=False, by=1)
    look.change(**look.now.real_moment)
    assert look.now.time == there > 0.0 and look.now.follows
    # So does one that a candidate takes the place of.
    look.change(is_playing=True, browser=1)
    look.change(candidate=2, pose=0)
    assert look.now.time == there and look.now.follows and not look.now.is_playing


@pytest.fixture
def compared(states, look, go):
    """Two searches in one scan; the second one is looked at, and what was rejected."""
    first, other = states.localized.detections, states.localized.detections[:1]
    searches = (
        SearchRecord(3, 0, SearchOverrides(), first, 1.0),
        SearchRecord(5, 1, SearchOverrides(), other, 1.0),
    )
    state = replace(states.localized, searches=searches)
    go(state)
    look.change(search=5, searcher=1, rejected=True)
    go(replace(state, message="somebody has taken control"))
    assert look.now.search == 5 and look.now.rejected
    return state


@pytest.mark.parametrize("phase", ["planning", "planned", "approved", "sending", "done"])
def test_parts_of_a_compared_search_are_gone_with_the_plan_and_what_follows(
    look, states, go, compared, phase
):
    go(replace(getattr(states, phase), searches=compared.searches))
    assert look.now.search is None and not look.now.rejected


@pytest.mark.parametrize("after", ["approved", "sending"])
def test_parts_compared_beside_a_plan_are_gone_when_it_is_let_out(look, states, go, after):
    go(states.planned)
    look.change(search=5, searcher=1)
    go(replace(states.planned, message="somebody has taken control"))
    assert look.now.search == 5
    go(getattr(states, after))
    assert look.now.search is None


def test_parts_of_a_compared_search_are_gone_with_another_scan_or_when_they_are_taken(
    look, states, go, compared
):
    go(replace(compared, detections=compared.searches[1].detections))
    assert look.now.search is None
    look.change(search=3)
    go(replace(compared, scan=None, searches=()))
    assert look.now.search is None


def test_a_veto_leaves_what_is_compared(look, states, go, compared):
    go(replace(compared, detections=compared.detections[1:]))
    assert look.now.search == 5

"""What the page says the robots of the scene are: one rule, in every phase."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.runtime.live import Live
from workbench.gui.page.modes import ENDS, STANDS, Mode, mode_html, mode_of
from workbench.gui.shared.look import FilmMoment, Jogged, Look, Pose, SharedLook
from workbench.gui.shared.own import Own, Showing
from workbench.model.geometry import Box
from workbench.model.scan import LocalizationResult, SearchOverrides, SearchRecord


@pytest.fixture
def live(cell):
    """A robot that stands at home and says so."""
    return Live(
        joints={j: q for arm in cell.arms for j, q in zip(arm.joints, arm.home, strict=True)}
    )


def test_without_a_preview_it_is_live_if_it_is_known_where_the_robot_is(states, view_of, live):
    for state in (states.idle, states.planned, states.fault, states.done):
        assert mode_of(view_of(state, live=live)) is Mode.LIVE
        assert mode_of(view_of(state)) is Mode.NO_REPORT
    assert mode_of(view_of(states.sending, live=live)) is Mode.MOVING
    assert "does not report" in mode_html(view_of(states.idle))


def test_a_robot_that_stands_before_a_step_waits(states, view_of, live):
    waiting = view_of(replace(states.sending, waits=3), live=live)
    html = mode_html(waiting)
    assert mode_of(waiting) is Mode.WAITS and "<b>Robot waits</b>" in html
    assert "Ends with Run step 3, or Stop" in html and 'data-mode="waits"' in html
    assert mode_of(view_of(replace(states.sending, waits=0, let=3), live=live)) is Mode.MOVING


def test_one_joint_that_is_not_reported_is_no_report(states, view_of, live):
    joint = next(iter(live.joints))
    some = Live(joints={name: q for name, q in live.joints.items() if name != joint})
    assert mode_of(view_of(states.idle, live=some)) is Mode.NO_REPORT


def test_a_robot_that_is_not_reported_any_more_is_grey_and_its_last_report_has_a_time(
    states, view_of, live
):
    now = view_of(states.fault).at
    lost = Live(last_joints=live.joints, reported_at=now - 47)
    view = view_of(states.fault, live=lost)
    html = mode_html(view)
    assert mode_of(view) is Mode.NO_REPORT
    assert "Grey: last reported at 08:52:33 UTC; it may be elsewhere now" in html
    assert "Solid:" not in html and "at home" not in html
    yesterday = replace(lost, reported_at=now - 86_400)
    assert "at 2025-10-08 08:53:20 UTC" in mode_html(view_of(states.fault, live=yesterday))
    never = mode_html(view_of(states.fault))
    assert "Grey: drawn at home; the controller does not report where it is" in never


def test_a_preview_says_so_until_its_end_and_there_too(states, view_of, live, result):
    end = result.plan.cycle_seconds
    for time, playing, mode in (
        (0.0, True, Mode.PREVIEW),
        (2.0, False, Mode.PREVIEW),
        (end, False, Mode.END),
        (0.0, False, Mode.LIVE),
    ):
        view = view_of(states.planned, Look(time=time, is_playing=playing, follows=False), live)
        assert mode_of(view) is mode
    assert "not yet fallen; nothing was sent" in mode_html(
        view_of(states.planned, Look(time=end, follows=False))
    )


def test_after_a_cycle_the_start_of_its_plan_is_no_live_picture(states, view_of, live):
    """The parts lie in the bin there, and in truth on their trays."""
    assert mode_of(view_of(states.done, Look(time=0.0, follows=False), live)) is Mode.PREVIEW


def test_what_one_does_alone_is_said_there_and_a_recording_never_looks_live(
    states, view_of, live, cell
):
    q = {arm.name: np.asarray(arm.home) for arm in cell.arms}
    jogged = replace(
        view_of(states.planned, live=live), own=Own(jog=q), jogged=Jogged(q, (), 1.0, None, ())
    )
    assert mode_of(jogged) is Mode.JOG
    assert "in your view alone" in mode_html(jogged)
    for state in states.all:
        assert mode_of(replace(view_of(state), is_recorded=True)) is Mode.RECORDED


def test_a_film_is_called_a_simulation_whatever_else_is_under_way(states, view_of, live):
    showing = Showing(None, 5.0, {})
    for state in states.all:
        view = replace(
            view_of(state, live=live), own=Own(film=showing), filmed=FilmMoment({}, (), "")
        )
        html = mode_html(view)
        assert mode_of(view) is Mode.FILM and 'data-mode="film"' in html
        assert "<b>Simulation</b>" in html and "in your view alone" in html
        assert "not what is in the bin; nothing is sent" in html
        assert "Solid: the robot, as its controller reports it" in html


def test_each_mode_that_a_person_ends_says_how(states):
    assert set(STANDS) == set(Mode)
    assert set(ENDS) == {Mode.PREVIEW, Mode.END, Mode.JOG, Mode.POSE, Mode.FILM}


def test_a_preview_after_a_cycle_is_ended_by_another_button(states, view_of, live):
    look = Look(time=2.0, follows=False)
    for state in (states.done, states.fault):
        html = mode_html(view_of(state, look, live))
        assert "Ends with End preview" in html and "To the start" not in html
    assert "Ends with To the start, or Send" in mode_html(view_of(states.planned, look, live))


def test_the_legend_says_of_what_the_collision_shapes_are(states, view_of, live, cell):
    def said(view):
        html = mode_html(replace(view, look=replace(view.look, shapes=True)))
        assert "Solid" not in html and "See-through" not in html
        return html

    assert "Collision shapes: the robot, as its" in said(view_of(states.idle, live=live))
    assert "Collision shapes: drawn at home; the" in said(view_of(states.idle))
    moved = Look(time=2.0, follows=False)
    for there in (live, Live()):
        view = view_of(states.planned, moved, there)
        assert view.planned_arms
        assert "Collision shapes: where the plan has it" in said(view)
    q = {arm.name: np.asarray(arm.home) for arm in cell.arms}
    by_hand = replace(view_of(states.idle), own=Own(jog=q), jogged=Jogged(q, (), 1.0, None, ()))
    assert "Collision shapes: moved by you" in said(by_hand)
    recorded = replace(view_of(states.planned, moved), is_recorded=True)
    assert "Collision shapes: the recorded plan" in said(recorded)


def test_a_candidate_and_a_preview_take_each_others_place():
    look = SharedLook(lambda: None)
    look.change(candidate=3, pose=0)
    assert look.now.follows and look.now.candidate == 3
    look.change(is_playing=True, browser=1)
    assert look.now.candidate is None and not look.now.follows
    look.change(time=4.0, is_playing=False)
    look.change(candidate=2, pose=0)
    assert look.now.candidate == 2 and look.now.time == 0.0


def test_the_legend_names_the_candidate_that_is_looked_at(states, view_of, live):
    chosen, none = (view_of(states.planned, Look(candidate=k), live) for k in (0, None))
    assert "the chosen candidate" in mode_html(chosen)
    assert "come too close" not in mode_html(chosen)
    met = Pose("failed", None, 0.03, "no", ((Box(np.full(3, 0.1)), pin.SE3.Identity()),))
    assert "Red: the bodies that come too close there" in mode_html(replace(chosen, poses=(met,)))
    assert "the chosen candidate" not in mode_html(none)


def test_the_legend_says_what_parts_of_searches_are(states, view_of, live):
    found = states.localized.detections
    searches = tuple(SearchRecord(number, 0, SearchOverrides(), found, 1.0) for number in (3, 5))
    state = replace(states.localized, searches=searches)
    findings = LocalizationResult(found, (object(),))
    html = mode_html(view_of(state, Look(search=5), replace(live, findings=findings)), "end")
    assert "Violet: parts of search 2, to be compared; not taken" in html
    assert 'data-ends="end"' in html and "rejected" not in html
    html = mode_html(view_of(state, Look(rejected=True), replace(live, findings=findings)), "end")
    assert "Red, see-through: poses that the search rejected" in html
    assert "Violet" not in html and "data-ends" not in html

"""Failed parts are left alone for a while, and too many failures stop the cycle."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from line import NOW, Line, send

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.outcomes import (
    AVOID_SCANS,
    MOST_FAILURES,
    AcknowledgeFault,
    ForgetAvoided,
    ReportPick,
    avoided_parts,
    parts_sent_for,
)
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.core.state import Phase, sent_for
from workbench.model.errors import CommandRefused
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.release import PartReport, PickResult
from workbench.model.scan import Detection


@pytest.fixture
def line(cell) -> Line:
    return Line(cell)


def cycle(line, samples) -> None:
    """One whole cycle, all of it well as far as the controller knows."""
    send(line, samples)
    line.do(LinkEnded(parts_placed=1))


def refused(line, command, actor="ada") -> str:
    with pytest.raises(CommandRefused) as caught:
        line.do(command, actor)
    return str(caught.value)


def test_a_person_or_the_robot_link_says_what_became_of_a_part(line, samples):
    cycle(line, samples)
    state = line.do(ReportPick(0, True), "robot link")
    assert str(state.message) == "robot link reports: part-1 was picked"
    state = line.do(ReportPick(0, False, "it fell"), "ada")
    (outcome,) = state.outcomes
    assert (outcome.is_picked, outcome.by, outcome.why) == (False, "ada", "it fell")
    assert str(state.message) == "ada reports: part-1 failed: it fell"


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (ReportPick(7, True), "does not take that part; it takes part-1"),
        (ReportPick(0, "yes"), "is neither"),
        (ReportPick(0, False, "x" * 201), "up to 200"),
        (ReportPick(0, False, "a\nb"), "printable"),
    ],
)
def test_outcomes_that_make_no_sense_are_refused(line, samples, command, expected):
    cycle(line, samples)
    assert expected in refused(line, command)


def test_an_outcome_needs_something_sent_and_is_taken_once(line, samples):
    assert "nothing was sent" in refused(line, ReportPick(0, True))
    cycle(line, samples)
    line.do(ReportPick(0, True))
    assert "ada has reported that already" in refused(line, ReportPick(0, True), "bob")


def test_a_failed_part_is_avoided_where_it_lies_for_some_scans(line, samples):
    cycle(line, samples)
    line.do(ReportPick(0, False, "slipped"))
    for number in range(AVOID_SCANS):
        line.do(UseScan(samples.scan(number)))
        line.do(FindParts())
        line.ended(samples.detections())
        line.do(MakePlan())
        assert line.effects[-1].arguments["avoided"] == (
            (0, VerdictNote.PICK_FAILED_SINCE(why="slipped")),
        )
        line.ended(samples.refused())
    line.do(UseScan(samples.scan(9)))
    assert line.state.avoided == ()


def test_a_part_elsewhere_or_of_another_kind_is_not_avoided(line, samples):
    cycle(line, samples)
    state = line.do(ReportPick(0, False))
    (one,) = state.detections
    beside = Detection("peg", one.T_world_part * pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.016])))
    near = Detection("peg", one.T_world_part * pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.014])))
    other = replace(one, part="gear")
    found = replace(state, detections=(beside, near, other))
    assert [number for number, _ in avoided_parts(found, NOW)] == [1]


def test_a_moved_bin_takes_its_failed_parts_along(line, samples):
    cycle(line, samples)
    state = line.do(ReportPick(0, False))
    T = pin.SE3(pin.utils.rotate("z", 0.3), np.array([0.1, 0.0, 0.0]))
    bin_ = replace(state.cell.bin, T_world_bin=T * state.cell.bin.T_world_bin)
    (one,) = state.detections
    moved = Detection("peg", T * one.T_world_part)
    found = replace(state, cell=replace(state.cell, bin=bin_), detections=(one, moved))
    assert [number for number, _ in avoided_parts(found, NOW)] == [1]


def test_avoiding_ends_with_time_and_by_a_word(line, samples):
    cycle(line, samples)
    line.do(ReportPick(0, False))
    assert avoided_parts(line.state, NOW + 599) and not avoided_parts(line.state, NOW + 600)
    assert line.do(ForgetAvoided()).avoided == ()
    assert "no part is avoided" in refused(line, ForgetAvoided())


def test_a_part_picked_after_all_is_not_avoided(line, samples):
    cycle(line, samples)
    line.do(ReportPick(0, False))
    state = line.do(ReportPick(0, True))
    assert (state.avoided, state.failures) == ((), 0)


def test_failures_in_a_row_stop_the_cycle_until_somebody_has_looked(line, samples):
    for number in range(1, MOST_FAILURES + 1):
        cycle(line, samples)
        state = line.do(ReportPick(0, False))
        assert state.failures == number
    assert state.phase is Phase.FAULT
    assert "3 picks in a row have failed" in str(state.fault)
    assert "3 picks in a row have failed" in refused(line, TakeScan())
    state = line.do(AcknowledgeFault())
    assert (state.phase, state.failures) == (Phase.IDLE, 0)


def test_what_became_of_a_part_can_be_said_after_a_fault_until_the_next_scan(line, samples):
    send(line, samples)
    line.do(ReportPick(0, True))
    line.do(LinkEnded("the link was closed"))
    state = line.do(AcknowledgeFault())
    assert (state.phase, state.plan) == (Phase.IDLE, None)
    assert parts_sent_for(state) == ((0, "right"),)
    # Before the fault the part may still have been in the hand.
    line.do(ReportPick(0, True))
    assert "ada has reported that already" in refused(line, ReportPick(0, True))
    state = line.do(ReportPick(0, False, "it fell"))
    (outcome,) = sent_for(state).outcomes
    assert (outcome.is_picked, outcome.why) == (False, "it fell")
    assert (len(state.avoided), state.failures) == (1, 1)
    line.do(UseScan(samples.scan(1)))
    assert line.state.avoided and parts_sent_for(line.state) == ()
    assert "nothing was sent" in refused(line, ReportPick(0, True))


def test_what_became_of_a_part_can_be_said_after_a_change_of_the_cell(line, samples):
    cycle(line, samples)
    line.do(ReportPick(0, True))
    bin_ = replace(line.state.cell.bin, size=(0.5, 0.5, 0.1))
    state = line.do(ChangeCell(replace(line.state.cell, bin=bin_), "another bin"))
    assert (state.phase, state.plan) == (Phase.IDLE, None)
    line.do(ReportPick(0, False))
    assert [one.is_picked for one in sent_for(line.state).outcomes] == [False]
    line.do(UseDetections(samples.detections(), "from a file"))
    assert parts_sent_for(line.state) == ()


def test_a_failure_that_a_person_has_reported_before_the_link_counts_once(line, samples):
    send(line, samples)
    line.do(ReportPick(0, False, "it fell"), "bob")
    state = line.do(LinkEnded(parts=(PartReport("right", 0, False, "no vacuum"),)))
    assert (state.failures, len(state.avoided)) == (1, 1)
    (outcome,) = state.outcomes
    assert (outcome.by, outcome.why) == ("bob", "it fell")


def test_a_picked_part_breaks_the_row(line, samples):
    for is_picked in (False, False, True, False):
        cycle(line, samples)
        line.do(ReportPick(0, is_picked))
    assert (line.state.phase, line.state.failures) == (Phase.DONE, 1)


def test_what_a_gripper_says_while_sending_stops_the_cycle_at_its_end(line, samples):
    for _ in range(MOST_FAILURES - 1):
        cycle(line, samples)
        line.do(ReportPick(0, False))
    send(line, samples)
    assert line.do(ReportPick(0, False, "no vacuum"), "robot link").phase is Phase.SENDING
    assert line.do(LinkEnded()).phase is Phase.FAULT


@pytest.mark.parametrize(
    ("is_picked", "result", "said"),
    [
        (False, PickResult.DROPPED, "part-1 was dropped"),
        (True, PickResult.DOUBLE, "a second part came with part-1"),
    ],
)
def test_a_dropped_part_and_a_double_pick_are_reported_as_such(
    line, samples, is_picked, result, said
):
    cycle(line, samples)
    state = line.do(ReportPick(0, is_picked, "", result))
    (outcome,) = state.outcomes
    assert (outcome.became, outcome.is_picked) == (result, is_picked)
    assert said in str(state.message)
    assert "reported that already" in refused(line, ReportPick(0, is_picked, "", result))
    (corrected,) = line.do(ReportPick(0, is_picked)).outcomes
    assert corrected.became is (PickResult.PICKED if is_picked else PickResult.FAILED)


@pytest.mark.parametrize("is_picked", [True, False])
def test_a_result_that_contradicts_is_picked_is_refused(line, samples, is_picked):
    cycle(line, samples)
    other = PickResult.DROPPED if is_picked else PickResult.DOUBLE
    assert "does not fit is_picked" in refused(line, ReportPick(0, is_picked, "", other))


def test_a_dropped_part_is_avoided_as_a_failed_one_and_a_double_pick_is_not(line, samples):
    cycle(line, samples)
    state = line.do(ReportPick(0, False, "", PickResult.DROPPED))
    assert (len(state.avoided), state.failures) == (1, 1)
    state = line.do(ReportPick(0, True, "", PickResult.DOUBLE))
    assert (len(state.avoided), state.failures) == (0, 0)


@pytest.mark.parametrize(
    ("is_picked", "result"),
    [(True, None), (False, None), (False, PickResult.DROPPED), (True, PickResult.DOUBLE)],
)
@pytest.mark.parametrize("is_sending", [True, False])
def test_a_place_is_sure_only_when_its_part_alone_was_picked(
    line, samples, is_picked, result, is_sending
):
    send(line, samples)
    found = line.state.plan.detections[0].T_world_part
    put = Detection("peg", pin.SE3.Identity(), T_world_found=found)
    report = ReportPick(0, is_picked, "", result)
    ended = LinkEnded(parts=(PartReport("right", 0, True),), parts_placed=1, placed=(put,))
    for command in (report, ended) if is_sending else (ended, report):
        if not (command is report and is_picked and result is None and not is_sending):
            line.do(command)
    (part,) = line.state.placed
    assert (part.score > 0) == (is_picked and result is None)


@pytest.mark.parametrize("result", [PickResult.DROPPED, PickResult.DOUBLE])
def test_the_gripper_does_not_overrule_what_a_person_has_seen(line, samples, result):
    send(line, samples)
    line.do(ReportPick(0, result.is_picked, "", result), "bob")
    state = line.do(LinkEnded(parts=(PartReport("right", 0, True),), parts_placed=1))
    assert [(outcome.became, outcome.by) for outcome in state.outcomes] == [(result, "bob")]

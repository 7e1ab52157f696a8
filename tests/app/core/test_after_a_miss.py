"""After a grip that closed on nothing the other parts of the same scan can be planned for."""

from dataclasses import replace

import pytest
from line import refused
from missed import END, MISSED, PICKED, sending, with_policy

from workbench.app.core.after_a_miss import is_rest_known
from workbench.app.core.cell.bins import NewBin
from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.outcomes import MOST_FAILURES, ReportPick
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import StartJob
from workbench.app.core.people import WORKER
from workbench.app.core.session import Opened
from workbench.app.core.state import Phase
from workbench.model.release import PickResult
from workbench.plugins.robot_link import controller_by

POSES_ALONE = controller_by("pick-server", options={"poses": "kuka"})


@pytest.fixture
def cell(in_rows):
    return with_policy(in_rows.cell, pair_gap=0.01)


def with_two_bins(cell):
    left, right = (
        replace(cell.bin, name=name, number=k) for k, name in ((1, "left"), (2, "right"))
    )
    return replace(cell, bin=left, other_bins=(right,))


def started(line) -> list[str]:
    return [effect.name for effect in line.effects if isinstance(effect, StartJob)]


def test_plan_goes_on_with_the_parts_that_lie_as_scanned(in_rows, cell):
    line = sending(in_rows, cell)
    scan, (first, second, third) = line.state.scan, line.state.plan.detections
    state = line.do(END)
    assert state.phase is Phase.DONE and is_rest_known(state)
    assert "1 part is left in this scan" in str(state.message)
    state = line.do(MakePlan())
    assert (state.phase, state.scan, state.detections) == (Phase.LOCALIZED, scan, (third,))
    assert state.disturbed == (first, second)
    assert (state.plan, state.approval, state.outcomes) == (None, None, ())
    asked = line.effects[-1].arguments
    assert (asked["detections"], asked["disturbed"]) == ((third,), (first, second))
    assert asked["scan_digest"] == scan.digest
    plan = replace(in_rows.plan(scan.digest, cell=cell), detections=(third,))
    result = replace(in_rows.planned(scan.digest), plan=plan, proof=in_rows.proof(plan))
    state = line.ended(replace(result, row=(), row_ends=None))
    assert (state.phase, state.votes) == (Phase.PLANNED, ())
    assert "played to its end" in refused(line, Approve(plan.digest))


@pytest.mark.parametrize(
    "end",
    [
        replace(END, parts=(replace(MISSED, is_missed=False),)),
        replace(END, parts=(PICKED,)),
        replace(END, parts=()),
        replace(END, parts=(replace(MISSED, is_picked=None, is_missed=False),)),
        replace(END, may_have_moved=None),
        replace(END, may_have_moved=(0, 1, 2)),
        replace(END, row_ends="the robot stands elsewhere"),
        replace(END, fault="the link broke"),
    ],
)
def test_any_doubt_asks_for_a_new_scan(in_rows, cell, end):
    line = sending(in_rows, cell)
    state = line.do(end)
    assert not is_rest_known(state)
    assert "this scan" not in str(state.message)
    if state.phase is Phase.DONE:
        assert "take a new scan first" in refused(line, MakePlan())


@pytest.mark.parametrize("result", list(PickResult))
@pytest.mark.parametrize("is_before", [True, False])
def test_a_person_who_reports_on_the_part_asks_for_a_new_scan(in_rows, cell, result, is_before):
    line = sending(in_rows, cell)
    report = ReportPick(0, result.is_picked, "", result)
    for command in (report, END) if is_before else (END, report):
        if command is report and not is_before and result is PickResult.FAILED:
            assert "reported that already" in refused(line, report)
            return
        line.do(command)
    # A picked part was missed by the gripper's later report.
    assert is_rest_known(line.state) == (is_before and result is PickResult.PICKED)


def test_who_has_stopped_the_robot_takes_a_new_scan(in_rows, cell):
    line = sending(in_rows, cell)
    line.do(Stop())
    assert not is_rest_known(line.do(END))


@pytest.mark.parametrize(
    "change",
    [
        lambda cell: with_policy(cell, pair_gap=0.0),
        lambda cell: replace(cell, controller=POSES_ALONE),
    ],
)
def test_cells_in_which_nobody_knows_what_moves_take_a_new_scan(in_rows, cell, change):
    line = sending(in_rows, cell)
    line.state = replace(line.state, cell=change(cell))
    assert not is_rest_known(line.do(END))


def test_parts_from_outside_are_not_planned_for_again(in_rows, cell):
    line = sending(in_rows, cell)
    line.state = replace(line.state, scene_digest="of poses")
    assert not is_rest_known(line.do(END))


@pytest.mark.parametrize("command", [NewBin("left"), Opened()])
def test_whatever_may_have_changed_the_bin_asks_for_a_new_scan(in_rows, cell, command):
    line = sending(in_rows, with_two_bins(cell))
    assert is_rest_known(line.do(END))
    by = WORKER if isinstance(command, Opened) else "ada"
    assert not is_rest_known(line.do(command, by))


def test_the_old_scan_is_searched_no_more(in_rows, cell):
    line = sending(in_rows, cell)
    line.do(END)
    line.do(MakePlan())
    line.ended(in_rows.refused())
    assert "may have moved parts of this scan" in refused(line, FindParts())
    line.do(UseDetections(line.state.detections, "moved by hand"))
    assert len(line.state.disturbed) == 2
    assert "may have moved parts of this scan" in refused(line, FindParts())
    moved = replace(cell, bin=replace(cell.bin, size=(0.5, 0.5, 0.1)))
    assert line.do(ChangeCell(moved, "another bin")).scan is None


def test_a_scan_shows_again_what_has_moved(in_rows, cell):
    line = sending(in_rows, cell)
    line.do(END)
    line.do(MakePlan())
    line.ended(in_rows.refused())
    line.do(TakeScan())
    assert line.ended(in_rows.scan(3)).disturbed == ()
    line.do(FindParts())


def test_no_plan_for_the_rest_does_not_call_the_bin_empty(in_rows, cell):
    line = sending(in_rows, with_two_bins(cell))
    line.do(END)
    line.do(MakePlan())
    assert line.ended(in_rows.refused()).empty_bins == ()


def test_the_next_cycle_scans_unless_the_cell_has_it_otherwise(in_rows, cell):
    for is_wanted, first in ((False, "scan"), (True, "plan")):
        line = sending(in_rows, with_policy(cell, retry_without_scan=is_wanted))
        line.do(END)
        line.do(GoOn())
        assert started(line) == [first]


def test_the_next_cycle_scans_where_nothing_of_the_rest_can_be_taken(in_rows, cell):
    line = sending(in_rows, with_policy(cell, retry_without_scan=True))
    line.do(END)
    line.do(GoOn())
    line.ended(in_rows.refused())
    assert started(line) == ["plan", "scan"]
    line.ended(in_rows.scan(2))
    assert started(line)[2:] == ["localize"]


def test_a_next_cycle_that_was_asked_for_ahead_goes_on_with_the_rest(in_rows, cell):
    for is_wanted, names in ((False, []), (True, ["plan"])):
        line = sending(in_rows, with_policy(cell, retry_without_scan=is_wanted))
        line.do(GoOn(sees_from=0, placed=()))
        state = line.do(END)
        assert started(line) == names
        assert state.ahead is None
        assert (state.job is not None) == is_wanted


def test_a_row_that_a_miss_ends_goes_on_likewise(in_rows, cell):
    line = sending(in_rows, cell, picks=3)
    _, second, third = line.state.plan.detections
    line.do(LinkEnded("", 1, (PICKED,), ()))
    state = line.do(replace(END, may_have_moved=(0,)))
    assert (state.phase, state.row) == (Phase.DONE, ())
    assert is_rest_known(state)
    state = line.do(MakePlan())
    assert (state.detections, state.disturbed) == ((third,), (second,))


def test_a_part_that_the_other_hand_has_taken_is_gone(in_rows, cell):
    line = sending(in_rows, cell)
    plan = line.state.plan
    both = replace(plan, arms=(*plan.arms, replace(plan.arms[0], detection=1)))
    line.state = replace(line.state, plan=both)
    first, _, third = line.state.plan.detections
    other = replace(PICKED, detection=1)
    line.do(replace(END, parts=(MISSED, other), parts_placed=1))
    state = line.do(MakePlan())
    assert (state.detections, state.disturbed) == ((third,), (first,))


def test_what_a_second_miss_may_have_moved_is_added(in_rows, cell):
    line = sending(in_rows, cell)
    first, second, third = line.state.plan.detections
    line.do(replace(END, may_have_moved=(0,)))
    line.do(MakePlan())
    scan = line.state.scan.digest
    plan = replace(in_rows.plan(scan, cell=cell), detections=(second, third))
    result = replace(in_rows.planned(scan), plan=plan, proof=in_rows.proof(plan))
    line.ended(replace(result, row=(), row_ends=None))
    for command in (WatchPlan(plan.digest), Approve(plan.digest), SendPlan(plan.digest)):
        line.do(command)
    line.do(replace(END, may_have_moved=(0,)))
    state = line.do(MakePlan())
    assert (state.detections, state.disturbed) == ((third,), (first, second))


def test_misses_in_a_row_are_a_fault_as_ever(in_rows, cell):
    line = sending(in_rows, cell)
    line.state = replace(line.state, failures=MOST_FAILURES - 1)
    assert line.do(END).phase is Phase.FAULT

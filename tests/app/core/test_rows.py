"""Plans in a row: one approval for what was shown, plan after plan, and whatever is odd ends it."""

from dataclasses import replace

import pytest
from line import NOW, Line, refused

from workbench.app.core.cell.changes import UndoCell
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.rows import ShortenRow
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded, NextStep, SendPlan, Sent, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StopSending
from workbench.app.core.state import EditedCell, Phase
from workbench.model.cell import PlanOverrides
from workbench.model.messages.message import plain
from workbench.model.messages.plans import RowEnd
from workbench.model.release import PartReport, PickResult, Receipt
from workbench.plugins.robot_link import controller_by

HOME = {"joint_1": 0.0}
PICKED = (PartReport("right", 0, True),)


def planned(samples, picks=3) -> Line:
    line = Line(samples.cell)
    line.joints = HOME
    line.do(TakeScan())
    scan = samples.scan()
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.row(scan.digest).plan.detections)
    line.do(MakePlan(threshold=0.2))
    line.ended(samples.row(scan.digest, picks=picks))
    return line


def digests(line: Line) -> tuple[str, tuple[str, ...]]:
    return line.state.plan.digest, tuple(one.plan.digest for one in line.state.row)


def approved(samples, picks=3) -> Line:
    line = planned(samples, picks)
    plan, row = digests(line)
    line.do(WatchPlan(plan, row=row))
    line.do(Approve(plan, row=row))
    return line


def sending(samples, picks=3) -> Line:
    line = approved(samples, picks)
    line.effects.clear()
    line.do(SendPlan(line.state.plan.digest))
    return line


def sent(line: Line) -> list[str]:
    return [one.plan.digest for one in line.effects if isinstance(one, Send)]


def ends(line: Line, **otherwise) -> None:
    line.do(replace(LinkEnded("", 1, PICKED, ()), **otherwise))


def test_a_planning_brings_a_row_and_says_how_many(in_rows):
    state = planned(in_rows).state
    assert len(state.row) == 2
    assert len(state.plans) == len(state.whole_row) == 3
    assert state.row_ends == RowEnd.NO_PART()
    assert "2 more plans in the row" in str(state.message)


def test_one_approval_sends_plan_after_plan_and_each_once(in_rows):
    line = sending(in_rows)
    first = line.state
    plans = [plan.digest for plan in first.plans]
    ends(line)
    assert line.state.phase is Phase.SENDING
    assert [plan.digest for plan in line.state.plans] == plans
    assert line.state.plan.digest == plans[1]
    ends(line)
    ends(line)
    assert line.state.phase is Phase.DONE
    assert sent(line) == plans
    used = [one.approval for one in line.effects if isinstance(one, Send)]
    assert [one.plan_digest for one in used] == plans
    assert len({one.digest for one in used}) == 3
    assert {one.first for one in used[1:]} == {used[0].digest}
    following = [one.following for one in line.effects if isinstance(one, Send)]
    assert [one and one.digest for one in following] == [*plans[1:], None]
    assert line.state.parts_placed == 3
    assert sorted(one.detection for one in line.state.outcomes) == [0, 1, 2]
    assert "3 of 3 parts reported placed" in str(line.state.message)
    assert "not possible now" in refused(line, SendPlan(plans[0]))


def test_what_is_said_of_messages_is_of_the_plan_on_its_way(in_rows):
    line = sending(in_rows)
    line.do(Sent(Receipt(NOW, "right", "start", "startR#", 1, 4)))
    ends(line)
    assert line.state.receipts == line.state.part_reports == ()
    assert str(line.state.message) == "plan 2 of 3 follows"


@pytest.mark.parametrize("command", [Approve, WatchPlan])
def test_who_names_another_row_is_refused(in_rows, command):
    line = planned(in_rows)
    plan, row = digests(line)
    line.do(WatchPlan(plan, row=row))
    for other in ((), row[:1], row[::-1], (*row, row[0]), (row[0], "0" * 64)):
        assert "look at the current row" in refused(line, command(plan, row=other))


def test_an_approval_for_three_does_not_send_two_others(in_rows):
    line = approved(in_rows)
    other = planned(in_rows).state.row
    line.state = replace(line.state, row=other[:1])
    assert "for another row of plans" in refused(line, SendPlan(line.state.plan.digest))
    line.state = replace(line.state, row=other[::-1])
    assert "for another row of plans" in refused(line, SendPlan(line.state.plan.digest))


def test_a_shortened_row_needs_a_new_approval_and_can_be_made_longer_again(in_rows):
    line = approved(in_rows)
    plan, row = digests(line)
    line.do(ShortenRow(plan, 2))
    assert line.state.phase is Phase.PLANNED
    assert line.state.approval is None and line.state.votes == ()
    assert digests(line) == (plan, row[:1])
    assert "limits this row to 2 of 3 picks" in str(line.state.message)
    assert "have the plan approved first" in refused(line, SendPlan(plan))
    # All of what is left was seen.
    line.do(Approve(plan, row=row[:1]))
    assert line.state.approval.row[0][0] == row[0] and len(line.state.approval.row) == 1
    line.do(ShortenRow(plan, 3))
    assert digests(line) == (plan, row)
    assert "play it first" in refused(line, Approve(plan, row=row))
    line.do(ShortenRow(plan, 1))
    assert digests(line) == (plan, ())


@pytest.mark.parametrize(
    ("picks", "said"),
    [(0, "from 1 to 10"), (4, "1 to 3 picks"), (3, "3 picks already"), (2.0, "whole number")],
)
def test_a_row_has_as_many_picks_as_were_planned(in_rows, picks, said):
    line = planned(in_rows)
    assert said in refused(line, ShortenRow(line.state.plan.digest, picks))
    assert "current plan is" in refused(line, ShortenRow("0" * 64, 1))


@pytest.mark.parametrize("how", ["scan", "parts", "plan"])
def test_whatever_begins_anew_makes_the_whole_row_void(in_rows, how):
    line = approved(in_rows)
    plan, _ = digests(line)
    match how:
        case "scan":
            line.do(UseScan(in_rows.scan(5)))
        case "parts":
            line.do(UseDetections(in_rows.detections(3)))
        case _:
            line.do(MakePlan(threshold=0.2))
            line.ended(in_rows.planned(line.state.scene_digest, 4))
    assert (line.state.row, line.state.left_out, line.state.row_ends) == ((), (), None)
    assert line.state.approval is None
    refused(line, SendPlan(plan))


@pytest.mark.parametrize(
    ("ended", "said"),
    [
        ({"fault": "the link is lost", "parts_placed": 0}, "the link is lost"),
        ({"parts": (PartReport("right", 0, False, "nothing held"),)}, "nothing held"),
        ({"parts": (PartReport("right", 0, None, "not told"),)}, "not told"),
        ({"parts": ()}, "has not reported on each part"),
        ({"row_ends": "the votes have lapsed"}, "the votes have lapsed"),
    ],
)
def test_whatever_is_odd_ends_the_row(in_rows, ended, said):
    line = sending(in_rows)
    ends(line)
    plans = [plan.digest for plan in line.state.plans]
    ends(line, **ended)
    assert line.state.phase is (Phase.FAULT if "fault" in ended else Phase.DONE)
    assert sent(line) == plans[:2]
    assert line.state.row == ()
    assert all(one in str(line.state.row_ends) for one in (said, "after 2 of 3 plans"))
    refused(line, SendPlan(plans[2]))


@pytest.mark.parametrize(
    ("joints", "said"),
    [({}, "does not report where the robot stands"), ({"joint_1": 0.2}, "the robot has moved")],
)
def test_the_next_plan_waits_for_a_robot_that_stands_where_it_starts(in_rows, joints, said):
    line = sending(in_rows)
    line.joints = joints
    ends(line)
    assert line.state.phase is Phase.DONE
    assert said in str(line.state.message)
    assert len(sent(line)) == 1


def test_a_stop_ends_the_row_also_when_it_comes_between_two_plans(in_rows):
    line = sending(in_rows)
    # The last message of the first plan is out, and its end is not told yet.
    line.do(Stop(), "bob")
    assert any(isinstance(one, StopSending) for one in line.effects)
    ends(line)
    assert line.state.phase is Phase.DONE
    assert "stopped by bob" in str(line.state.message)
    assert len(sent(line)) == 1
    refused(line, SendPlan(line.state.plan.digest))


def test_an_approval_that_has_run_out_lets_no_further_plan_go(in_rows):
    line = sending(in_rows)
    line.now += 301.0
    ends(line)
    assert line.state.phase is Phase.DONE
    assert "has run out" in str(line.state.message)
    assert len(sent(line)) == 1


def test_a_persons_word_counts_beside_the_grippers(in_rows):
    line = sending(in_rows)
    ends(line)
    line.do(ReportPick(0, False, "it slipped"), "bob")
    assert "bob reports: part-1 failed" in str(line.state.message)
    ends(line)
    assert line.state.phase is Phase.DONE
    assert "bob reports: part-1 was not picked" in str(line.state.message)
    assert "it takes part-1, part-2" in refused(line, ReportPick(2, True))


def test_a_double_pick_ends_the_row(in_rows):
    line = sending(in_rows)
    line.do(ReportPick(0, True, "", PickResult.DOUBLE), "bob")
    ends(line)
    assert line.state.phase is Phase.DONE and len(sent(line)) == 1
    assert "bob reports: a second part came with part-1" in str(line.state.message)


def test_a_person_who_saw_the_part_fall_is_believed_when_the_gripper_tells_otherwise(in_rows):
    line = sending(in_rows)
    line.do(ReportPick(0, False, "it slipped"), "bob")
    ends(line)
    assert line.state.phase is Phase.DONE and len(sent(line)) == 1
    assert "bob reports: part-1 was not picked" in str(line.state.message)


def test_each_plan_of_a_row_is_stepped_from_its_first_step(in_rows):
    line = planned(in_rows)
    plan, row = digests(line)
    line.do(WatchPlan(plan, row=row))
    line.do(Approve(plan, is_stepped=True, row=row))
    line.do(SendPlan(plan))
    line.do(Sent(Receipt(NOW, "", "waits", "", 1, 4, waits=1)))
    line.do(NextStep(1))
    assert line.state.let == 1
    ends(line)
    assert (line.state.let, line.state.waits) == (0, 0)
    assert line.state.approval.is_stepped
    assert "not wait before a step" in refused(line, NextStep(1))
    line.do(Sent(Receipt(NOW, "", "waits", "", 1, 4, waits=1)))
    line.do(NextStep(1))


def test_a_link_that_tells_less_gets_one_plan_at_a_time(in_rows):
    line = planned(in_rows)
    plan, row = digests(line)
    line.do(WatchPlan(plan, row=row))
    cell = replace(line.state.cell, controller=controller_by("abb-socket"))
    line.state = replace(line.state, cell=cell)
    assert "one plan can be sent at a time" in refused(line, Approve(plan, row=row))
    line.do(ShortenRow(plan, 1))
    line.do(Approve(plan))


def test_a_row_is_not_sent_while_nobody_knows_where_the_robot_stands(in_rows):
    line = approved(in_rows)
    line.joints = {}
    assert "reports no joints" in refused(line, SendPlan(line.state.plan.digest))


def test_a_plan_of_the_row_whose_proof_does_not_hold_is_not_approved(in_rows):
    line = planned(in_rows)
    one, other = line.state.row
    bad = replace(other, proof=in_rows.proof(other.plan, holds=False))
    line.state = replace(line.state, row=(one, bad))
    plan, row = digests(line)
    line.do(WatchPlan(plan, row=row))
    assert "proof does not hold" in refused(line, Approve(plan, row=row))


def test_how_many_picks_are_wanted_is_checked(samples, in_rows):
    line = planned(in_rows)
    assert "from 1 to 10" in refused(line, MakePlan(overrides=PlanOverrides(picks=11)))
    # Of the other cell nobody knows which parts move.
    bare = Line(samples.cell)
    bare.do(UseDetections(samples.detections()))
    assert "pair_gap_mm" in refused(bare, MakePlan(overrides=PlanOverrides(picks=2)))


def test_an_undo_of_the_cell_takes_the_row_along(in_rows):
    line = approved(in_rows)
    other = EditedCell(replace(line.state.cell, name="other"), plain("renamed"))
    line.state = replace(line.state, before=(other,))
    line.do(UndoCell())
    assert line.state.plan is None and line.state.row == () and line.state.approval is None
    assert sent(line) == []

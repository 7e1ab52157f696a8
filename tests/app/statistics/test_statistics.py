"""What is counted is what happened, whoever says it, and nothing is counted twice."""

import csv
import io
import json
from dataclasses import replace

import pytest
from arm_scanner_cell import at_view, before_view, on_arm_cell, with_lower_view
from written import Written

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.correcting import CorrectPart
from workbench.app.core.cycle.empty_hand import PlanView
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.state import Phase
from workbench.app.empty_hand.view_plan import plan_view
from workbench.app.picking.pipeline import plan_pick
from workbench.app.runtime.work import scan
from workbench.app.statistics.grasp_use import GraspUse
from workbench.app.statistics.statistics import (
    GROUPS,
    Count,
    Statistics,
    statistics,
    together,
)
from workbench.app.statistics.statistics_table import csv_text
from workbench.journal.journal import Row
from workbench.model.derived.by_view import with_view
from workbench.model.errors import JobCancelled, JournalError, LinkError
from workbench.model.release import PartReport, PickResult
from workbench.perception.simulation.piles import pile_of
from workbench.plugins.progress import never, silent


@pytest.fixture
def written(cell) -> Written:
    return Written(cell)


def results(counted: Statistics) -> list[str]:
    return [pick.result for _, pick in counted.picks]


def test_a_cycle_is_counted_with_its_stages(written, samples):
    written.cycle(samples)
    counted = statistics(written.rows)
    (cycle,) = counted.cycles
    assert (cycle.strategy, cycle.end) == ("right", "done")
    assert dict(cycle.seconds) == {
        "scan": 2.0,
        "find parts": 3.0,
        "plan": 4.0,
        "approve": 3.0,
        "send": 4.0,
    }
    assert cycle.until - cycle.at == 18.0
    ((_, pick),) = counted.picks
    assert (pick.part, pick.grasp, pick.arm, pick.result) == ("peg", "top", "right", "picked")
    assert counted.picks_per_hour == pytest.approx(3600 / 18)
    assert [(s, m) for s, m, _ in counted.stage_medians()][:2] == [("scan", 2.0), ("find parts", 3)]


def test_a_cycle_that_was_gone_on_to_is_counted_with_its_stages(written, samples):
    written.cycle(samples)
    written.do(GoOn())
    written.now += 1
    written.ended(samples.scan(seed=1))
    written.now += 2
    written.ended(samples.detections())
    written.now += 3
    written.ended(samples.planned(written.state.scene_digest))
    first, second = statistics(written.rows).cycles
    assert (first.end, second.end, second.strategy) == ("done", "", "right")
    assert dict(second.seconds) == {"scan": 2.0, "find parts": 3.0, "plan": 4.0}
    assert second.at == 19.0 + first.at


def test_the_search_after_a_corrected_part_is_counted(written, samples):
    written.plan(samples)
    written.do(CorrectPart("peg"))
    peg = written.state.cell.parts[0]
    written.ended(replace(peg, scale=0.9))
    written.now += 4
    written.ended(samples.detections())
    (cycle,) = statistics(written.rows).cycles
    assert dict(cycle.seconds)["find parts"] == 5.0


def test_a_task_that_nobody_goes_on_from_begins_no_other(written, samples):
    written.cycle(samples)
    written.do(GoOn())
    written.ended(samples.scan(seed=1))
    written.do(CancelJob())
    written.do(FindParts())
    written.now += 4
    written.ended(())
    assert dict(statistics(written.rows).cycles[1].seconds) == {"scan": 1.0, "find parts": 5.0}


def test_a_person_knows_better_than_the_controller(written, samples):
    written.cycle(samples)
    written.do(ReportPick(0, False, "slipped"))
    counted = statistics(written.rows)
    assert results(counted) == ["failed"]
    (rate,) = counted.rates(GROUPS["arm"])
    assert (rate.name, rate.picked, rate.failed, rate.share) == ("right", 0, 1, 0.0)
    written.do(ReportPick(0, True))
    assert results(statistics(written.rows)) == ["picked"]


def test_dropped_parts_and_double_picks_are_counted_as_such(written, samples):
    for result in PickResult:
        written.cycle(samples, LinkEnded(parts_placed=0))
        written.do(ReportPick(0, result.is_picked, "", result))
    counted = statistics(written.rows)
    assert results(counted) == list(PickResult)
    (rate,) = counted.rates(GROUPS["part"])
    assert dict(rate.counts) == dict.fromkeys(PickResult, 1)
    assert (rate.known, rate.share, counted.picked) == (4, 0.25, 2)
    assert [(taken, failed) for _, taken, failed in counted.by_hour()] == [(2, 2)]
    (use,) = counted.grasps().values()
    assert (use.picked, use.failed) == (1, 3)
    table = csv.DictReader(io.StringIO(csv_text(counted)))
    assert [row["result"] for row in table] == ["picked", "failed", "dropped", "double"]


def test_the_gripper_does_not_overrule_a_person_in_the_statistics_either(written, samples):
    written.cycle(samples, LinkEnded(parts_placed=0))
    written.plan(samples)
    digest = written.state.plan.digest
    written.do(WatchPlan(digest))
    written.do(Approve(digest))
    written.do(SendPlan(digest))
    written.do(ReportPick(0, False, "it fell", PickResult.DROPPED))
    written.do(LinkEnded(parts=(PartReport("right", 0, True),), parts_placed=1))
    assert results(statistics(written.rows)) == ["unknown", "dropped"]


def test_what_nobody_knows_is_neither_taken_nor_failed(written, samples):
    written.cycle(samples, LinkEnded(parts_placed=0))
    counted = statistics(written.rows)
    assert results(counted) == ["unknown"]
    assert counted.rates(GROUPS["part"])[0].share == 0.0 and counted.picked == 0


def test_a_fault_ends_a_cycle_and_its_parts_are_unknown(written, samples):
    written.cycle(samples, LinkEnded("the link broke", 1))
    counted = statistics(written.rows)
    assert counted.cycles[0].end == "fault" and results(counted) == ["unknown"]


def test_a_margin_that_is_not_kept_is_counted_as_the_candidates_tell_it(written, samples):
    written.plan(samples, is_possible=False)
    row = written.rows[-1]
    body = json.loads(row.body)
    (one,) = (one for one in body["command"]["result"]["plan"]["candidates"])
    for distance, kind in ((0.001, "margin not kept"), (-0.001, "in collision")):
        one["verdict"]["distance"] = distance
        changed = replace(row, body=json.dumps(body).encode())
        assert statistics((*written.rows[:-1], changed)).refusals == ((kind, 1),)


def test_causes_of_refusal_are_counted_and_no_plan_is_an_end(written, samples):
    written.plan(samples, is_possible=False)
    written.plan(samples)
    counted = statistics(written.rows)
    assert counted.refusals == (("in collision", 1),)
    assert [cycle.end for cycle in counted.cycles] == ["no plan", ""]
    assert counted.picks == (), "a plan that was not sent has taken nothing"


def test_each_grasp_is_counted_as_tried_possible_planned_and_taken(written, samples):
    written.plan(samples, is_possible=False)
    written.cycle(samples)
    written.do(ReportPick(0, False, "slipped"))
    counted = statistics(written.rows)
    assert counted.grasps() == {("peg", "top"): GraspUse(2, 1, 1, 0, 1)}
    twice = together([counted, counted])
    assert twice.grasps()["peg", "top"] == GraspUse(4, 2, 2, 0, 2)


def test_poses_from_outside_say_of_which_part_a_grasp_is(written, samples):
    written.do(UseDetections(samples.detections()))
    written.do(MakePlan())
    written.ended(samples.refused())
    assert statistics(written.rows).grasps() == {("peg", "top"): GraspUse(tried=1)}


def test_a_search_to_be_compared_finds_nothing_that_counts(written, samples):
    written.do(UseScan(samples.scan()))
    written.do(FindParts())
    written.ended(samples.detections())
    before = statistics(written.rows).cycles[0].seconds
    written.do(FindParts(is_compared=True))
    written.now += 50
    written.ended((*samples.detections(), *samples.detections(1)))
    assert statistics(written.rows).cycles[0].seconds == before
    written.do(MakePlan())
    written.ended(samples.refused())
    assert statistics(written.rows).grasps() == {("peg", "top"): GraspUse(tried=1)}


def test_a_cancelled_task_takes_no_time(written, samples):
    number = written.do(TakeScan()).number
    written.do(CancelJob())
    written.do(JobEnded(number, JobCancelled("")))
    assert dict(statistics(written.rows).cycles[0].seconds) == {}


def test_a_late_end_of_a_cancelled_task_is_not_taken_for_the_next_one(written, samples):
    written.do(UseDetections(samples.detections()))
    late = written.do(MakePlan()).number
    written.do(CancelJob())
    written.do(MakePlan(seed=1))
    written.do(JobEnded(late, samples.refused()))
    digest = written.ended(samples.planned(written.state.scene_digest)).plan.digest
    written.do(WatchPlan(digest))
    written.do(Approve(digest))
    written.do(SendPlan(digest))
    written.do(LinkEnded(parts_placed=1))
    counted = statistics(written.rows)
    assert counted.refusals == (), "the plan that was cancelled has refused nothing"
    assert results(counted) == ["picked"]
    assert counted.cycles[0].seconds["plan"] == 2.0


def test_cycles_without_a_scan_are_counted_one_by_one(written, samples):
    for _ in range(2):
        written.do(UseDetections(samples.detections()))
        written.do(UseDetections(samples.detections(), "part-1 was corrected by hand"))
        written.do(MakePlan())
        digest = written.ended(samples.planned(written.state.scene_digest)).plan.digest
        written.do(WatchPlan(digest))
        written.do(Approve(digest))
        written.do(SendPlan(digest))
        written.do(LinkEnded(parts_placed=1))
    counted = statistics(written.rows)
    assert [cycle.end for cycle in counted.cycles] == ["done", "done"]
    assert results(counted) == ["picked", "picked"]


@pytest.mark.parametrize("fault", ["", "the link broke"])
@pytest.mark.parametrize(
    ("is_picked", "result"), [(True, "picked"), (False, "failed"), (None, "unknown")]
)
def test_what_the_controller_told_of_each_part_counts(written, samples, fault, is_picked, result):
    why = "closed to 0.0 mm" if result == "failed" else ""
    part = PartReport("right", 0, is_picked, why)
    written.cycle(samples, LinkEnded(fault, 0, (part,)))
    ((_, pick),) = statistics(written.rows).picks
    assert (pick.result, pick.why) == (result, why)


def test_counting_goes_on_where_it_was(written, samples):
    count = Count()
    for _ in range(2):
        before = len(written.rows)
        written.cycle(samples)
        count.add(written.rows[before:])
        assert count.last == written.rows[-1].number
    assert count.value == statistics(written.rows)
    both = together([statistics(written.rows), statistics(written.rows)])
    assert both.picked == 4 and len(both.cycles) == 4


def test_messages_on_the_wire_are_not_even_read(written, samples):
    written.cycle(samples)
    spoilt = [
        Row(row.number, row.kind, b"not json", (), "", "") if row.kind == "Sent" else row
        for row in written.rows
    ]
    assert statistics(spoilt) == statistics(written.rows)


def test_an_entry_that_cannot_be_read_is_named(written, samples):
    written.cycle(samples)
    rows = [*written.rows, Row(99, "LinkEnded", b"{}", (), "", "")]
    with pytest.raises(JournalError, match=r"entry 99 \(LinkEnded\)"):
        statistics(rows)


def test_the_table_has_a_row_for_each_part_and_no_formula(written, samples):
    written.cycle(samples)
    written.do(ReportPick(0, False, '=HYPERLINK("x")'))
    (row,) = csv.DictReader(io.StringIO(csv_text(statistics(written.rows))))
    assert (row["part"], row["result"], row["plan_s"]) == ("peg", "failed", "4.000")
    assert row["why"] == '\'=HYPERLINK("x")'
    assert row["scan_at"] == "1970-01-12T13:46:41+00:00"


def test_hours_are_those_of_the_clock(written, samples):
    written.cycle(samples)
    written.now += 3600
    written.cycle(samples)
    (first, taken, failed), (second, _, _) = statistics(written.rows).by_hour()
    assert second - first == 3600 and (taken, failed) == (1, 0) and first % 3600 == 0


def test_ten_thousand_entries_are_counted_as_those_of_their_cycles(written, samples):
    written.cycle(samples)
    one = written.rows
    many = [row for _ in range(10_000 // len(one)) for row in one]
    assert statistics(many).picked == 10_000 // len(one)


@pytest.mark.parametrize("way", ["failed", "cancelled"])
def test_an_outcome_told_after_a_scan_that_brought_nothing_is_that_of_the_cycle_before(
    cell, samples, way
):
    line = Written(cell)
    line.cycle(samples, LinkEnded("", 0))
    line.do(TakeScan())
    if way == "failed":
        line.ended(LinkError("no new file came"))
    else:
        line.do(CancelJob())
    line.do(ReportPick(0, is_picked=False, why="it slipped"))
    counted = statistics(line.rows)
    assert [(pick.result, pick.why) for _, pick in counted.picks] == [("failed", "it slipped")]


def test_parts_that_a_planning_without_a_plan_leaves_are_gathered(written, samples):
    written.plan(samples, is_possible=False)
    (left,) = statistics(written.rows).remaining
    assert (left.part, left.hindrance) == ("peg", "floor")
    first = written.rows
    assert len(together([statistics(first), statistics(first)]).remaining) == 2


def test_the_path_of_a_scanner_to_its_view_is_no_cycle():
    cell = on_arm_cell()
    one = Written(cell)
    one.joints = before_view(cell)
    one.do(PlanView())
    digest = one.ended(plan_view(cell)).plan.digest
    one.do(WatchPlan(digest))
    one.do(Approve(digest))
    one.do(SendPlan(digest))
    one.joints = at_view(cell)
    one.do(LinkEnded())
    assert statistics(one.rows).cycles == ()
    one.do(TakeScan())
    assert len(statistics(one.rows).cycles) == 1


def test_a_cycle_with_scans_from_two_views_is_one():
    cell = with_lower_view(on_arm_cell(), merges=True)
    low = with_view(cell, "low")
    truth = pile_of(cell, "", 2, seed=1)
    one = Written(cell)
    one.joints = at_view(cell)
    one.state = replace(one.state, phase=Phase.DONE)
    one.do(GoOn())
    job = {"seed": 1, "parts": 2, "joints": at_view(cell)}
    first = one.ended(scan(cell, job, silent, never)).earlier
    digest = one.ended(plan_view(low, start="bin")).plan.digest
    for command in (WatchPlan(digest), Approve(digest), SendPlan(digest)):
        one.do(command)
    one.joints = at_view(low)
    one.do(LinkEnded())
    one.do(GoOn())
    both = scan(low, job | {"joints": at_view(low), "earlier": first}, silent, never)
    one.ended(both)
    one.ended(truth)
    one.ended(plan_pick(low, truth, both.digest, strategy="left"))
    (cycle,) = statistics(one.rows).cycles
    assert len(cycle.picks) == 1 and set(cycle.seconds) == {"scan", "find parts", "plan"}

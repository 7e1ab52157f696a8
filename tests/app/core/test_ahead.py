"""The next cycle is worked on while a plan runs, and counts for nothing before that ends well."""

from dataclasses import replace

import pytest
from line import NOW, Line, make_plan, refused

from workbench.app.core.control import ReleaseControl, TakeControl
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Sent, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StartJob, StopJob, StopSending
from workbench.app.core.state import Phase
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.states import StateText
from workbench.model.release import PartReport, PickResult, Receipt
from workbench.model.scan import Detection

PICKED, LOST = PartReport("right", 0, True), PartReport("right", 0, False, "closed to 0 mm")
WANTED = GoOn(TakeScan(5), FindParts(5), MakePlan("right", 0.3, 5), sees_from=2, placed=())
GOOD_END = LinkEnded("", 1, (PICKED,), ())


def step(number, part=None):
    """The controller says that a step runs, or what became of a part."""
    return Sent(Receipt(NOW, "", "heard", "", 4, 4, "state", part, step=number))


@pytest.fixture
def sending(in_rows) -> Line:
    """A single plan on its way."""
    line = Line(in_rows.cell)
    line.joints = {"joint_1": 0.0}
    make_plan(in_rows, line)
    return sent(line)


def row_sending(samples) -> Line:
    """The first of three plans in a row on its way."""
    line = Line(samples.cell)
    line.joints = {"joint_1": 0.0}
    line.do(TakeScan())
    scan = samples.scan()
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.row(scan.digest).plan.detections)
    line.do(MakePlan(threshold=0.2))
    line.ended(samples.row(scan.digest))
    return sent(line)


def sent(line: Line) -> Line:
    plan, *row = (one.plan.digest for one in line.state.whole_row)
    for command in (WatchPlan(plan, row=tuple(row)), Approve(plan, row=tuple(row)), SendPlan(plan)):
        line.do(command)
    line.effects.clear()
    return line


def begun(line: Line) -> list[str]:
    return [one.name for one in line.effects if isinstance(one, StartJob)]


def stopped(line: Line) -> list[int]:
    return [one.number for one in line.effects if isinstance(one, StopJob)]


def worked_ahead(line: Line, samples, tasks: int = 3):
    """So many tasks for the next cycle have ended; brings what the plan is made for."""
    line.do(WANTED)
    line.do(step(2))
    scan = samples.scan(seed=7)
    for result in (scan, samples.detections(), samples.planned(scan.digest, seed=9))[:tasks]:
        line.ended(result)
    return scan


def test_the_scan_waits_until_the_robot_is_reported_out_of_view(sending):
    sending.do(WANTED)
    sending.do(step(1))
    assert (begun(sending), sending.state.job) == ([], None)
    sending.do(step(2))
    assert begun(sending) == ["scan"]
    sending.do(step(2))
    assert begun(sending) == ["scan"], "once"


def test_who_asks_late_is_not_late(sending):
    sending.do(step(2))
    sending.do(WANTED)
    assert begun(sending) == ["scan"]


def test_nothing_of_it_counts_before_the_end_and_all_of_it_after(sending, in_rows):
    before = sending.state
    scan = worked_ahead(sending, in_rows)
    state = sending.state
    assert (state.phase, state.job) == (Phase.SENDING, None)
    assert (state.plan, state.scan, state.detections) == (
        before.plan,
        before.scan,
        before.detections,
    )
    assert (state.approval, state.votes) == (before.approval, before.votes)
    assert begun(sending) == ["scan", "localize", "plan"]
    planning = sending.effects[-1].arguments
    assert planning["scan_digest"] == scan.digest and planning["placed"] == ()
    new = in_rows.planned(scan.digest, seed=9).plan
    assert "not possible now" in refused(sending, Approve(new.digest))
    after = sending.do(GOOD_END)
    assert (after.phase, after.plan.digest) == (Phase.PLANNED, new.digest)
    assert (after.scan.digest, after.scene_digest) == (scan.digest, scan.digest)
    assert (after.approval, after.votes, after.watched, after.ahead) == (None, (), (), None)
    assert (after.planned_threshold, after.wanted_threshold) == (0.3, 0.3)
    assert (after.receipts, after.outcomes, after.stale) == ((), (), None)
    assert "1 of 1 part reported placed" in str(after.message) and after.message.mentions(
        StateText.PLAN_READY
    )
    assert not any(isinstance(one, Send) for one in sending.effects)
    assert "played to its end" in refused(sending, Approve(new.digest))
    sending.do(WatchPlan(new.digest))
    sending.do(Approve(new.digest))
    assert sending.do(SendPlan(new.digest)).phase is Phase.SENDING


@pytest.mark.parametrize(
    ("tasks", "phase", "job"),
    [(0, Phase.DONE, "scan"), (1, Phase.SCANNED, "localize"), (2, Phase.LOCALIZED, "plan")],
)
def test_a_task_that_is_not_done_by_the_end_goes_on(sending, in_rows, tasks, phase, job):
    scan = worked_ahead(sending, in_rows, tasks)
    number = sending.state.job.number
    state = sending.do(GOOD_END)
    assert (state.phase, state.job.name, state.job.number) == (phase, job, number)
    for result in (scan, in_rows.detections(), in_rows.planned(scan.digest, seed=9))[tasks:]:
        state = sending.ended(result)
    assert (state.phase, state.job, state.wanted_threshold) == (Phase.PLANNED, None, 0.3)
    assert begun(sending) == ["scan", "localize", "plan"]


def test_an_arm_that_stays_in_view_has_it_begin_at_the_end(sending):
    sending.do(replace(WANTED, sees_from=0))
    sending.do(step(2))
    assert begun(sending) == []
    state = sending.do(GOOD_END)
    assert (state.phase, state.job.name, state.ahead) == (Phase.DONE, "scan", None)


@pytest.mark.parametrize("tasks", [0, 1, 2, 3])
@pytest.mark.parametrize(
    ("end", "phase"),
    [
        (LinkEnded("the controller reports a fault", 0, (), ()), Phase.FAULT),
        (LinkEnded("", 0, (LOST,), ()), Phase.DONE),
        (LinkEnded("", 0, (), ()), Phase.DONE),
        (LinkEnded("", 1, (PICKED,), (Detection("peg", pose_from_rpy((1, 0, 0))),)), Phase.DONE),
    ],
    ids=["fault", "part lost", "nothing told", "other places"],
)
def test_an_end_that_was_not_planned_throws_it_away(sending, in_rows, tasks, end, phase):
    before = worked_ahead(sending, in_rows, tasks), sending.state.plan.digest
    running = [] if sending.state.job is None else [sending.state.job.number]
    state = sending.do(end)
    assert (state.phase, state.job, state.ahead) == (phase, None, None)
    assert state.plan.digest == before[1], "what is looked at is still what was carried out"
    assert stopped(sending) == running
    # What the task still brings is on record and changes nothing.
    for number in running:
        assert sending.do(JobEnded(number, in_rows.scan())).job is None
    assert not any(isinstance(one, Send) for one in sending.effects)


def test_a_stop_throws_it_away_at_once(sending, in_rows):
    worked_ahead(sending, in_rows, 1)
    number = sending.state.job.number
    state = sending.do(Stop(), "bob")
    assert (state.job, state.ahead, state.phase) == (None, None, Phase.SENDING)
    assert isinstance(sending.effects[-2], StopSending) and stopped(sending) == [number]
    assert sending.do(GOOD_END).phase is Phase.DONE, "it came too late to stop anything"
    assert sending.state.job is None


def test_no_scan_is_taken_once_a_pick_has_failed(sending):
    sending.do(WANTED)
    sending.do(step(0, LOST))
    sending.do(step(2))
    assert begun(sending) == []
    state = sending.do(LinkEnded("", 0, (LOST,), ()))
    assert (state.phase, state.job) == (Phase.DONE, None)
    assert "somebody has to check" in str(state.message)


def test_a_person_who_sees_a_part_fall_is_believed(sending, in_rows):
    worked_ahead(sending, in_rows)
    sending.do(ReportPick(0, False, "it fell"))
    state = sending.do(GOOD_END)
    assert (state.phase, state.ahead) == (Phase.DONE, None)


def test_what_was_scanned_ahead_is_thrown_away_after_a_double_pick(sending, in_rows):
    worked_ahead(sending, in_rows)
    sending.do(ReportPick(0, True, "", PickResult.DOUBLE))
    state = sending.do(GOOD_END)
    assert (state.phase, state.ahead, state.job) == (Phase.DONE, None, None)


def test_it_can_be_cancelled_before_it_begins_and_while_it_runs(sending):
    sending.do(WANTED)
    assert "the next cycle starts already" in refused(sending, WANTED)
    assert sending.do(CancelJob()).ahead is None
    assert "no task is running" in refused(sending, CancelJob())
    sending.do(WANTED)
    sending.do(step(2))
    number = sending.state.job.number
    state = sending.do(CancelJob())
    assert (state.ahead, state.job, stopped(sending)) == (None, None, [number])
    assert sending.do(GOOD_END).job is None


@pytest.mark.parametrize(("command", "actor"), [(ReleaseControl(), "ada"), (TakeControl(), "bob")])
def test_whoever_gives_control_away_goes_on_no_more(sending, in_rows, command, actor):
    sending.do(TakeControl(), "ada")
    worked_ahead(sending, in_rows, 1)
    state = sending.do(command, actor)
    assert (state.ahead, state.job, state.phase) == (None, None, Phase.SENDING)
    assert sending.do(GOOD_END).phase is Phase.DONE


@pytest.mark.parametrize(
    ("results", "phase"),
    [((InputError("the scanner does not answer"),), Phase.DONE), ((None, ()), Phase.SCANNED)],
)
def test_a_task_that_brings_nothing_ends_it(sending, in_rows, results, phase):
    sending.do(WANTED)
    sending.do(step(2))
    for result in results:
        sending.ended(in_rows.scan() if result is None else result)
    assert str(sending.state.message).endswith("no further cycle starts")
    state = sending.do(GOOD_END)
    assert (state.phase, state.job, state.plan) == (phase, None, state.plan)
    assert begun(sending) == ["scan", "localize"][: len(results)]


def test_of_a_row_the_last_plan_alone_lets_the_scanner_see(in_rows):
    line = row_sending(in_rows)
    line.do(WANTED)
    for _ in range(2):
        line.do(step(2))
        line.do(GOOD_END)
        assert (begun(line), line.state.phase) == ([], Phase.SENDING)
    line.do(step(1))
    assert begun(line) == []
    line.do(step(2))
    assert begun(line) == ["scan"]
    new = in_rows.scan(seed=7)
    line.ended(new)
    assert line.do(GOOD_END).phase is Phase.SCANNED
    assert line.state.scan.digest == new.digest


def test_a_row_that_ends_early_throws_it_away(in_rows):
    line = row_sending(in_rows)
    line.do(WANTED)
    state = line.do(LinkEnded("", 0, (LOST,), ()))
    assert (state.phase, state.job, state.ahead) == (Phase.DONE, None, None)
    assert begun(line) == []

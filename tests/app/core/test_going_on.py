"""After a finished cycle one word scans, finds and plans; it ends wherever a person is needed."""

import dataclasses

import pytest
from line import Line, planned_line, refused

from workbench.app.core.control import GiveControl, ReleaseControl, TakeControl
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StartJob
from workbench.app.core.people import FRONT_DOOR
from workbench.app.core.state import Phase
from workbench.app.picking.facts import check_installed
from workbench.model.cell import PlanOverrides
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.states import StateText
from workbench.model.scan import SearchOverrides

WANTED = GoOn(
    TakeScan(5, 3),
    FindParts(5, SearchOverrides(0.8)),
    MakePlan("right", 0.3, 5, PlanOverrides(iterations=900)),
)


@pytest.fixture
def done(cell, samples) -> Line:
    line = planned_line(samples, cell)
    digest = line.state.plan.digest
    for command in (WatchPlan(digest), Approve(digest), SendPlan(digest), LinkEnded("", 1)):
        line.do(command)
    assert line.state.phase is Phase.DONE
    line.effects.clear()
    return line


def test_it_scans_finds_and_plans_and_waits_for_the_approval(done, samples):
    line, scan = done, samples.scan(seed=7)
    assert line.do(WANTED).job.name == "scan"
    finding = line.ended(scan)
    assert (finding.phase, finding.job.name) == (Phase.SCANNED, "localize")
    assert finding.job.number == finding.number
    planning = line.ended(samples.detections())
    assert (planning.phase, planning.job.name) == (Phase.LOCALIZED, "plan")
    assert planning.job.number == planning.number
    state = line.ended(samples.planned(scan.digest))
    assert (state.phase, state.job, state.approval) == (Phase.PLANNED, None, None)
    assert (state.watched, state.votes, state.planned_threshold) == ((), (), 0.3)
    began = {one.name: one.arguments for one in line.effects if isinstance(one, StartJob)}
    assert list(began) == ["scan", "localize", "plan"]
    assert began["scan"] == {"seed": 5, "parts": 3, "part": ""}
    assert began["localize"] == {"scan": scan, "seed": 5, "overrides": SearchOverrides(0.8)}
    assert began["plan"]["overrides"] == PlanOverrides(iterations=900)
    assert (began["plan"]["strategy"], began["plan"]["scan_digest"]) == ("right", scan.digest)
    assert not any(isinstance(one, Send) for one in line.effects)
    assert "played to its end" in refused(line, Approve(state.plan.digest))


def test_nothing_found_is_told_and_nothing_is_planned(done, samples):
    done.do(WANTED)
    done.ended(samples.scan())
    state = done.ended(())
    assert (state.job, state.phase) == (None, Phase.SCANNED)
    assert str(state.message) == "no part found; no further cycle starts"


def test_no_plan_is_told(done, samples):
    done.do(WANTED)
    done.ended(samples.scan())
    done.ended(samples.detections())
    state = done.ended(samples.refused())
    assert (state.job, state.phase) == (None, Phase.LOCALIZED)
    assert state.message.text is StateText.NO_PLAN


@pytest.mark.parametrize("tasks", [0, 1])
def test_a_task_that_fails_ends_it(done, samples, tasks):
    done.do(WANTED)
    for result in (samples.scan(),)[:tasks]:
        done.ended(result)
    state = done.ended(InputError("the scanner does not answer"))
    assert state.job is None
    assert str(state.message).endswith("the scanner does not answer; no further cycle starts")


@pytest.mark.parametrize("tasks", [0, 1, 2])
def test_cancelling_ends_it_wherever_it_is(done, samples, tasks):
    done.do(WANTED)
    results = (samples.scan(), samples.detections())
    for result in results[:tasks]:
        done.ended(result)
    number, begun = done.state.job.number, len(done.effects)
    done.do(CancelJob())
    phase = done.state.phase
    state = done.do(JobEnded(number, (*results, samples.refused())[tasks]))
    assert (state.job, state.phase) == (None, phase)
    assert not any(isinstance(one, StartJob) for one in done.effects[begun:])


@pytest.mark.parametrize(
    ("command", "actor"),
    [(ReleaseControl(), "ada"), (ReleaseControl("ada"), FRONT_DOOR), (TakeControl(), "bob")],
)
def test_whoever_has_left_or_gave_control_away_goes_on_no_more(done, samples, command, actor):
    done.do(TakeControl(), "ada")
    done.do(WANTED, "ada")
    said = str(done.do(command, actor).message)
    assert said.endswith("; no further cycle starts after this task")
    state = done.ended(samples.scan())
    assert (state.job, state.phase) == (None, Phase.SCANNED)


def test_who_keeps_control_goes_on(done, samples):
    done.do(TakeControl(), "ada")
    done.do(WANTED, "ada")
    refused(done, GiveControl("bob"), "ada")
    assert done.ended(samples.scan()).job.name == "localize"


def test_another_threshold_meanwhile_is_that_of_the_plan(done, samples):
    done.do(WANTED)
    done.ended(samples.scan())
    done.do(WantThreshold(0.15))
    assert done.ended(samples.detections()).wanted_threshold == 0.15
    assert done.effects[-1].arguments["threshold"] == 0.15


def test_it_is_in_order_after_a_finished_cycle_alone(cell, samples, done):
    assert refused(Line(cell), WANTED) == "the next cycle is not possible now: take a scan first"
    assert "have the plan approved first" in refused(planned_line(samples, cell), WANTED)
    done.do(WANTED)
    assert "has to wait until the scan ends or is cancelled" in refused(done, WANTED)


def test_a_planner_that_is_not_installed_is_told_before_anything_begins(done):
    wanted = dataclasses.replace(WANTED, plan=MakePlan(overrides=PlanOverrides("no-such-planner")))
    with pytest.raises(CommandRefused, match="no-such-planner"):
        check_installed(done.state, wanted)
    check_installed(done.state, WANTED)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"scan": TakeScan(parts=-1)}, "parts must be a whole number from 0 to 30, not -1"),
        ({"find": FindParts(seed=-1)}, "seed must be a whole number"),
        ({"find": FindParts(is_compared=True)}, "not only compared"),
        ({"plan": MakePlan("left")}, "strategy 'left' is not known"),
        ({"plan": MakePlan(threshold=float("nan"))}, "threshold must lie between"),
    ],
)
def test_every_value_is_looked_at_before_it_begins(done, change, says):
    assert says in refused(done, dataclasses.replace(WANTED, **change))
    assert done.effects == []

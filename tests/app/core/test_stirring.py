"""Parts that are stirred, as commands: when, by which rule of the cell, and what it voids."""

from dataclasses import replace

import numpy as np
import pytest
from line import Line, make_plan, refused
from samples import Samples

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.empty_hand import PlanStir
from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.results import is_failure
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import StartJob
from workbench.app.core.state import Phase
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.errors import InputError
from workbench.model.plan import NO_PART, Leg, PlanResult, Step


def no_plan(reason: Reason = Reason.NO_GRIP) -> PlanResult:
    return PlanResult((), None, None, Verdict(reason, Stage.GRASP), {})


@pytest.fixture
def cell(make_cell):
    """A cell whose robot link sends times."""
    made = make_cell()
    motion = replace(made.controller.motion, takes_share=True)
    wide = replace(made.bin, size=np.array([4.0, 4.0, 0.2]))
    return replace(made, bin=wide, controller=replace(made.controller, motion=motion))


@pytest.fixture
def samples(cell):
    return Samples(cell)


@pytest.fixture
def stirring(cell):
    """The cell whose rule allows two stirs in a row."""
    return replace(cell, policy=replace(cell.policy, stirs=2))


def stir_result(samples, cell, scan_digest: str, *, holds: bool = True) -> PlanResult:
    plan = samples.plan(scan_digest, cell=cell)
    times, q = np.array([0.0, 1.0]), np.deg2rad([[0.0], [30.0], [60.0]])
    legs = (
        Leg("reach", "joint", False, 0.0, q[:2], times),
        Leg("stir", "joint", False, 0.0, q[1:], times),
        Leg("home", "joint", False, 0.0, q[[2, 0]], times),
    )
    arm = replace(plan.arms[0], detection=NO_PART, grasp="", legs=legs)
    steps = tuple(Step((("right", leg.name),)) for leg in legs)
    plan = replace(plan, arms=(arm,), sequence=steps)
    verdict = Verdict(Reason.OK, Stage.ROUTE)
    return PlanResult((), plan, samples.proof(plan, holds=holds), verdict, {"route": 0.1})


def found(line: Line, samples) -> str:
    """Parts are found and none can be taken; the digest of their scan."""
    line.do(TakeScan())
    scan = samples.scan()
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.detections())
    line.do(MakePlan())
    line.ended(no_plan())
    return scan.digest


def send(line: Line) -> None:
    plan = line.state.plan
    assert plan is not None
    for command in (WatchPlan, Approve, SendPlan):
        line.do(command(plan.digest))


def test_it_is_planned_approved_and_sent_and_then_a_scan_is_taken(cell, samples):
    line = Line(cell)
    digest = found(line, samples)
    verdict = line.state.verdict
    line.do(PlanStir(3))
    job = line.effects[-1]
    assert isinstance(job, StartJob) and (job.name, job.arguments["seed"]) == ("stir", 3)
    state = line.ended(stir_result(samples, cell, digest))
    assert state.phase is Phase.PLANNED and "right arm can stir the parts" in str(state.message)
    assert state.detections and verdict is not None
    send(line)
    state = line.do(LinkEnded())
    assert state.phase is Phase.DONE and str(state.message) == "the parts are stirred: scan again"
    assert state.stirs == 1
    line.do(TakeScan())
    assert line.ended(samples.scan(1)).detections is None


def test_without_parts_walls_or_times_there_is_none(cell, samples):
    line = Line(cell)
    found(line, samples)
    line.state = replace(line.state, detections=())
    assert "no part was found" in refused(line, PlanStir())
    line.state = replace(line.state, detections=samples.detections())
    narrow = replace(cell.bin, size=np.array([0.2, 0.2, 0.2]))
    line.state = replace(line.state, cell=replace(cell, bin=narrow))
    assert "part-1 does not lie between the walls" in refused(line, PlanStir())
    line.state = replace(line.state, disturbed=samples.detections())
    assert "missed grip" in refused(line, PlanStir())
    line.state = replace(line.state, disturbed=())
    flat = replace(cell, bin=replace(cell.bin, has_walls=False))
    line.state = replace(line.state, cell=flat)
    assert "no walls" in refused(line, PlanStir())
    motion = replace(cell.controller.motion, takes_share=False)
    slow = replace(cell, controller=replace(cell.controller, motion=motion))
    line.state = replace(line.state, cell=slow)
    assert "does not send times" in refused(line, PlanStir())


def continue_cycle(line: Line, samples) -> None:
    """After a cycle the next one finds parts, none of which can be taken."""
    make_plan(samples, line)
    send(line)
    line.do(LinkEnded(parts_placed=1))
    line.do(GoOn())
    line.ended(samples.scan(1))
    line.ended(samples.detections())


def test_a_cycle_stirs_where_none_can_be_taken_as_often_as_the_cell_says(stirring, samples):
    line = Line(stirring)
    make_plan(replace(samples, cell=stirring), line)
    send(line)
    line.do(LinkEnded(parts_placed=1))
    for count in (1, 2):
        line.do(GoOn())
        scan = samples.scan(count)
        line.ended(scan)
        line.ended(samples.detections())
        line.ended(no_plan())
        job = line.effects[-1]
        assert isinstance(job, StartJob) and job.name == "stir"
        assert line.state.job is not None and line.state.job.name == "stir"
        line.ended(stir_result(samples, stirring, scan.digest))
        assert line.state.phase is Phase.PLANNED
        send(line)
        state = line.do(LinkEnded())
        assert (state.phase, state.stirs) == (Phase.DONE, count)
    line.do(GoOn())
    line.ended(samples.scan(3))
    line.ended(samples.detections())
    state = line.ended(no_plan())
    assert state.job is None and state.phase is Phase.LOCALIZED


def test_a_planning_out_of_time_is_no_reason_to_stir(stirring, samples):
    line = Line(stirring)
    continue_cycle(line, replace(samples, cell=stirring))
    assert line.ended(no_plan(Reason.OUT_OF_TIME)).job is None


def test_a_plan_that_takes_parts_begins_the_count_anew(stirring, samples):
    line = Line(stirring)
    line.state = replace(line.state, stirs=2)
    make_plan(replace(samples, cell=stirring), line)
    assert line.state.plan is not None and line.state.stirs == 0


def test_where_no_hand_gets_through_the_parts_stay_as_they_were_judged(cell, samples):
    line = Line(cell)
    found(line, samples)
    verdict = line.state.verdict
    line.do(PlanStir())
    state = line.ended(no_plan(Reason.OUT_OF_REACH))
    assert "no plan to stir the parts" in str(state.message)
    assert state.phase is Phase.LOCALIZED and state.verdict is verdict


def test_a_fault_while_stirring_leaves_the_count(cell, samples):
    line = Line(cell)
    digest = found(line, samples)
    line.do(PlanStir())
    line.ended(stir_result(samples, cell, digest))
    send(line)
    state = line.do(LinkEnded("the cable is out"))
    assert state.phase is Phase.FAULT and state.stirs == 0


def test_what_was_avoided_in_the_bin_is_tried_again(cell, samples):
    line = Line(cell)
    make_plan(samples, line)
    send(line)
    line.do(ReportPick(0, is_picked=False))
    line.do(LinkEnded())
    assert line.state.avoided
    digest = found(line, samples)
    line.do(PlanStir())
    line.ended(stir_result(samples, cell, digest))
    send(line)
    assert line.do(LinkEnded()).avoided == ()


def test_where_stirring_finds_no_path_a_cycle_goes_no_further_by_itself(stirring, samples):
    line = Line(stirring)
    continue_cycle(line, replace(samples, cell=stirring))
    line.ended(no_plan())
    state = line.ended(no_plan(Reason.OUT_OF_REACH))
    assert state.job is None and state.stirs == 2
    assert "no plan to stir the parts" in str(state.message)
    assert is_failure(state.message)


def test_a_stirring_whose_task_fails_ends_the_cycle(stirring, samples):
    line = Line(stirring)
    continue_cycle(line, replace(samples, cell=stirring))
    line.ended(no_plan())
    state = line.ended(InputError("the worker has ended"))
    assert state.job is None and state.stirs == 0
    assert "the planning to stir the parts failed" in str(state.message)
    assert str(state.message).endswith("no further cycle starts")

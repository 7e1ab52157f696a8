"""What a hand holds after a stop or a double pick, dropped back: when, and what it voids."""

from dataclasses import replace

import pytest
from dropping import drop_result
from line import Line, refused, send
from samples import Samples

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ReportPick
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.drop_back import PlanDropBack, is_drop_next, may_hold
from workbench.app.core.effects import StartJob
from workbench.app.core.state import Phase
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.plan import PlanResult
from workbench.model.release import PickResult


@pytest.fixture
def cell(make_cell):
    """A cell whose robot link begins with something in the hand."""
    made = make_cell()
    motion = replace(made.controller.motion, keeps_hand=True)
    return replace(made, controller=replace(made.controller, motion=motion))


@pytest.fixture
def samples(cell):
    return Samples(cell)


def reports(line: Line, cell, off: float = 0.3) -> None:
    """The controller reports all arms at home, but for the right one."""
    values = cell.joint_values({arm.name: arm.home for arm in cell.arms})
    values[cell.arm("right").joints[0]] += off
    line.joints = values


def broken_off(cell, samples) -> Line:
    """A sending has ended in a fault, which somebody has acknowledged."""
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded("stopped by ada"))
    assert not may_hold(line.state)
    line.do(AcknowledgeFault())
    reports(line, cell)
    return line


def test_after_a_fault_it_is_the_next_step_planned_from_where_the_arm_stands(cell, samples):
    line = broken_off(cell, samples)
    assert line.state.phase is Phase.IDLE and is_drop_next(line.state)
    line.do(PlanDropBack("one", seed=4))
    job = line.effects[-1]
    assert isinstance(job, StartJob) and job.name == "drop"
    assert (job.arguments["arm"], job.arguments["held"], job.arguments["seed"]) == (
        "right",
        "one",
        4,
    )
    joints = cell.arm("right").joints
    assert job.arguments["q"].tolist() == [line.joints[name] for name in joints]


def test_it_is_approved_and_sent_like_every_plan_and_then_a_scan_is_needed(cell, samples):
    line = broken_off(cell, samples)
    line.do(PlanDropBack())
    state = line.ended(drop_result(samples, cell))
    assert state.phase is Phase.PLANNED and state.scan is None and state.detections is None
    assert "can drop back what it holds" in str(state.message)
    digest = state.plan.digest
    line.joints = {}
    for command in (WatchPlan, Approve, SendPlan):
        line.do(command(digest))
    state = line.do(LinkEnded())
    assert state.phase is Phase.DONE and "has dropped back what it held" in str(state.message)
    assert state.parts_placed == 0 and not may_hold(state)
    line.do(TakeScan())
    assert line.ended(samples.scan(1)).phase is Phase.SCANNED


def test_a_double_pick_makes_it_the_next_step_and_a_dropped_part_only_offers_it(cell, samples):
    for result, is_next in ((PickResult.DOUBLE, True), (PickResult.DROPPED, False)):
        line = Line(cell)
        send(line, samples)
        line.do(LinkEnded())
        assert not may_hold(line.state)
        line.do(ReportPick(0, result.is_picked, result=result))
        assert may_hold(line.state) and is_drop_next(line.state) is is_next


def test_what_it_cannot_begin_from_is_refused_with_one_sentence(cell, samples):
    line = broken_off(cell, samples)
    assert "one, two or unknown" in refused(line, PlanDropBack("three"))
    assert "no arm 'middle'" in refused(line, PlanDropBack(arm="middle"))
    line.joints = {}
    assert "does not report where arm" in refused(line, PlanDropBack())
    motion = replace(cell.controller.motion, keeps_hand=False)
    other = replace(cell, controller=replace(cell.controller, motion=motion))
    line.state = replace(line.state, cell=other)
    reports(line, cell)
    assert "cannot begin a plan with a part in the hand" in refused(line, PlanDropBack())


def test_without_a_path_the_state_stays_and_says_why(cell, samples):
    line = broken_off(cell, samples)
    line.do(PlanDropBack())
    verdict = Verdict(Reason.IN_COLLISION, Stage.ROUTE)
    state = line.ended(PlanResult((), None, None, verdict, {}))
    assert state.phase is Phase.IDLE and "no plan" in str(state.message)
    assert is_drop_next(state)


def test_a_fault_on_the_way_is_a_fault_like_any(cell, samples):
    line = broken_off(cell, samples)
    line.do(PlanDropBack())
    digest = line.ended(drop_result(samples, cell)).plan.digest
    line.joints = {}
    for command in (WatchPlan, Approve, SendPlan):
        line.do(command(digest))
    assert line.do(LinkEnded("the cable is out")).phase is Phase.FAULT

"""The path to the view as commands: when it is planned, approved and sent, and what it voids."""

from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import at_view, before_view, on_arm_cell, pose_at
from line import Line, refused

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.empty_hand import PlanView
from workbench.app.core.cycle.outcomes import ReportPick, parts_sent_for
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StartJob
from workbench.app.core.state import Phase
from workbench.app.empty_hand.view_plan import plan_view
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Cell
from workbench.model.plan import PlanResult
from workbench.model.scan import Scan


@pytest.fixture(scope="module")
def cell() -> Cell:
    return on_arm_cell()


@pytest.fixture(scope="module")
def result(cell: Cell) -> PlanResult:
    return plan_view(cell)


@pytest.fixture
def line(cell: Cell) -> Line:
    line = Line(cell)
    line.joints = before_view(cell)
    return line


def approved(line: Line, result: PlanResult) -> str:
    line.do(PlanView("bin"))
    plan = line.ended(result).plan
    assert plan is not None
    line.do(WatchPlan(plan.digest))
    line.do(Approve(plan.digest))
    return plan.digest


def test_it_is_planned_approved_and_sent_like_every_plan_and_then_a_scan_is_taken(
    cell: Cell, line: Line, result: PlanResult
) -> None:
    assert "does not stand at view bin" in refused(line, TakeScan())
    digest = approved(line, result)
    assert line.state.phase is Phase.APPROVED
    assert "no parts" in refused(line, MakePlan())
    line.do(SendPlan(digest))
    sent = line.effects[-1]
    assert isinstance(sent, Send) and sent.plan.digest == digest
    line.joints = at_view(cell)
    state = line.do(LinkEnded())
    assert state.phase is Phase.DONE and "stands at view bin" in str(state.message)
    line.do(TakeScan())
    assert isinstance(line.effects[-1], StartJob)


def test_the_way_back_begins_at_the_view_and_no_scan_is_taken_at_its_end(
    cell: Cell, line: Line
) -> None:
    assert "does not stand at view bin" in refused(line, PlanView("home"))
    line.joints = at_view(cell)
    line.do(PlanView("home"))
    state = line.ended(plan_view(cell, view="home"))
    assert str(state.message).startswith("the path from the view home is planned")
    assert state.plan is not None
    for command in (WatchPlan, Approve, SendPlan):
        line.do(command(state.plan.digest))
    line.joints = before_view(cell)
    state = line.do(LinkEnded())
    assert str(state.message) == "the left arm stands at home; go to the view before the next scan"
    assert "does not stand at view bin" in refused(line, TakeScan())
    line.do(PlanView())


def test_it_is_not_approved_by_who_has_not_seen_it(line: Line, result: PlanResult) -> None:
    line.do(PlanView())
    plan = line.ended(result).plan
    assert plan is not None
    assert "play it first" in refused(line, Approve(plan.digest))


def test_it_begins_at_home_alone(cell: Cell, line: Line) -> None:
    line.joints = at_view(cell)
    assert "stands at view bin already" in refused(line, PlanView())
    line.joints = before_view(cell) | {"left_joint_1": 0.5}
    assert "begins at home (home_deg) or another view: axis 1" in refused(line, PlanView())
    line.joints = {}
    real = Line(replace(cell, scanner=replace(cell.scanner, source="folder")))
    assert "nobody knows where the scanner is" in refused(real, PlanView())


def test_an_arm_that_was_moved_meanwhile_is_not_sent(
    cell: Cell, line: Line, result: PlanResult
) -> None:
    digest = approved(line, result)
    line.joints = at_view(cell)
    assert "has moved" in refused(line, SendPlan(digest))


def test_a_scanner_that_stands_has_no_way_and_no_other_view_is_known(line: Line) -> None:
    assert "hangs on no arm" in refused(Line(read_cell("yumi")), PlanView())
    assert "no view 'other'; it has bin" in refused(line, PlanView("other"))
    assert refused(line, PlanView(seed=-1))


def test_without_a_way_everything_stays_but_for_the_reason(line: Line) -> None:
    verdict = Verdict(Reason.NO_PATH, Stage.ROUTE)
    line.do(PlanView())
    state = line.ended(PlanResult((), None, None, verdict, {}))
    assert state.phase is Phase.IDLE and state.plan is None
    assert "no path" in str(state.message)


def test_a_scan_and_its_parts_are_void_once_the_way_is_planned(
    cell: Cell, line: Line, result: PlanResult
) -> None:
    line.joints = at_view(cell)
    q = np.array([line.joints[name] for name in cell.arm("left").joints])
    line.do(UseScan(Scan(np.ones((3, 3)), pose_at(cell, q), "made", joints=at_view(cell))))
    line.joints = before_view(cell)
    line.do(PlanView())
    state = line.ended(result)
    assert state.scan is None and state.detections is None
    assert state.phase is Phase.PLANNED


def test_no_part_is_asked_for_after_it(cell: Cell, line: Line, result: PlanResult) -> None:
    line.do(SendPlan(approved(line, result)))
    line.joints = at_view(cell)
    line.do(LinkEnded())
    assert parts_sent_for(line.state) == ()
    assert refused(line, ReportPick(0, is_picked=True))


def test_a_stop_on_the_way_is_a_fault_like_any(line: Line, result: PlanResult) -> None:
    line.do(SendPlan(approved(line, result)))
    state = line.do(LinkEnded("sending was stopped"))
    assert state.phase is Phase.FAULT

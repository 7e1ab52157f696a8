"""A change of tool as commands: planned, approved, sent, and what the cell is afterwards."""

from dataclasses import replace

import pytest
from line import Line, refused
from samples import Samples
from tool_changing import changed, changer_cell

from workbench.app.core.cell.changes import CellRead, ChangeCell, StateTool, UndoCell
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.empty_hand import PlanStir, PlanToolChange, PlanView
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import StartJob, UseCell
from workbench.app.core.session import Opened, Started
from workbench.app.core.state import Phase
from workbench.app.provenance.inventory import Inventory
from workbench.model.cell import Cell
from workbench.model.plan import PlanResult
from workbench.model.robot import ToolSlot
from workbench.model.tools.slots import with_mounted


@pytest.fixture(scope="module")
def cell() -> Cell:
    return changer_cell()


@pytest.fixture(scope="module")
def result(cell: Cell) -> PlanResult:
    return changed(cell)


def planned(cell: Cell, result: PlanResult) -> Line:
    line = Line(cell)
    line.do(PlanToolChange("wide_cup", seed=3))
    job = line.effects[-1]
    assert isinstance(job, StartJob) and job.name == "change"
    assert (job.arguments["arm"], job.arguments["tool"], job.arguments["seed"]) == (
        *("right", "wide_cup"),
        3,
    )
    line.ended(result)
    return line


def sending(cell: Cell, result: PlanResult) -> Line:
    line = planned(cell, result)
    plan = line.state.plan
    assert plan is not None
    for command in (WatchPlan, Approve, SendPlan):
        line.do(command(plan.digest))
    assert line.state.phase is Phase.SENDING
    return line


def test_after_a_good_end_the_arm_carries_the_new_tool_and_no_scan_counts(cell, result):
    line = planned(cell, result)
    assert line.state.phase is Phase.PLANNED and line.state.scan is None
    assert "right arm can change its tool for wide_cup" in str(line.state.message)
    line = sending(cell, result)
    state = line.do(LinkEnded())
    assert state.phase is Phase.IDLE and state.plan is None and not state.tools_unknown
    assert state.cell.arm("right").tool.name == "wide_cup" and not state.is_saved
    assert any(isinstance(effect, UseCell) for effect in line.effects)
    assert "carries wide_cup now" in str(state.message) and state.stale is None
    assert "carries wide_cup already" in refused(line, PlanToolChange("wide_cup"))
    line.do(PlanToolChange("suction_cup"))


def test_after_a_fault_nothing_is_planned_until_a_person_states_the_tool(cell, result):
    line = sending(cell, result)
    state = line.do(LinkEnded(fault="the robot has stopped"))
    assert state.phase is Phase.FAULT and state.tools_unknown == ("right",)
    line.do(AcknowledgeFault())
    for command in (PlanToolChange("wide_cup"), PlanView(), MakePlan(), PlanStir(), GoOn()):
        assert "nobody has stated which tool the right arm carries" in refused(line, command)
    line.do(TakeScan())
    line.ended(Samples(cell).scan())
    state = line.do(StateTool("right", "suction_cup"))
    assert not state.tools_unknown and state.cell is cell
    assert str(state.message).endswith("the right arm carries suction_cup")
    line.do(PlanToolChange("wide_cup"))


def test_the_statement_of_another_tool_changes_the_cell(cell, result):
    line = sending(cell, result)
    line.do(LinkEnded(fault="the robot has stopped"))
    line.do(AcknowledgeFault())
    assert "it can carry" in refused(line, StateTool("right", "spoon"))
    state = line.do(StateTool("right", "wide_cup"))
    assert state.cell.arm("right").tool.name == "wide_cup" and not state.tools_unknown
    assert "already" in refused(line, StateTool("right", "wide_cup"))


def test_another_change_of_the_cell_states_no_tool(cell, result):
    line = sending(cell, result)
    line.do(LinkEnded(fault="the robot has stopped"))
    line.do(AcknowledgeFault())
    other = replace(cell, policy=replace(cell.policy, margin=0.012))
    assert line.do(ChangeCell(other, "margin")).tools_unknown == ("right",)
    changed = ChangeCell(with_mounted(other, "right", "wide_cup"), "tool")
    assert line.do(changed).tools_unknown == ("right",)


def test_a_cell_file_that_is_read_again_takes_no_tool_off_the_arm(cell, result):
    line = sending(cell, result)
    line.do(LinkEnded())
    edited = replace(cell, policy=replace(cell.policy, margin=0.012))
    assert edited.arm("right").tool.name == "suction_cup"
    state = line.do(CellRead(edited))
    assert state.cell.policy.margin == 0.012
    assert state.cell.arm("right").tool.name == "wide_cup" and not state.is_saved
    arm = edited.arm("right")
    without = replace(arm, tools=(arm.tool,), tool_slots=arm.tool_slots[:1])
    state = line.do(CellRead(replace(edited, arms=(without,))))
    assert state.tools_unknown == ("right",)


def test_a_cell_file_that_is_read_again_states_no_tool(cell, result):
    line = sending(cell, result)
    line.do(LinkEnded(fault="the robot has stopped"))
    line.do(AcknowledgeFault())
    edited = replace(cell, policy=replace(cell.policy, margin=0.012))
    assert line.do(CellRead(edited)).tools_unknown == ("right",)


def test_undo_leaves_the_tool_on_the_arm(cell, result):
    other = replace(cell, policy=replace(cell.policy, margin=0.012))
    line = Line(cell)
    line.do(ChangeCell(other, "margin"))
    line.do(StateTool("right", "wide_cup"))
    state = line.do(UndoCell())
    assert state.cell.policy.margin == cell.policy.margin
    assert state.cell.arm("right").tool.name == "wide_cup"


def test_while_a_tool_is_changed_no_next_cycle_begins(cell, result):
    line = sending(cell, result)
    assert "changes its tool: wait for the end" in refused(line, GoOn())


def test_what_cannot_be_changed_is_refused_before_it_is_planned(cell):
    line = Line(cell)
    assert "has no tool 'spoon'" in refused(line, PlanToolChange("spoon"))
    assert "no arm 'left'" in refused(line, PlanToolChange("wide_cup", "left"))
    motion = replace(cell.controller.motion, takes_tools=False)
    line = Line(replace(cell, controller=replace(cell.controller, motion=motion)))
    assert "couples no tools" in refused(line, PlanToolChange("wide_cup"))


def test_a_plan_that_does_not_hold_is_shown_and_not_approved(cell, result):
    (arm,) = cell.arms
    slots: tuple[ToolSlot, ...] = arm.tool_slots
    assert result.proof is not None and len(slots) == 2
    failed = replace(result.proof, violations=(result.proof.nearest,))
    line = planned(cell, replace(result, proof=failed))
    plan = line.state.plan
    assert plan is not None
    assert refused(line, Approve(plan.digest))


STARTED = Started(Inventory("1", "f", "3.11", "any", "Linux", (), "c", "d", {}, "", {}))


@pytest.mark.parametrize("command", [STARTED, Opened()])
def test_after_a_start_at_a_real_robot_a_person_states_what_it_carries(cell, result, command):
    line = Line(cell)
    assert line.do(command).tools_unknown == ("right",)
    assert "nobody has stated which tool the right arm carries" in refused(
        line, PlanToolChange("wide_cup")
    )
    line.do(StateTool("right", cell.arm("right").tool.name))
    line.do(PlanToolChange("wide_cup"))
    simulated = replace(cell, controller=replace(cell.controller, is_simulated=True))
    assert not Line(simulated).do(command).tools_unknown
    line = sending(simulated, result)
    line.do(LinkEnded(fault="the robot has stopped"))
    assert line.do(command).tools_unknown == ("right",), "what was unknown stays so"

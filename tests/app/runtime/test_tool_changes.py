"""A change of tool over real TCP, from the command to the cell with the new tool, and on record."""

import json
import time
import zipfile
from dataclasses import replace

import pytest
from idle import Idle
from waiting import wait_until

from workbench.app.core.command import Role
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.empty_hand import PlanToolChange
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.sending import SendPlan, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.state import Phase
from workbench.app.empty_hand.tool_change import plan_tool_change
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.statistics.statistics import statistics
from workbench.extras.evidence.bundle import write_bundle
from workbench.extras.evidence.steps import approval_problems, step_problems
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.journal.journal import Journal


@pytest.fixture
def approved(controller, machines, tmp_path):
    """Makes a bench with an approved change, and the simulated controller that it goes to."""
    benches = []

    def make(speed=200.0, faults=()):
        cell = read_cell(find("robots", "tx2_90") / "tool_changer.toml")
        robot = controller(speed, cell, faults)
        there = replace(
            cell, controller=replace(cell.controller, port=robot.port, state_port=robot.state_port)
        )
        result = plan_tool_change(there, "right", "wide_cup")
        first = Bench(there, Journal(tmp_path), effects=Idle)
        number = first.do(PlanToolChange("wide_cup"), "ada", Role.ENGINEER).number
        first.do(JobEnded(number, result), "worker")
        first.close()
        bench = Bench(there, Journal(tmp_path, patience=0.1), effects=machines)
        benches.append(bench)
        bench.do(WatchPlan(result.plan.digest), "ada")
        wait_until(lambda: bench.live.joints)
        bench.do(Approve(result.plan.digest), "ada")
        return bench, robot, result.plan

    yield make
    for bench in benches:
        bench.close()


def test_the_cell_has_the_new_tool_once_the_robot_has_it(approved, tmp_path):
    bench, robot, plan = approved()
    bench.do(SendPlan(plan.digest), "ada")
    wait_until(lambda: bench.state.phase is not Phase.SENDING)
    assert bench.state.phase is Phase.IDLE, bench.state.message
    assert robot.tools == {"right": "wide_cup"}
    assert bench.state.cell.arm("right").tool.name == "wide_cup"
    found = bench.state
    bench.close()
    journal = Journal(tmp_path)
    end = list(replay(journal, read_cell_at(bench)))[-1][1]
    assert end.cell.digest == found.cell.digest
    assert not statistics(journal.entries()).picks
    told = [(row.number, row.kind, json.loads(row.body)) for row in journal.entries()]
    assert list(approval_problems(told)) == list(step_problems(told)) == []
    write_bundle(journal, tmp_path / "bundle.zip", time.time())
    with zipfile.ZipFile(tmp_path / "bundle.zip") as archive:
        assert "changes the tool to wide_cup" in archive.read("report.html").decode()


def read_cell_at(bench):
    """The cell that the session began with."""
    arm = bench.state.cell.arm("right")
    arms = (replace(arm, tool=arm.tools[0]),)
    return replace(bench.state.cell, arms=arms)


def test_after_a_stop_on_the_way_nobody_knows_the_tool(approved):
    bench, robot, plan = approved(speed=2.0)
    bench.do(SendPlan(plan.digest), "ada")
    wait_until(lambda: robot.tools == {"right": ""})
    bench.do(Stop(), "ada")
    wait_until(lambda: bench.state.phase is not Phase.SENDING)
    assert bench.state.phase is Phase.FAULT and bench.state.tools_unknown == ("right",)
    assert bench.state.cell.arm("right").tool.name == "suction_cup"

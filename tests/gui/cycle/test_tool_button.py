"""The button that changes a tool, its preview, and the tab Cell after a fault."""

from dataclasses import replace

import pytest
from tool_changing import changed, changer_cell

from workbench.app.core.cell.changes import StateTool
from workbench.app.core.people import Role
from workbench.app.runtime.live import Live
from workbench.formats.cells.reading import read_cell
from workbench.gui.cell.panel import NOT_KNOWN, CellPanel
from workbench.gui.cycle.approval_views import _plan as plan_facts
from workbench.gui.cycle.empty_hand import ToolButton
from workbench.gui.cycle.plan_views import plan_line
from workbench.gui.scene.robot import DrawnRobot
from workbench.gui.shared.look import View
from workbench.gui.shared.playback import moments, timeline
from workbench.model.cell import Cell
from workbench.model.plan import PlanResult
from workbench.proof.claims.spot import spot_of


@pytest.fixture(scope="module")
def cell() -> Cell:
    return changer_cell()


@pytest.fixture(scope="module")
def result(cell: Cell) -> PlanResult:
    return changed(cell)


def shown(visitor, state) -> View:
    return View(state, Live(), visitor.look.now, (), 0.0)


def test_the_button_plans_for_the_tool_in_its_slot(bench, visitor):
    seed = visitor.gui.add_number("Seed", 4)
    button = ToolButton(visitor, seed)
    button.show(shown(visitor, bench.state))
    assert button._button.visible and button._chosen.options == ("wide_cup",)
    command = button.command()
    assert (command.tool, command.arm, command.seed) == ("wide_cup", "right", 4)
    assert not button._button.disabled
    changed = bench.do(StateTool("right", "wide_cup"), "Ada", Role.ENGINEER)
    button.show(shown(visitor, changed))
    assert button._chosen.options == ("suction_cup",)
    unknown = replace(changed, tools_unknown=("right",))
    button.show(shown(visitor, unknown))
    assert button._button.disabled


def test_the_button_is_not_there_in_a_cell_without_slots(visitor, bench):
    button = ToolButton(visitor, visitor.gui.add_number("Seed", 0))
    button.show(shown(visitor, replace(bench.state, cell=read_cell("tx2_90"))))
    assert not button._button.visible and not button._chosen.visible


def test_the_tab_shows_that_a_tool_is_not_known(bench, visitor):
    panel = CellPanel(visitor)
    panel.show(None, shown(visitor, replace(bench.state, tools_unknown=("right",))))
    dropdown = panel._tools["right"]
    assert dropdown.value == NOT_KNOWN
    assert dropdown.options == (NOT_KNOWN, "suction_cup", "wide_cup")
    panel.show(None, shown(visitor, bench.state))
    assert dropdown.options == ("suction_cup", "wide_cup") and dropdown.value == "suction_cup"


def test_the_preview_shows_what_the_arm_carries_on_each_leg(visitor, cell, result):
    runs = timeline(result.plan)
    carried = [moments(cell, runs, (run.start + run.end) / 2)["right"].tool for run in runs]
    assert carried == [None, None, "", "", "", "wide_cup", "wide_cup"]
    robot = DrawnRobot(visitor.client.scene, "/planned", cell)
    for tool, seen in ((None, "suction_cup"), ("", ""), ("wide_cup", "wide_cup")):
        robot.carry({"right": tool})
        nodes = robot._tools["right"]
        assert [name for name, node in nodes.items() if node.visible] == [seen] * bool(seen)


def test_facts_and_line_name_both_tools(bench, cell, result):
    state = replace(bench.state, plan=result.plan, proof=result.proof)
    assert "takes wide_cup" in plan_line(state)
    (_, fact) = plan_facts(cell, result.plan)[-1]
    assert str(fact) == "puts down suction_cup in its slot and takes wide_cup from its own"


def test_where_a_change_is_nearest_can_be_shown(cell, result):
    assert result.proof.nearest is not None
    spot = spot_of(cell, result.plan, result.proof.nearest)
    assert spot is not None and spot.distance == pytest.approx(result.proof.nearest.distance)

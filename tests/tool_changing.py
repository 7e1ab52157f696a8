"""The shipped cell with a tool changer, and a change of its tool."""

from workbench.app.empty_hand.tool_change import plan_tool_change
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.cell import Cell
from workbench.model.plan import Plan, PlanResult


def changer_cell() -> Cell:
    """The cell; its arm carries `suction_cup`, and `wide_cup` stands in its slot."""
    return read_cell(find("robots", "tx2_90") / "tool_changer.toml")


def changed(cell: Cell) -> PlanResult:
    """The change from one tool to the other."""
    return plan_tool_change(cell, "right", "wide_cup")


def change_plan(cell: Cell) -> Plan:
    """The plan of that change."""
    plan = changed(cell).plan
    assert plan is not None
    return plan

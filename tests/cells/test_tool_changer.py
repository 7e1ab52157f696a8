"""The TX2-90 with a tool changer: checked, planned by the command line, and changed over TCP."""

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from patient import running
from waiting import lasting

from workbench.app.core.cycle.approval import approve
from workbench.app.empty_hand.tool_change import plan_tool_change
from workbench.cli.main import main
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.plan_files import read_plan
from workbench.model.cell import Cell
from workbench.model.errors import LinkError
from workbench.model.plan import Plan
from workbench.model.release import Approval
from workbench.model.tools.slots import with_mounted
from workbench.planning.empty_hand.tool_change import slot_problem
from workbench.plugins.found import names
from workbench.plugins.misfit import misfit
from workbench.plugins.robot_link import controller_by, link_named, send

CELL = find("robots", "tx2_90") / "tool_changer.toml"


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell(CELL)


def approved(cell: Cell, tool: str) -> tuple[Plan, Approval]:
    result = plan_tool_change(cell, "right", tool)
    assert result.plan is not None and result.proof is not None and result.proof.holds
    approval = approve(cell, result.plan, result.proof, "ada", time.time())
    return result.plan, lasting(approval)


@contextmanager
def served(cell: Cell) -> Iterator[tuple[SimulatedController, Cell]]:
    """A simulated controller of the cell, and the cell with its address."""
    with running(cell) as controller:
        address = controller_by("abb-socket/2", "127.0.0.1", controller.port, controller.state_port)
        yield controller, replace(cell, controller=address)


def test_nothing_speaks_against_the_cell(capsys) -> None:
    assert main(["cell", "check", str(CELL)]) == 0
    assert "nothing speaks against this cell" in capsys.readouterr().out


def test_a_slot_out_of_reach_or_in_something_is_a_problem(cell: Cell) -> None:
    (arm,) = cell.arms
    for off in ([3.0, 0.0, 0.0], [0.0, 0.05, 0.0]):
        slots = []
        for slot in arm.tool_slots:
            T = slot.T_world_flange.copy()
            T.translation = T.translation + np.array(off)
            slots.append(replace(slot, T_world_flange=T))
        moved = replace(cell, arms=(replace(arm, tool_slots=tuple(slots)),))
        problem = slot_problem(moved, "right", "suction_cup")
        assert problem is not None
    assert slot_problem(cell, "right", "suction_cup") is None


def test_the_command_line_writes_a_proven_change(tmp_path, capsys) -> None:
    out = tmp_path / "change.json"
    command = ["plan", str(CELL), "--tool", "wide_cup", "--out", str(out), "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["proof"]["holds"]
    plan, stated = read_plan(out)
    assert plan.digest == stated and plan.is_tool_plan and not plan.is_view_plan
    assert main(["prove", str(out), "--cell", str(CELL)]) == 0
    assert main([*command[:3], "spoon", *command[4:]]) != 0
    assert "it can carry suction_cup, wide_cup" in capsys.readouterr().err


def test_the_robot_carries_the_new_tool_and_then_the_old_one_again(cell: Cell) -> None:
    with served(cell) as (controller, there):
        for tool in ("wide_cup", "suction_cup"):
            plan, approval = approved(there, tool)
            receipts = list(send(plan, approval, there))
            assert receipts[-1].done == receipts[-1].total
            assert sum(receipt.kind == "leg" for receipt in receipts) == 7
            assert controller.tools == {"right": tool}
            there = with_mounted(there, "right", tool)
        q = np.asarray(controller.state()["joints"]["right"])
    assert np.abs(q - cell.arms[0].home).max() < np.deg2rad(0.01)


def test_a_controller_couples_nothing_away_from_a_slot(cell: Cell) -> None:
    (arm,) = cell.arms
    slots = [
        replace(slot, T_world_flange=slot.T_world_before) if slot.tool == "wide_cup" else slot
        for slot in arm.tool_slots
    ]
    elsewhere = replace(cell, arms=(replace(arm, tool_slots=tuple(slots)),))
    with served(elsewhere) as (controller, there):
        plan, approval = approved(replace(cell, controller=there.controller), "wide_cup")
        with pytest.raises(LinkError, match="no tool to couple where it stands"):
            list(send(plan, approval, replace(cell, controller=there.controller)))
        assert controller.tools == {"right": ""}


def test_no_other_link_couples_tools(cell: Cell) -> None:
    plan, _ = approved(cell, "wide_cup")
    for name in names("workbench.robot_links"):
        there = replace(cell, controller=replace(cell.controller, motion=link_named(name).motion))
        if name != "abb-socket/2":
            assert "couples no tools" in str(misfit(plan, there)), name
    assert misfit(plan, cell) is None

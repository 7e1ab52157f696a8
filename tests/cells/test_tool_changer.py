"""The TX2-90 with a tool changer: checked, planned by the command line, and changed over TCP."""

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from patient import running
from waiting import lasting

from workbench.app.core.cycle.approval import approve
from workbench.app.empty_hand.tool_change import plan_tool_change
from workbench.app.picking.row import prove_row
from workbench.cli.main import main
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.plan_files import read_plan
from workbench.model.cell import Cell, Finger, Tool
from workbench.model.errors import CommandRefused, LinkError
from workbench.model.geometry import Box, Solid
from workbench.model.plan import Plan, Proven
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


def test_the_command_that_sends_a_change_states_what_the_cell_file_needs(tmp_path, capsys) -> None:
    cell, out = read_cell(CELL), tmp_path / "change.json"
    assert main(["plan", str(CELL), "--tool", "wide_cup", "--out", str(out)]) == 0
    digest = read_plan(out)[0].digest
    words = ["--approve-as", "Ada", "--record", str(tmp_path / "record")]
    with served(cell) as (controller, _):
        there = ["--port", str(controller.port), "--state-port", str(controller.state_port)]
        words = ["--cell", str(CELL), "--host", "127.0.0.1", *there, *words]
        capsys.readouterr()
        assert main(["send", str(out), *words]) == 2  # here are no keys to type the digest
        assert main(["send", str(out), *words, "--digest", digest]) == 0
        printed = capsys.readouterr().out
        assert 'before the next plan, state tool = "wide_cup" in the cell file' in printed
        assert controller.tools == {"right": "wide_cup"}


def test_a_change_of_tool_is_no_plan_of_a_row(cell: Cell) -> None:
    """The second drives with another tool than the cell of the proof says."""
    result = plan_tool_change(cell, "right", "wide_cup")
    assert result.plan is not None and result.proof is not None
    again = Proven(result.plan, result.proof)
    with pytest.raises(CommandRefused, match="plan 1 of the row changes a tool"):
        prove_row(cell, (result.plan, result.plan))
    with pytest.raises(CommandRefused, match="plan 1 of the row changes a tool"):
        approve(cell, result.plan, result.proof, "ada", 0.0, row=(again,))
    assert len(prove_row(cell, (result.plan,))) == 1


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


def with_gripper(cell: Cell) -> Cell:
    """The cell whose second tool is a gripper with two fingers."""
    (arm,) = cell.arms
    mount = arm.tools[1].body[0]
    fingers = tuple(
        Finger(
            Solid(
                f"finger_{side:+d}",
                Box(np.array([0.02, 0.01, 0.06])),
                pin.SE3(np.eye(3), np.array([0.0, side * 0.006, 0.06])),
            ),
            np.array([0.0, float(side), 0.0]),
        )
        for side in (1, -1)
    )
    T_tcp = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.09]))
    gripper = Tool("gripper", T_tcp, (mount,), fingers, (0.0, 0.02), mass=0.6)
    slots = (arm.tool_slots[0], replace(arm.tool_slots[1], tool="gripper"))
    tools = (arm.tools[0], gripper)
    return replace(cell, arms=(replace(arm, tools=tools, tool_slots=slots),))


def test_a_gripper_is_taken_opened_and_put_down_again(cell: Cell) -> None:
    with served(with_gripper(cell)) as (controller, there):
        for tool, opening in (("gripper", 0.02), ("suction_cup", 0.0)):
            plan, approval = approved(there, tool)
            list(send(plan, approval, there))
            assert controller.tools == {"right": tool}
            assert controller.state()["openings"]["right"] == pytest.approx(opening)
            there = with_mounted(there, "right", tool)


def test_fingers_that_would_open_into_the_rack_are_not_proven(cell: Cell) -> None:
    gripping = with_gripper(cell)
    (arm,) = gripping.arms
    wide = replace(arm.tools[1], stroke=(0.0, 0.06))
    # Its fingers hang between the bars, which are 30 mm apart.
    low = tuple(
        replace(
            finger,
            solid=replace(
                finger.solid,
                T_owner_shape=pin.SE3(pin.rpy.rpyToMatrix(0, 0, np.pi / 2), np.zeros(3))
                * finger.solid.T_owner_shape,
            ),
            direction=np.array([-finger.direction[1], 0.0, 0.0]),
        )
        for finger in wide.fingers
    )
    wide = replace(wide, fingers=low)
    other = replace(gripping, arms=(replace(arm, tools=(arm.tools[0], wide)),))
    result = plan_tool_change(other, "right", "gripper")
    said = str(result.verdict)
    if result.proof is not None:
        said += " ".join(map(str, result.proof.violations))
    assert "finger_" in said and (result.proof is None or not result.proof.holds), said

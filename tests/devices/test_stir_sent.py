"""A plan that stirs goes out over simulated controllers: closed hand, no part reported."""

import time
from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import six_axes_cell
from patient import running
from pick_scenes import Program, Sent, elsewhere
from twins import own_host, twin_of
from waiting import lasting

from workbench.app.core.cycle.approval import approve
from workbench.app.empty_hand.stirring import plan_stir
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.plan import Plan
from workbench.model.release import Approval
from workbench.model.scan import Scene
from workbench.perception.simulation.piles import pile_of
from workbench.plugins.robot_link import controller_by, send


def approved(cell: Cell) -> tuple[Plan, Approval]:
    pile = pile_of(cell, "", 3, seed=5)
    result = plan_stir(cell, Scene(digest_of(pile), pile))
    assert result.plan is not None and result.proof is not None and result.proof.holds
    return result.plan, approve(cell, result.plan, result.proof, "ada", time.time())


def test_an_abb_controller_closes_the_hand_stirs_and_goes_home() -> None:
    cell = read_cell("yumi")
    plan, _ = approved(cell)
    name = plan.arms[0].arm
    with running(cell) as controller:
        address = controller_by("abb-socket/2", "127.0.0.1", controller.port, controller.state_port)
        there = replace(cell, controller=address)
        plan, approval = approved(there)
        receipts = list(send(plan, approval, there))
        state = controller.state()
    assert receipts[-1].done == receipts[-1].total
    assert state["placed"] == 0 and not any(receipt.part for receipt in receipts)
    assert sum(receipt.kind == "leg" for receipt in receipts) == 3
    assert state["openings"][name] == pytest.approx(0.0, abs=1e-4)
    assert np.abs(np.asarray(state["joints"][name]) - cell.arm(name).home).max() < np.deg2rad(0.01)


def test_a_controller_of_universal_robots_follows_it() -> None:
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    cell = six_axes_cell("ur-rtde-servo")
    (arm,) = cell.arms
    plan, approval = approved(cell)
    start = arm.to_axes(plan.arms[0].legs[0].q[0]).tolist()
    with twin_of(cell, own_host(), start=start) as (twin, there):
        receipts = list(send(plan, lasting(approval), there))
        q = arm.from_axes(np.asarray(twin.q))
    assert receipts[-1].done == receipts[-1].total
    assert np.abs(q - arm.home).max() < np.deg2rad(0.1)


def test_a_robot_program_gets_its_three_legs() -> None:
    cell = elsewhere(six_axes_cell("pick-server"), ask_s=60.0)
    plan, approval = approved(cell)
    sent_plan = Sent(cell, plan, lasting(approval))
    robot = Program(cell, cell.controller.port)
    robot.q = np.asarray(plan.arms[0].legs[0].q[0])
    robot.cycle()
    legs = [answer[1:3] for job, _, answer in robot.got if job == "leg"]
    assert legs == [("reach", "open"), ("stir", "keep"), ("home", "keep")]
    receipts, error = sent_plan.ended()
    robot.close()
    assert error is None and not any(receipt.part for receipt in receipts)

"""The path to the view goes out over every simulated controller, which then stands there."""

import time
from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import on_arm_cell, parked, six_axes_cell
from patient import running
from pick_scenes import Program, Sent, elsewhere
from twins import own_host, twin_of
from waiting import lasting

from workbench.app.core.cycle.approval import approve
from workbench.app.empty_hand.view_plan import plan_view
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.model.cell import Cell
from workbench.model.errors import LinkError, WorkbenchError
from workbench.model.plan import Plan
from workbench.model.release import Approval, Receipt
from workbench.plugins.robot_link import controller_by, send


@pytest.fixture(scope="module")
def cell() -> Cell:
    return on_arm_cell()


def approved(cell: Cell, view: str = "") -> tuple[Plan, Approval]:
    result = plan_view(cell, view=view)
    assert result.plan is not None and result.proof is not None
    return result.plan, approve(cell, result.plan, result.proof, "ada", time.time())


def test_an_abb_controller_goes_back_home_from_the_view(cell: Cell) -> None:
    carrier = cell.scanner.on_arm
    assert carrier is not None
    with running(cell) as controller:
        address = controller_by("abb-socket/2", "127.0.0.1", controller.port, controller.state_port)
        there = replace(cell, controller=address)
        plan, approval = approved(there, "home")
        receipts = list(send(plan, approval, there))
        state = controller.state()
    assert receipts[-1].done == receipts[-1].total
    assert np.abs(np.asarray(state["joints"]["left"]) - carrier.home).max() < np.deg2rad(0.01)


def sent(cell: Cell, controller: SimulatedController, protocol: str) -> list[Receipt]:
    address = controller_by(protocol, "127.0.0.1", controller.port, controller.state_port)
    there = replace(cell, controller=address)
    plan, approval = approved(there)
    return list(send(plan, approval, there))


@pytest.mark.parametrize("protocol", ["abb-socket", "abb-socket/2"])
def test_an_abb_controller_stands_at_the_view_and_has_placed_nothing(
    cell: Cell, protocol: str
) -> None:
    carrier = cell.scanner.on_arm
    assert carrier is not None
    with running(parked(cell)) as controller:
        receipts = sent(cell, controller, protocol)
        state = controller.state()
    assert receipts[-1].done == receipts[-1].total
    assert state["placed"] == 0 and not any(receipt.part for receipt in receipts)
    assert np.abs(np.asarray(state["joints"]["left"]) - carrier.view.q).max() < np.deg2rad(0.01)
    assert {receipt.arm for receipt in receipts if receipt.kind in ("leg", "out")} == {"left"}


def test_an_arm_that_stands_elsewhere_does_not_move(cell: Cell) -> None:
    with running(cell) as controller:
        with pytest.raises(LinkError, match=r"arm left is 99\.0 degrees from its start"):
            sent(cell, controller, "abb-socket/2")
        left = np.asarray(controller.state()["joints"]["left"])
    assert np.abs(left - cell.arm("left").home).max() < 1e-6


def test_it_goes_out_once(cell: Cell) -> None:
    with running(parked(cell)) as controller:
        address = controller_by("abb-socket/2", "127.0.0.1", controller.port, controller.state_port)
        there = replace(cell, controller=address)
        plan, approval = approved(there)
        list(send(plan, approval, there))
        with pytest.raises(WorkbenchError):
            list(send(plan, approval, there))


@pytest.mark.parametrize("link", ["ur-rtde", "ur-rtde-blend", "ur-rtde-servo"])
def test_a_controller_of_universal_robots_stands_at_the_view(link: str) -> None:
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    cell = six_axes_cell(link)
    (arm,), carrier = cell.arms, cell.scanner.on_arm
    assert carrier is not None
    plan, approval = approved(cell)
    start = arm.to_axes(plan.arms[0].legs[0].q[0]).tolist()
    with twin_of(cell, own_host(), start=start) as (twin, there):
        receipts = list(send(plan, lasting(approval), there))
        q = arm.from_axes(np.asarray(twin.q))
    assert receipts[-1].done == receipts[-1].total
    assert not any(receipt.part for receipt in receipts)
    assert np.abs(q - carrier.view.q).max() < np.deg2rad(0.1)


def test_a_robot_program_gets_one_leg_and_reports_no_part() -> None:
    cell = elsewhere(six_axes_cell("pick-server"), ask_s=60.0)
    carrier = cell.scanner.on_arm
    assert carrier is not None
    plan, approval = approved(cell)
    sent_plan = Sent(cell, plan, lasting(approval))
    robot = Program(cell, cell.controller.port)
    robot.q = np.asarray(plan.arms[0].legs[0].q[0])
    assert robot.begin() == 1
    leg = robot.leg(1)
    assert leg[:3] == ("LEG", "view", "open")
    assert robot.ask("done", "1", *robot.joints()) == ("OK", "end")
    receipts, error = sent_plan.ended()
    robot.close()
    assert error is None and not any(receipt.part for receipt in receipts)
    assert np.abs(robot.q - carrier.view.q).max() < np.deg2rad(0.02)

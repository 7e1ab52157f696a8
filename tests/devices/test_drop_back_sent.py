"""After a stop with a part in the hand a plan goes out that drops it back from there."""

import time
from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import six_axes_cell
from dropping import OVER_BIN
from patient import PATIENT, in_threads, send
from pick_scenes import Program, Sent, elsewhere
from waiting import lasting

from workbench.app.core.cycle.approval import approve
from workbench.app.empty_hand.drop_back import plan_drop_back
from workbench.app.picking.pipeline import plan_pick
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, LinkError
from workbench.model.geometry import Floats
from workbench.model.plan import Plan
from workbench.model.release import Approval
from workbench.model.tools.held_body import HeldAmount
from workbench.perception.simulation.piles import pile_of
from workbench.plugins.robot_link import Simulation, controller_by


def approved(cell: Cell, arm: str, q: Floats, held: HeldAmount) -> tuple[Plan, Approval]:
    result = plan_drop_back(cell, arm, q, held)
    assert result.plan is not None and result.proof is not None and result.proof.holds
    return result.plan, approve(cell, result.plan, result.proof, "ada", time.time())


def test_an_abb_controller_that_stopped_with_a_part_drops_it_back() -> None:
    cell = read_cell("yumi")
    pile = pile_of(cell, "", 5, seed=1)
    simulation = Simulation(speed=1000.0, faults=["emergency-stop:4"])
    with in_threads() as started:
        controller = started(SimulatedController(cell, simulation, patience=PATIENT))
        address = controller_by("abb-socket/2", "127.0.0.1", controller.port, controller.state_port)
        there = replace(cell, controller=address)
        picked = plan_pick(there, pile, digest_of(pile), strategy="right")
        assert picked.plan is not None and picked.proof is not None
        approval = approve(there, picked.plan, picked.proof, "ada", time.time())
        with pytest.raises(LinkError, match="emergency stop"):
            list(send(picked.plan, approval, there))
        stands = np.array(controller.state()["joints"]["right"])
        held_open = controller.state()["openings"]["right"]
        assert np.abs(stands - cell.arm("right").home).max() > np.deg2rad(5.0)
        plan, released = approved(there, "right", stands, HeldAmount.ONE)
        receipts = list(send(plan, released, there))
        state = controller.state()
    assert receipts[-1].done == receipts[-1].total
    hands = [receipt.sent.split()[7] for receipt in receipts if receipt.kind == "leg"]
    assert hands == ["keep", "keep", "open"]
    assert not any(receipt.part for receipt in receipts)
    assert held_open < state["openings"]["right"] == pytest.approx(0.05, abs=1e-4)
    home = cell.arm("right").home
    assert np.abs(np.asarray(state["joints"]["right"]) - home).max() < np.deg2rad(0.01)


def test_a_robot_program_keeps_its_hand_closed_until_the_part_is_there() -> None:
    cell = elsewhere(six_axes_cell("pick-server"), ask_s=60.0)
    (arm,) = cell.arms
    plan, approval = approved(cell, arm.name, arm.home, HeldAmount.ONE)
    sent_plan = Sent(cell, plan, lasting(approval))
    robot = Program(cell, cell.controller.port)
    robot.q = np.asarray(plan.arms[0].legs[0].q[0])
    robot.cycle()
    legs = [answer[1:3] for job, _, answer in robot.got if job == "leg"]
    assert legs[-2:] == [("carry", "keep"), ("home", "open")]
    receipts, error = sent_plan.ended()
    robot.close()
    assert error is None and not any(receipt.part for receipt in receipts)


def test_a_link_that_opens_the_hand_first_gets_no_such_plan() -> None:
    cell = read_cell("yumi")
    plan, approval = approved(cell, "right", OVER_BIN, HeldAmount.ONE)
    other = replace(cell, controller=controller_by("abb-egm"))
    with pytest.raises(CommandRefused, match="cannot begin a plan with a part in the hand"):
        list(send(plan, approval, other))

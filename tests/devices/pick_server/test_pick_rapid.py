"""The RAPID client, executed: it asks the pick server, and moves as the plan was proven."""

from pathlib import Path

import numpy as np
import pytest
from patient import in_threads
from pick_scenes import Sent, another, elsewhere, spoiled
from waiting import wait_until

from workbench.devices.rapid.controller import RapidController
from workbench.formats.rapid.loading import read_source
from workbench.formats.rapid.setup import Setup, TaskSetup

MODULE = Path(__file__).parents[3] / "robots" / "pick_server" / "rapid" / "WbPick.mod"

GRIPS = "FUNC bool pick_grip(num opening)\n        RETURN TRUE;"

SPEED = 50.0


@pytest.fixture
def start(planned):
    """Starts a controller that runs the module, which asks at a port."""

    def made(port: int, grips: str = "TRUE") -> RapidController:
        text = MODULE.read_text(encoding="ascii")
        for old, new in (
            ("192.168.0.20", "127.0.0.1"),
            ("PICK_PORT:=1025", f"PICK_PORT:={port}"),
            (GRIPS, GRIPS.replace("TRUE", grips)),
        ):
            assert text.count(old) == 1
            text = text.replace(old, new)
        cell = planned[0]
        task = TaskSetup([read_source("WbPick", text)], cell.arms[0].name)
        return started(RapidController(cell, Setup({"T_ROB1": task}, {}), speed=SPEED))

    with in_threads() as started:
        yield made


def joints(controller: RapidController) -> np.ndarray:
    return controller.axes()["T_ROB1"]


def test_it_moves_along_the_plan_and_reports_the_pick(planned, start):
    cell, plan, approval = planned
    there = elsewhere(cell)
    sent = Sent(there, plan, approval)
    start(there.controller.port)
    receipts, error = sent.ended()
    assert error is None
    assert [receipt.part.is_picked for receipt in receipts if receipt.part] == [True]
    points = sum(len(leg.q) - 1 for arm in plan.arms for leg in arm.legs)
    assert sum(receipt.sent.startswith("TO") for receipt in receipts) == points
    # Each leg was reported from where its last waypoint is, by the robot itself.
    assert sum(receipt.heard.startswith("done") for receipt in receipts) == sum(
        len(arm.legs) for arm in plan.arms
    )


def test_a_hand_that_stays_empty_is_reported(planned, start):
    cell, plan, approval = planned
    there = elsewhere(cell)
    sent = Sent(there, plan, approval)
    start(there.controller.port, grips="FALSE")
    receipts, error = sent.ended()
    assert error is None
    assert [receipt.part.is_picked for receipt in receipts if receipt.part] == [False]


def test_over_a_network_that_spoils_bytes_nothing_is_lost_or_comes_twice(planned, start):
    cell, plan, approval = planned
    there = elsewhere(cell, ask_s=60.0)
    with spoiled(there.controller.port, 11, often=3e-4) as (port, _):
        start(port)
        for number in range(3):
            receipts, error = Sent(there, plan, another(approval, number)).ended()
            assert error is None
            heard = [receipt.heard for receipt in receipts]
            assert len(heard) == len(set(heard)), "nothing twice"
            assert [receipt.part.is_picked for receipt in receipts if receipt.part] == [True]


def test_after_stop_it_moves_no_further(planned, start):
    cell, plan, approval = planned
    there = elsewhere(cell)
    is_pressed = []
    sent = Sent(there, plan, approval, cancelled=lambda: bool(is_pressed))
    controller = start(there.controller.port)
    home = joints(controller)
    wait_until(lambda: np.abs(joints(controller) - home).max() > 1.0, "the first motion")
    is_pressed.append(True)
    wait_until(lambda: any("pick server" in line for line in controller.written), "the stop")
    stands = joints(controller)
    wait_until(lambda: not controller.tasks["T_ROB1"].is_alive, "the end of the program")
    assert np.array_equal(joints(controller), stands)
    assert "acknowledged the stop" in str(sent.ended()[1])

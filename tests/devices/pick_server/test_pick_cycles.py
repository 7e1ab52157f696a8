"""A thousand cycles over a network that spoils bytes, by two robot programs."""

import importlib.util
import threading
from pathlib import Path

import pytest
from pick_scenes import Program, Sent, another, elsewhere, spoiled
from waiting import PATIENCE

CLIENT = Path(__file__).parents[3] / "robots" / "pick_server" / "pick_client.py"

CYCLES = 1000


def reference():
    """The module of the reference client."""
    spec = importlib.util.spec_from_file_location("pick_client", CLIENT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.AGAIN = 0.2
    return module


def checked(receipts, error, plan):
    """One cycle: everything once, and its end on record."""
    assert error is None
    heard = [receipt.heard for receipt in receipts]
    assert len(heard) == len(set(heard)), "nothing twice"
    points = sum(len(leg.q) - 1 for arm in plan.arms for leg in arm.legs)
    assert sum(receipt.sent.startswith("TO") for receipt in receipts) == points, "nothing lost"
    assert receipts[-1].done == receipts[-1].total
    assert [receipt.part.is_picked for receipt in receipts if receipt.part] == [True]


@pytest.mark.timeout(7200)
def test_a_thousand_cycles_lose_nothing_and_bring_nothing_twice(planned):
    cell, plan, approval = planned
    there, tickets = elsewhere(cell, ask_s=60.0), set()
    with spoiled(there.controller.port, 7, often=2e-4) as (port, counts):
        robot = Program(there, port)
        for number in range(CYCLES):
            sent = Sent(there, plan, another(approval, number))
            robot.cycle()
            checked(*sent.ended(), plan)
            tickets.add(robot.plans[-1])
            robot.got.clear()
        robot.close()
    assert len(tickets) == CYCLES and min(counts.values()) > 50, counts


@pytest.mark.timeout(1800)
def test_the_reference_client_does_as_well(planned):
    cell, plan, approval = planned
    there = elsewhere(cell, ask_s=60.0)
    with spoiled(there.controller.port, 8, often=2e-4) as (port, _):
        home = Program(there, port).joints()
        client = threading.Thread(
            target=reference().main,
            args=("127.0.0.1", port, *home),
            kwargs={"cycles": CYCLES},
            daemon=True,
        )
        client.start()
        for number in range(CYCLES):
            checked(*Sent(there, plan, another(approval, 5000 + number)).ended(), plan)
        client.join(PATIENCE)
        assert not client.is_alive()

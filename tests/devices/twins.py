"""A controller of Universal Robots, simulated, for as long as a test needs it."""

import os
import random
import threading
import time
from contextlib import contextmanager
from dataclasses import replace

from waiting import PATIENCE, lasting

import workbench
from workbench.devices.universal_robots.flange import Flange
from workbench.devices.universal_robots.rtde import RTDE_PORT
from workbench.devices.universal_robots.twin import SimulatedUr
from workbench.plugins.robot_link import LinkPatience, Simulation, controller_by

PATIENT = LinkPatience(PATIENCE, PATIENCE, PATIENCE, PATIENCE, 1.0)


def own_host() -> str:
    """An address of this machine that no other test has: the client chooses no ports."""
    one = random.Random(f"{os.getpid()} {time.time_ns()}")
    return f"127.{one.randint(64, 250)}.{one.randint(1, 250)}.{one.randint(1, 250)}"


def planned_for(link: str):
    """A cell with six axes spoken to by that link, a plan that ends where it begins, its proof."""
    cell = workbench.read_cell("tx2_90")
    cell = replace(cell, controller=controller_by(link, "127.0.0.1", 30002, RTDE_PORT))
    parts = workbench.drop_parts(cell.parts[:1], cell.bin, seed=5)
    result = workbench.plan(cell, parts)
    assert result.plan is not None, result.verdict
    return cell, result.plan, result.proof


def approved_for(link: str):
    """That cell and plan, and the plan's approval."""
    cell, plan, proof = planned_for(link)
    return cell, plan, lasting(workbench.approve(cell, plan, proof, "tester"))


def legs_of(plan):
    """Its legs as they follow each other."""
    return [plan.arm(name).leg(leg) for step in plan.sequence for name, leg in step.runs]


@contextmanager
def twin_of(cell, host, **options):
    """The twin at that address, and the cell with its controller there."""
    arm = cell.arms[0]
    start = options.pop("start", arm.to_axes(arm.home).tolist())
    positions = Flange(cell, arm).at
    simulation = Simulation(host, **({"speed": 50.0} | options))
    twin = SimulatedUr(simulation, start, positions=positions)
    thread = threading.Thread(target=twin.run)
    thread.start()
    at = replace(cell.controller, host=host, port=twin.port)
    try:
        yield twin, replace(cell, controller=at)
    finally:
        twin.stop()
        thread.join(PATIENCE)
        assert not thread.is_alive()

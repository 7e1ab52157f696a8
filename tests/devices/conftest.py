"""A plan, its approval, and simulated controllers on free ports."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from patient import PATIENT, in_threads

from workbench.app.picking.pipeline import plan_pick
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.plan import Plan
from workbench.model.release import Approval
from workbench.model.scan import Detection
from workbench.plugins.robot_link import Simulation, controller_by


@pytest.fixture(scope="session")
def cell() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="session")
def plan(cell: Cell) -> Plan:
    """For two arms of which one moves at a time, so that every protocol can say it."""
    floor = cell.bin.T_world_bin.translation
    detections = tuple(
        Detection("keyed_cylinder", pose_from_rpy(floor + [0.0, y, 0.019], (np.pi / 2, 0.0, yaw)))
        for y, yaw in ((-0.07, 0.4), (0.07, -0.6))
    )
    motion = replace(cell.controller.motion, arms_at_once=1)
    in_turn = replace(cell, controller=replace(cell.controller, motion=motion))
    made = plan_pick(in_turn, detections, "scan", seed=0).plan
    assert made is not None
    return made


@pytest.fixture(scope="session")
def waypoints(plan: Plan) -> list[tuple[str, Floats]]:
    """Arm and configuration of every waypoint that is sent, in order."""
    return [
        (name, q)
        for step in plan.sequence
        for name, leg in step.runs
        for q in plan.arm(name).leg(leg).q[1:]
    ]


@pytest.fixture
def approval(cell: Cell, plan: Plan) -> Approval:
    now = time.time()
    return Approval(plan.digest, "proof", cell.digest, plan.scan_digest, "tester", now, now + 3600)


@pytest.fixture
def controller(cell: Cell, tmp_path: Path) -> Iterator[Callable[..., SimulatedController]]:
    """Starts controllers that end with the test; they record to `arrived.jsonl`."""
    usual = {"record": tmp_path / "arrived.jsonl", "speed": 1000.0}
    with in_threads() as started:

        def start(paces=None, patience=PATIENT, **options):
            simulation = Simulation(**(usual | options))
            return started(SimulatedController(cell, simulation, paces=paces, patience=patience))

        yield start


@pytest.fixture
def at(cell: Cell) -> Callable[..., Cell]:
    """The cell with its controller at another address."""

    def moved(port: int, state_port: int = 1, protocol: str = "abb-socket") -> Cell:
        return replace(cell, controller=controller_by(protocol, "127.0.0.1", port, state_port))

    return moved

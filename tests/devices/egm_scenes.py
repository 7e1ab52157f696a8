"""What the tests of EGM share: a cell with two arms of seven axes, its plan, and the twin."""

import threading
from contextlib import contextmanager
from dataclasses import replace

from waiting import PATIENCE, lasting

import workbench
from workbench.devices.abb_egm.twin import SimulatedEgm
from workbench.plugins.robot_link import LinkPatience, Simulation, controller_by

PATIENT = LinkPatience(PATIENCE, PATIENCE, PATIENCE, PATIENCE, 1.0)


def plan_of_two(jerk=None):
    """YuMi by this link, a plan in which both arms take a part, and its approval.

    `jerk` [1/s] times their acceleration limits the arms' jerk, if it is given.
    """
    cell = workbench.read_cell("yumi")
    arms = tuple(replace(arm, tool=replace(arm.tool, mass=0.23)) for arm in cell.arms)
    cell = replace(cell, arms=arms)
    if jerk is not None:
        arms = tuple(replace(arm, jerk=jerk * arm.acceleration) for arm in cell.arms)
        cell = replace(cell, arms=arms)
    options = {"silence_ms": 1000}
    cell = replace(cell, controller=controller_by("abb-egm", "127.0.0.1", 6510, 6520, options))
    parts = workbench.drop_parts(cell.parts[:1] * 2, cell.bin, seed=1)
    result = workbench.plan(cell, parts, strategy="alternated")
    assert result.plan is not None, result.verdict
    return cell, result.plan, lasting(workbench.approve(cell, result.plan, result.proof, "tester"))


@contextmanager
def twin_of(cell, silence_ms=1000, speed=100.0, **given):
    """The twin, and the cell with its controller there."""
    twin = SimulatedEgm(cell, Simulation(speed=speed, **given))
    thread = threading.Thread(target=twin.run)
    thread.start()
    at = replace(
        cell.controller,
        port=twin.port,
        state_port=twin.state_port,
        options={"silence_ms": silence_ms},
    )
    try:
        yield twin, replace(cell, controller=at)
    finally:
        twin.stop()
        thread.join(PATIENCE)
        assert not thread.is_alive()

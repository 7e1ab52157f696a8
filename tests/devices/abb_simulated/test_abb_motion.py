"""The robot of the simulated controller keeps the time of the program, however it is asked."""

import pytest

from workbench.devices.abb_simulated.body import SimulatedBody
from workbench.devices.abb_simulated.faults import Faults
from workbench.devices.abb_simulated.motion import HAND_SECONDS, MOMENT, Motion
from workbench.devices.abb_socket.program import program_of


@pytest.mark.parametrize("tick", [0.0003, 0.0207, 0.5])
def test_a_program_takes_as_long_as_its_legs(cell, plan, approval, tick):
    program = program_of(cell, plan, approval)
    expected = sum(
        max(float(leg.seconds.sum()) for leg in step.legs)
        + (HAND_SECONDS if any(leg.hand != "keep" for leg in step.legs) else 0.0)
        for step in program.steps
    )
    motion = Motion(program, SimulatedBody(cell, 1.0, None, None, Faults()), {})
    took = 0.0
    while not any(event.startswith("done") for event in motion.advance(tick)):
        took += tick
        assert took < 2 * expected
    assert took == pytest.approx(expected, abs=tick + 2 * MOMENT * len(program.steps))

"""Loads by abb-socket/2: what is said, and what the simulated controller makes of it."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.devices.abb_loads import load_data
from workbench.devices.abb_simulated.body import SimulatedBody
from workbench.devices.abb_simulated.faults import Faults
from workbench.devices.abb_simulated.loading import Loading
from workbench.devices.abb_socket.frames import MessageFrame
from workbench.devices.abb_socket.program import lines_of, program_of
from workbench.model.errors import InputError
from workbench.model.load import Load, Loads


def turned_load(mass=0.134):
    R = pin.exp3(np.array([0.3, -0.2, 0.5]))
    inertia = R @ np.diag([4e-5, 3e-5, 6e-5]) @ R.T
    return Load(mass, np.array([0.0, -0.0015, 0.141]), (inertia + inertia.T) / 2)


def with_loads(plan, load=None):
    loads = Loads(turned_load(0.23), turned_load() if load is None else load)
    return replace(plan, arms=tuple(replace(one, loads=loads) for one in plan.arms))


def test_principal_axes_and_moments_give_the_inertia_back():
    load = turned_load()
    data = load_data(load)
    R = pin.Quaternion(*data.aom).normalized().matrix()
    assert R @ np.diag(data.moments) @ R.T == pytest.approx(load.inertia, abs=2e-5)
    assert (data.mass, data.cog) == (0.134, (0.0, -1.5, 141.0))


def test_a_load_in_the_middle_of_the_flange_and_next_to_nothing_are_what_controllers_take():
    data = load_data(Load(1e-5, np.zeros(3), np.zeros((3, 3))))
    assert (data.mass, data.cog) == (0.001, (0.0, 0.0, 0.1))
    assert (data.aom, data.moments) == ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_loads_are_said_after_the_starts_and_fit_a_frame(cell, plan, approval):
    said = lines_of(cell, program_of(cell, with_loads(plan), approval))
    words = [line.word for line in said]
    first = words.index("load")
    assert words[first - 1] == "start"
    assert words[first : first + 8] == ["load", "axes"] * 4
    assert words[first + 8] == "leg"
    plain = replace(plan, arms=tuple(replace(one, loads=None) for one in plan.arms))
    assert "load" not in {line.word for line in lines_of(cell, program_of(cell, plain, approval))}
    for line in said:
        assert len(f"0001 {line.word} {line.rest}") <= 75


def test_the_simulated_controller_reckons_with_what_was_said(cell, plan, approval):
    program = program_of(cell, with_loads(plan), approval)
    loading, loaded = Loading(cell), None
    for line in lines_of(cell, program):
        loaded = loading.take(MessageFrame(1, line.word, line.rest, ""))
    assert loaded is None
    body = SimulatedBody(cell, 1.0, None, None, Faults())
    body.reckon(program.loads)
    name = plan.arms[0].arm
    assert [one.mass for one in body.carried[name]] == [0.23]
    body.grip(name, 0.03)
    assert [one.mass for one in body.carried[name]] == [0.23, 0.134]
    body.open(name, 0.05)
    assert [one.mass for one in body.carried[name]] == [0.23]


@pytest.mark.parametrize(
    "load",
    [
        Load(1500.0, np.zeros(3), np.zeros((3, 3))),
        Load(1.0, np.array([0.0, 0.0, 1.5]), np.zeros((3, 3))),
        Load(900.0, np.zeros(3), np.eye(3) * 200),
    ],
)
def test_a_load_beyond_the_frame_is_not_sent(cell, plan, approval, load):
    program = program_of(cell, with_loads(plan, load), approval)
    with pytest.raises(InputError, match="more than can be said"):
        lines_of(cell, program)

"""Positions of axes that a controller couples, as OPC UA shows them."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.core.state import State
from workbench.app.runtime.live import Live
from workbench.extras.opcua.robotics.readings import NOT_NOW, readings
from workbench.model.robot import AxisMapping


def positions(cell, joints):
    found = readings(State(cell), Live(joints=joints))
    arm = cell.arms[0]
    own = ("MotionDevices", arm.name, "Axes")
    numbers = range(1, len(arm.joints) + 1)
    return [found[*own, f"Axis{k}", "ParameterSet", "ActualPosition"] for k in numbers]


@pytest.fixture
def coupled(results):
    """The cell, whose first arm's controller counts the third axis with the second one."""
    coupling = np.eye(7)
    coupling[2, 1] = -1.0
    cell = results.cell
    arm = replace(cell.arms[0], mapping=AxisMapping(coupling, np.zeros(7)))
    return replace(cell, arms=(arm, *cell.arms[1:]))


def test_they_are_those_that_the_controller_shows(results, coupled):
    joints = dict(zip(coupled.arms[0].joints, coupled.arms[0].home, strict=True))
    plain = [one.value for one in positions(results.cell, joints)]
    shown = [one.value for one in positions(coupled, joints)]
    assert shown[2] == pytest.approx(plain[2] - plain[1])
    assert shown[:2] + shown[3:] == pytest.approx(plain[:2] + plain[3:])


def test_a_joint_that_is_not_reported_leaves_unknown_what_counts_it(results, coupled):
    arm = coupled.arms[0]
    joints = dict(zip(arm.joints, arm.home, strict=True))
    del joints[arm.joints[arm.axis_order[1]]]
    alone = [one.status == NOT_NOW for one in positions(results.cell, joints)]
    assert alone == [False, True, False, False, False, False, False]
    assert all(one.status == NOT_NOW for one in positions(coupled, joints))

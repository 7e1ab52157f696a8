"""Axes as a controller shows them: there and back, and how far they go."""

from dataclasses import replace

import numpy as np
import pytest
from shipped import shipped

from workbench.model.derived.controller_axes import (
    from_shown,
    shown_axes,
    shown_limits,
    shown_units,
    units_said,
)
from workbench.model.robot import AxisMapping

CELL = shipped("tx2_90")
FANUC = np.eye(6)
FANUC[2, 1] = -1.0


def counted(coupling, offsets_deg=(0,) * 6):
    """The arm of the cell, whose controller counts so."""
    mapping = AxisMapping(np.array(coupling), np.deg2rad(offsets_deg))
    return replace(CELL.arms[0], mapping=mapping)


@pytest.mark.parametrize(
    "arm",
    [
        CELL.arms[0],
        counted(FANUC),
        counted(np.diag([-1, 1, 1, -1, 1, -1]), (0, -90, 90, 0, 0, 10)),
        replace(counted(FANUC), axis_order=(1, 0, 2, 3, 5, 4), axis_signs=(1, -1, 1, 1, -1, 1)),
    ],
)
def test_what_is_shown_is_read_back_and_within_the_limits(arm):
    lower, upper, _ = CELL.robot.limits(arm.joints)
    low, high = shown_limits(CELL, arm)
    rng = np.random.default_rng(1)
    corners = np.array([rng.choice(pair, 64) for pair in zip(lower, upper, strict=True)]).T
    for q in (*rng.uniform(lower, upper, (64, 6)), *corners):
        shown = shown_axes(CELL, arm, q)
        np.testing.assert_allclose(from_shown(CELL, arm, shown), q, atol=1e-12)
        assert np.all(shown >= low - 1e-9) and np.all(shown <= high + 1e-9)
    reached = np.array([shown_axes(CELL, arm, q) for q in corners])
    np.testing.assert_allclose(reached.min(axis=0), low)
    np.testing.assert_allclose(reached.max(axis=0), high)


def test_fanuc_counts_the_third_axis_from_the_horizontal():
    q = np.deg2rad([10.0, 20.0, 30.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(shown_axes(CELL, counted(FANUC), q)[:3], [10.0, 20.0, 10.0])


def test_a_sliding_axis_is_shown_in_mm():
    joint = CELL.arms[0].joints[0]
    joints = tuple(
        replace(one, kind="prismatic") if one.name == joint else one for one in CELL.robot.joints
    )
    cell = replace(CELL, robot=replace(CELL.robot, joints=joints))
    arm = cell.arms[0]
    assert shown_units(cell, arm)[:2] == ("mm", "deg") and units_said(cell, arm) == "mm, deg"
    assert shown_axes(cell, arm, np.full(6, 0.25))[0] == pytest.approx(250.0)
    assert units_said(CELL, CELL.arms[0]) == "deg"

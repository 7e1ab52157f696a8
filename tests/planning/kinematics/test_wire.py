"""What can be sent of a configuration, also at the limits of the joints."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.app.picking.pipeline import plan_pick
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.kinematics.wire import WIRE_STEP, limits_on_wire, on_wire

ANGLES = st.floats(-7.0, 7.0)


@given(st.lists(st.floats(-6.0, 6.0), min_size=7, max_size=7))
def test_the_wire_carries_two_decimals_of_a_degree(values):
    q = on_wire(np.array(values))
    assert np.abs(q - values).max() <= WIRE_STEP / 2 + 1e-12
    assert [f"{value:.2f}" for value in np.rad2deg(q)] == [
        f"{value:.2f}" for value in np.rad2deg(on_wire(q))
    ]


@given(lower=ANGLES, range_=st.floats(0.001, 7.0), share=st.floats(0.0, 1.0))
def test_rounding_never_leaves_the_limits(lower, range_, share):
    given_limits = np.array([lower]), np.array([lower + range_])
    low, high = limits_on_wire(*given_limits)
    assert given_limits[0] - 1e-9 <= low <= high <= given_limits[1] + 1e-9
    assert low <= on_wire(low + share * (high - low)) <= high


def test_limits_in_whole_steps_stay():
    limits = np.deg2rad(np.array([-143.5, -168.5])), np.deg2rad(np.array([43.5, 168.5]))
    assert np.allclose(limits_on_wire(*limits), limits, atol=1e-12, rtol=0)


def test_a_joint_without_room_for_two_steps_keeps_its_limits():
    """Planners need a range to draw from."""
    for limits in ((0.123001, 0.123002), (-0.00001, 0.00001)):
        assert limits_on_wire(*map(np.atleast_1d, limits)) == limits


@pytest.fixture(scope="module")
def uneven(cell):
    """The cell with joint limits that lie between two steps of the wire."""
    joints = tuple(
        replace(joint, lower=joint.lower + 3e-5, upper=joint.upper - 3e-5)
        if joint.kind != "fixed"
        else joint
        for joint in cell.robot.joints
    )
    return replace(cell, robot=replace(cell.robot, joints=joints))


@pytest.mark.parametrize(("seed", "arm"), [(1, "right"), (24, "left"), (28, "left")])
def test_a_plan_up_to_a_limit_between_two_steps_is_proven(uneven, seed, arm):
    pile = drop_parts(uneven.parts[:1] * 4, uneven.bin, seed=seed)
    result = plan_pick(uneven, pile, "s", strategy=arm, seed=seed)
    assert result.plan is not None and result.proof.holds, result.proof.findings


def test_an_arm_whose_home_is_a_limit_starts_there(uneven, detections):
    chain = chain_of(uneven, uneven.arm("right"))
    home = np.asarray(uneven.arm("right").home).copy()
    home[6] = uneven.robot.limits(uneven.arm("right").joints)[1][6]
    assert on_wire(home)[6] > chain.upper[6]
    arms = tuple(replace(arm, home=home) if arm.name == "right" else arm for arm in uneven.arms)
    result = plan_pick(replace(uneven, arms=arms), detections, "s", strategy="right")
    assert result.plan is not None and result.proof.holds, result.proof.findings

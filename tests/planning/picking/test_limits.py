"""Plans up to the limits of joints, where those lie between two steps that can be sent."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.kinematics.chain import chain_of


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
    assert result.plan is not None and result.proof.holds, result.proof.violations


def test_an_arm_whose_home_is_a_limit_starts_there(uneven, detections):
    chain = chain_of(uneven, uneven.arm("right"))
    home = np.asarray(uneven.arm("right").home).copy()
    home[6] = uneven.robot.limits(uneven.arm("right").joints)[1][6]
    assert uneven.controller.motion.rounded(home)[6] > chain.upper[6]
    arms = tuple(replace(arm, home=home) if arm.name == "right" else arm for arm in uneven.arms)
    result = plan_pick(replace(uneven, arms=arms), detections, "s", strategy="right")
    assert result.plan is not None and result.proof.holds, result.proof.violations

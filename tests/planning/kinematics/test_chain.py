"""One arm as arrays: the same kinematics as Pinocchio, and inverse kinematics within limits."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.planning.kinematics.chain import chain_of, is_solution
from workbench.planning.kinematics.robot import Kinematics


@pytest.mark.parametrize("name", ["right", "left"])
def test_forward_kinematics_is_that_of_pinocchio(cell, name):
    arm, kinematics = cell.arm(name), Kinematics(cell)
    chain = chain_of(cell, arm)
    rng = np.random.default_rng(1)
    for _ in range(50):
        q = rng.uniform(chain.lower, chain.upper)
        expected = kinematics.tcp_pose(arm, q).homogeneous
        np.testing.assert_allclose(chain.pose(q).homogeneous, expected, atol=1e-12)


@pytest.mark.parametrize("name", ["right", "left"])
def test_solutions_reach_the_pose_within_the_limits(cell, name):
    chain = chain_of(cell, cell.arm(name))
    rng = np.random.default_rng(2)
    solved = 0
    for _ in range(40):
        goal = chain.pose(rng.uniform(chain.lower, chain.upper))
        answers, residuals = chain.solve(goal, rng.uniform(chain.lower, chain.upper, (12, 7)))
        good = answers[is_solution(residuals)]
        solved += len(good) > 0
        for q in good:
            assert np.all(q >= chain.lower) and np.all(q <= chain.upper)
            assert np.linalg.norm(pin.log6(chain.pose(q).actInv(goal)).vector) < 1e-5
    assert solved >= 38


def test_a_pose_out_of_reach_has_no_solution_and_an_honest_residual(cell):
    chain = chain_of(cell, cell.arm("right"))
    far = pin.SE3(np.eye(3), np.array([2.0, 0.0, 0.5]))
    answers, residuals = chain.solve(far, np.zeros((3, 7)))
    assert not is_solution(residuals).any()
    for q, residual in zip(answers, residuals, strict=True):
        distance = np.linalg.norm(chain.pose(q).translation - far.translation)
        assert distance == pytest.approx(residual[0], abs=1e-9)
        assert distance > 1.0


def test_a_half_turn_is_solved(cell):
    chain = chain_of(cell, cell.arm("right"))
    q = np.asarray(cell.arm("right").home)
    turned = chain.pose(q) * pin.SE3(np.diag([-1.0, -1.0, 1.0]), np.zeros(3))
    _, residuals = chain.solve(turned, q[None])
    assert np.all(np.isfinite(residuals))

"""What `ssik` (PyPI), a solver of another make, finds for makers' arms, ours finds too."""

import numpy as np
import pytest
from ssik_arms import made

from workbench.planning.kinematics.inverse import configurations

POSES = 40

CLOSED = ("irb120_ik", "ur5e_ik", "kr6_r900_ik", "rx160_ik", "gp8_ik", "rv4fr_ik")
"""Spherical wrists and three parallel axes."""
ITERATED = ("fanuc_crx10ia_ik", "m1013_ik", "xarm6_ik")
"""Wrists with an offset, for which EAIK has no closed form."""
SPARE = ("yumi_left_ik", "yumi_right_ik", "iiwa7_ik", "franka_panda_ik")
"""Seven axes."""


def drawn(chain, seed):
    """A start, and configurations whose poses are asked for."""
    draw = np.random.default_rng(seed)
    middle = (chain.lower + chain.upper) / 2
    return middle, draw.uniform(chain.lower, chain.upper, (POSES, len(middle)))


def off(answers, q):
    """[rad] How far the nearest answer is, whole turns aside."""
    return np.abs(np.angle(np.exp(1j * (answers - q)))).max(axis=1).min()


@pytest.mark.parametrize(
    ("name", "same"), [(n, 1e-6) for n in CLOSED] + [(n, 1e-4) for n in ITERATED]
)
def test_every_branch_that_the_judge_finds_is_found(name, same):
    arm, chain = made(name)
    start, qs = drawn(chain, 8)
    judged = 0
    for q in qs:
        T = chain.pose(q)
        assert np.allclose(T.homogeneous, arm.fk(q), atol=1e-9)
        answers = configurations(chain, T, start)
        assert answers.is_complete is (name in CLOSED)
        ours = answers.q
        assert off(ours, q) < same
        for other in arm.solve(T.homogeneous, enumerate_windings=False):
            judged += 1
            assert off(ours, other.q) < same
    assert judged >= POSES


@pytest.mark.parametrize("name", SPARE)
def test_no_pose_that_an_arm_of_seven_axes_reaches_is_missed(name):
    _, chain = made(name)
    start, qs = drawn(chain, 9)
    for q in qs:
        assert len(configurations(chain, chain.pose(q), start).q) > 0

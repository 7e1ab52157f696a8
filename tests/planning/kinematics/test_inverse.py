"""Inverse kinematics misses no branch of a six-axis arm, and no pose that an arm reaches."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from shipped import shipped

from workbench.model.candidate import Reason
from workbench.model.messages.verdicts import VerdictNote
from workbench.planning.kinematics.chain import chain_of, is_solution
from workbench.planning.kinematics.inverse import configurations

ROOT = Path(__file__).resolve().parents[3]

POSES = 300


def arm_of(name):
    cell_name, arm = {"tx2_90": ("tx2_90", "right")}.get(name, ("yumi", name))
    cell = shipped(ROOT / "robots" / cell_name / "cell.toml")
    arm = cell.arm(arm)
    return chain_of(cell, arm), np.asarray(arm.home)


@pytest.mark.parametrize("name", ["tx2_90", "right", "left"])
def test_no_pose_that_an_arm_reaches_is_missed(name):
    chain, home = arm_of(name)
    draw = np.random.default_rng(3)
    for _ in range(POSES):
        T = chain.pose(draw.uniform(chain.lower, chain.upper))
        answers = configurations(chain, T, home)
        assert len(answers.q) > 0
        assert np.all(answers.q >= chain.lower) and np.all(answers.q <= chain.upper)
        for q in answers.q:
            assert np.linalg.norm(pin.log6(chain.pose(q).actInv(T)).vector) < 1e-5


def test_the_branch_that_made_a_pose_is_among_the_answers():
    chain, home = arm_of("tx2_90")
    draw = np.random.default_rng(4)
    for _ in range(POSES):
        q = draw.uniform(chain.lower, chain.upper)
        answers = configurations(chain, chain.pose(q), home, turns=64)
        assert answers.is_complete
        assert np.abs(answers.q - q).max(axis=1).min() < 1e-6


def test_iterations_from_many_starts_find_no_branch_that_the_closed_form_has_not():
    chain, home = arm_of("tx2_90")
    draw = np.random.default_rng(5)
    for _ in range(20):
        T = chain.pose(draw.uniform(chain.lower, chain.upper))
        known = configurations(chain, T, home, turns=64).q
        answers, residuals = chain.solve(T, draw.uniform(chain.lower, chain.upper, (200, 6)))
        for q in answers[is_solution(residuals)]:
            # Next to a singularity iterations stop anywhere on the ridge.
            off = np.abs(known - q).max(axis=1).min()
            assert off < 1e-3 or abs(np.sin(q[4])) < 1e-3


def test_an_answer_is_turned_to_be_nearest_to_home_and_others_follow():
    chain, home = arm_of("tx2_90")
    assert chain.upper[5] - chain.lower[5] > 2 * np.pi
    T = chain.pose(home)
    nearest = configurations(chain, T, home, turns=1).q
    every = configurations(chain, T, home, turns=64).q
    assert len(every) > len(nearest)
    assert np.abs(nearest - home).max(axis=1).min() < 1e-6


def test_a_pose_out_of_reach_is_proven_by_the_closed_form_alone():
    for name, is_proof in (("tx2_90", True), ("right", False)):
        chain, home = arm_of(name)
        far = pin.SE3(np.eye(3), np.array([4.0, 0.0, 0.5]))
        answers = configurations(chain, far, home)
        assert len(answers.q) == 0 and answers.is_complete is is_proof
        assert answers.away[0] > 1.0
        assert answers.starts == (1 if is_proof else 97)


def test_a_verdict_says_from_how_many_starts_nothing_was_found():
    from workbench.planning.picking.resolve import _out_of_reach

    chain, home = arm_of("right")
    far = pin.SE3(np.eye(3), np.array([4.0, 0.0, 0.5]))
    verdict = _out_of_reach([configurations(chain, far, home)] * 2)
    assert verdict.reason is Reason.OUT_OF_REACH
    assert verdict.note == VerdictNote.NO_CONFIGURATION(starts=194)
    chain, home = arm_of("tx2_90")
    assert _out_of_reach([configurations(chain, far, home)]).note is None

"""Pegs in holes: what mates in physics, and what is stopped."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.model.recipes.joint import Joint
from workbench.model.recipes.kit import Insertion
from workbench.perception.simulation.inserting import Inserting, Push

PUSH = Push(force=50.0, friction=0.2, stiffness=3000.0)
THERE = pin.SE3.Identity()


def inserting(
    is_peg: bool, chamfer: float = 0.0, compliance: float = 0.0, clearance: float = 0.001
) -> tuple:
    joint = Joint((0.0, 0.0, 0.01), 0.01, 0.01, 0.01, clearance, chamfer, compliance)
    insertion = Insertion("base", (0.0, 0.0, 0.02), (0, 0, 0), (0, 0, -1), 0.03, 1e-4, joint)
    return joint, Inserting(insertion, 0.008, PUSH, is_peg=is_peg)


def off(far: float, degrees: float = 0.0) -> pin.SE3:
    turn = pin.exp3(np.deg2rad([degrees, 0.0, 0.0]))
    return pin.SE3(turn, np.array([0.8 * far, 0.6 * far, 0.0]))


@pytest.mark.parametrize("is_peg", [True, False])
def test_a_hand_that_does_not_give_way_needs_the_clearance(is_peg):
    joint, stiff = inserting(is_peg, chamfer=0.0015)
    for far, mates in ((0.0, True), (0.00095, True), (0.0011, False), (0.002, False)):
        found = stiff.insert(THERE, off(far))
        assert found.is_mated(joint) == mates and found.pushed == 0.0
        # It is the same which of the two is off.
        assert stiff.insert(off(-far), THERE).is_mated(joint) == mates


@pytest.mark.parametrize("is_peg", [True, False])
def test_a_chamfer_catches_what_the_hand_can_give_way(is_peg):
    joint, soft = inserting(is_peg, chamfer=0.002, compliance=0.0015)
    caught = soft.insert(THERE, off(0.0018))
    assert caught.is_mated(joint) and caught.pushed == pytest.approx(0.0008, abs=1e-4)
    assert not soft.insert(THERE, off(0.0027)).is_mated(joint)
    assert soft.insert(THERE, off(0.0034)).left > 0.009


def test_a_part_that_is_tilted_too_far_touches_at_two_points_and_stops():
    joint, soft = inserting(True, chamfer=0.002, compliance=0.004, clearance=0.0004)
    most = float(np.rad2deg(2 * joint.clearance / joint.depth))
    turned = [pin.SE3(off(0.0, tilt).rotation, np.zeros(3)) for tilt in (0.6 * most, 1.3 * most)]
    free, wedged = (soft.insert(THERE, T) for T in turned)
    assert free.is_mated(joint) and not wedged.is_mated(joint)

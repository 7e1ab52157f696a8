"""Parts gripped in simulation, and what it is right about without anybody's model."""

import numpy as np
import pinocchio as pin
import pytest
from resting_parts import ball, brick, hand, off_by, plain, rod, tcp_over

from workbench.model.geometry import Box, pose_from_rpy
from workbench.perception.simulation.gripping import TILE, Gripping, Shaking, tiles

GENTLY = Shaking(20.0, 2.0)
OPEN = 0.04


def in_hand(lying, error, along=0.0, shaking=GENTLY):
    """The error (6,) [mm, deg] of the middle of a part in the hand, along the hand's axes."""
    part, T = lying
    T_world_tcp = tcp_over(T, along)
    meant = T_world_tcp.actInv(T)
    error = np.concatenate([np.array(error[:3]) / 1e3, np.deg2rad(error[3:])])
    held = Gripping(part, hand(), T).grip(off_by(T_world_tcp, T, error), OPEN, shaking)
    assert held.T_tcp_part is not None and held.slip is not None
    assert held.slip[0] < 1e-3 and held.slip[1] < np.deg2rad(2.0)
    shift = held.T_tcp_part.translation - meant.translation
    turn = pin.log3(held.T_tcp_part.rotation @ meant.rotation.T)
    return np.concatenate([shift * 1e3, np.rad2deg(turn)])


def test_a_brick_is_centred_and_turned_flat_and_keeps_the_rest():
    found = in_hand(brick(0.02), (1.0, 1.5, -1.0, 2.0, 3.0, -2.0))
    assert found[[1, 3, 5]] == pytest.approx([0.0, 0.0, 0.0], abs=0.15)
    # As it is turned flat it comes off the floor.
    assert found[[0, 2, 4]] == pytest.approx([1.0, -1.0, 3.0], abs=0.5)


def test_friction_holds_a_wide_brick_as_turned_as_it_is():
    found = in_hand(brick(0.036), (0.0, 0.0, 0.0, 0.0, 0.0, 2.0))
    assert found[5] > 1.0


def test_a_rod_that_is_pushed_rolls():
    found = in_hand(rod(0.01), (0.0, 1.0, 0.0, 0.0, 0.0, 0.0))
    assert abs(found[3]) == pytest.approx(np.rad2deg(0.001 / 0.01), rel=0.35)
    assert abs(found[1]) < 0.3


def test_fingers_that_come_down_on_the_part_or_beside_it_hold_nothing():
    part, T = brick(0.02)
    gripping = Gripping(part, hand(), T)
    for far in (0.012, 0.1):
        beside = pin.SE3(tcp_over(T).rotation, tcp_over(T).translation + np.array([0, far, 0]))
        held = gripping.grip(beside, OPEN, GENTLY)
        assert held.T_tcp_part is None and held.slip is None


def test_a_part_that_is_too_heavy_for_the_force_slips():
    part, T = brick(0.02)
    heavy = plain(part.pieces[0].shape, mass=3.0)
    held = Gripping(heavy, hand(), T).grip(tcp_over(T), OPEN, GENTLY)
    assert held.slip is not None and held.slip[0] > 0.02


def test_the_same_grip_comes_out_the_same_whatever_was_gripped_before():
    part, T = rod(0.01)
    gripping = Gripping(part, hand(), T)
    off = off_by(tcp_over(T), T, np.array([0.001, 0.001, 0.0, 0.0, 0.02, 0.01]))
    first = gripping.grip(off, OPEN, GENTLY).T_tcp_part
    gripping.grip(tcp_over(T), OPEN, GENTLY)
    assert np.array_equal(first, gripping.grip(off, OPEN, GENTLY).T_tcp_part)


def test_a_part_that_leans_on_nothing_falls_and_one_that_lies_stays():
    part, T = brick(0.02)
    stays = Gripping(part, hand(), T).settled()
    assert np.linalg.norm(stays.translation - T.translation) < 1e-4
    leaning = pose_from_rpy((0, 0, 0.0), (0, 0.4, 0))
    falls = Gripping(part, hand(), leaning).settled()
    assert np.linalg.norm(pin.log3(leaning.rotation.T @ falls.rotation)) > 0.2


def test_tiles_fill_the_pad_and_are_as_thick():
    finger = hand().fingers[0]
    found = tiles(finger.solid, finger.direction)
    sizes = np.array([one.shape.size for one in found])
    whole = finger.solid.shape
    assert isinstance(whole, Box)
    assert sizes.prod(axis=1).sum() == pytest.approx(np.prod(whole.size))
    assert np.allclose(sizes[:, 0], whole.size[0]) and (sizes[:, 1:] <= 1.5 * TILE).all()
    middles = np.array([one.T_owner_shape.translation for one in found])
    assert np.allclose(middles.mean(axis=0), finger.solid.T_owner_shape.translation)


def test_a_ball_is_gripped_too():
    found = in_hand(ball(0.012), (1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert found[:3] == pytest.approx([1.0, 0.0, 0.0], abs=0.3)

"""What closing fingers take out of the error of a part, and what they leave."""

import numpy as np
import pytest
from resting_parts import ball, brick, hand, rod, tcp_over

from workbench.model.geometry import pose_from_rpy
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.placing.contact import ALIGNED, PLAY, cup_grip, finger_grip

X, Y, Z, RX, RY, RZ = range(6)


def grip_of(lying, along=0.0):
    part, T = lying
    return finger_grip(GraspChecker(part, hand()), T.actInv(tcp_over(T, along)), T)


@pytest.mark.parametrize("lying", [brick(0.02), brick(0.045), ball(0.012), rod(0.008)])
def test_fingers_take_out_the_error_along_their_travel_and_leave_that_along_the_pads(lying):
    keeps = grip_of(lying).keeps
    # Of the part's middle, which lies 3 mm above the tips.
    of_middle = keeps[Y] + 0.003 * keeps[RX]
    # Facets of a ball are not quite round.
    assert np.allclose(of_middle[[X, Y, Z]], 0.0, atol=0.05)
    assert np.allclose(keeps[np.ix_([X, Z], [X, Z])], np.eye(2), atol=1e-9)


def test_a_turn_about_the_travel_stays():
    for lying in (brick(0.02), ball(0.012), rod(0.008)):
        assert grip_of(lying).keeps[RY, RY] == pytest.approx(1.0)


def test_flat_faces_come_to_lie_flat_on_the_pads():
    grip = grip_of(brick(0.02))
    assert len(grip.turns) == 2
    assert np.allclose(grip.keeps[[RX, RZ]], 0.0, atol=1e-6)


def test_a_part_wider_than_its_faces_are_long_over_friction_stays_turned():
    """Pads are 10 mm wide: friction of 0.4 holds what is wider than 25 mm."""
    wide = grip_of(brick(0.045))
    assert wide.keeps[RZ, RZ] == pytest.approx(1.0, abs=0.02)
    narrow, broad = (grip_of(brick(width)).keeps[RZ, RZ] for width in (0.022, 0.029))
    assert narrow == pytest.approx(0.0, abs=0.02) and broad == pytest.approx(1.0, abs=0.02)


def test_a_rod_lies_along_the_pads_and_may_still_be_rolled_about_its_axis():
    keeps = grip_of(rod(0.008)).keeps
    assert keeps[RZ, RZ] == pytest.approx(0.0, abs=0.02)
    assert keeps[RX, RX] > 0.5


def test_what_lies_round_rolls_by_as_much_as_it_is_pushed():
    for lying, radius in ((ball(0.012), 0.012), (rod(0.008), 0.008)):
        assert abs(grip_of(lying).keeps[RX, Y]) == pytest.approx(1 / radius, rel=0.05)


def test_what_lies_flat_does_not_roll():
    assert np.allclose(grip_of(brick(0.045)).keeps[RX, [X, Y, Z]], 0.0, atol=1e-9)


def test_what_is_pushed_beside_its_middle_swivels_towards_the_side_it_is_pushed_to():
    middle, right, left = (
        grip_of(brick(0.045), along).keeps[RZ, Y] for along in (0.0, 0.015, -0.015)
    )
    assert middle == pytest.approx(0.0, abs=0.1)
    assert right == pytest.approx(-left) and 5.0 < abs(right) < 1 / 0.015


def test_fingers_that_close_up_and_down_push_nothing_aside():
    part, T = brick(0.045)
    upright = pose_from_rpy((0, 0, 0.0225), (np.pi / 2, 0, 0))
    T_part_tcp = T.actInv(tcp_over(T, 0.015))
    keeps = finger_grip(GraspChecker(part, hand()), T_part_tcp, upright).keeps
    assert keeps[RZ, Y] == pytest.approx(0.0, abs=1e-9)


def test_where_nothing_is_between_the_fingers_everything_stays():
    part, T = brick(0.02)
    T_part_tcp = T.actInv(tcp_over(T, 0.5))
    grip = finger_grip(GraspChecker(part, hand()), T_part_tcp, T)
    assert np.array_equal(grip.keeps, np.eye(6)) and len(grip.turns) == 0


def test_a_cup_takes_out_nothing_beside_its_axis():
    keeps = cup_grip().keeps
    assert np.array_equal(keeps @ keeps, keeps)
    assert [keeps[k, k] for k in (X, Y, RZ)] == [1.0, 1.0, 1.0]
    assert [keeps[k, k] for k in (Z, RX, RY)] == [0.0, 0.0, 0.0]


def test_what_a_grip_adds_is_no_more_than_there_was_before():
    grip = grip_of(brick(0.02))
    sure, unsure = (np.diag([1e-3**2] * 3 + [turn**2] * 3) for turn in (1e-3, 0.1))
    little, much = grip.covariance(sure), grip.covariance(unsure)
    assert little[RX, RX] == pytest.approx(1e-3**2) and much[RX, RX] == pytest.approx(ALIGNED**2)
    assert grip.covariance(np.zeros((6, 6)))[Y, Y] == pytest.approx(PLAY**2)

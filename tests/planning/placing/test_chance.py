"""How far parts lie from where they shall, how often that is near, and what does not count."""

import numpy as np
import pinocchio as pin
import pytest
from resting_parts import plain
from scipy.stats import chi

from workbench.model.geometry import Box, Cylinder, Sphere
from workbench.model.part import PartPlace
from workbench.model.scan import Detection
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.planning.placing.chance import Counted, draw_errors, select_counted, within

HERE = pin.SE3.Identity()
Z = np.array([0.0, 0.0, 1.0])
PLACE = PartPlace(HERE, tolerance=0.002, turn_tolerance=0.05)


def box():
    return plain(Box(np.array([0.03, 0.02, 0.01])))


def found(roll_known=True, roll_axis=None):
    return Detection("plain", HERE, roll_known=roll_known, roll_axis=roll_axis)


def test_errors_that_are_drawn_have_the_covariance_that_was_asked_for():
    root = np.random.default_rng(1).standard_normal((6, 6))
    wanted = root @ root.T
    errors = draw_errors(wanted, 200_000, 0)
    assert np.allclose(np.cov(errors.T), wanted, atol=0.05 * np.abs(wanted).max())
    assert np.array_equal(errors, draw_errors(wanted, 200_000, 0))


def test_what_is_known_exactly_is_drawn_as_nothing():
    errors = draw_errors(np.diag([1.0, 0, 0, 0, 0, 0]), 100, 0)
    assert np.abs(errors[:, 1:]).max() == 0.0 and errors[:, 0].std() > 0.5


def test_the_chance_is_that_of_the_maxwell_distribution_where_all_directions_are_alike():
    shifts, turns = select_counted(box(), found(), PLACE).off(
        draw_errors(np.diag([1e-3**2] * 3 + [1e-9] * 3), 200_000, 0)
    )
    assert within((shifts, turns), PLACE) == pytest.approx(chi(3).cdf(2.0), abs=0.003)


def test_shift_and_turn_have_to_be_right_both():
    off = np.array([0.001, 0.003, 0.001]), np.array([0.01, 0.01, 0.1])
    assert within(off, PLACE) == pytest.approx(1 / 3)


def test_of_a_round_part_turns_about_its_axis_do_not_count_wherever_that_is():
    beside = Symmetry(Z, 0, point=(0.02, 0.0, 0.0))
    what = select_counted(plain(Cylinder(0.01, 0.03), beside), found(), PLACE)
    # A turn about that axis shifts the origin, which lies beside it.
    turn = np.array([[0.0, -0.02 * 0.3, 0.0, 0.0, 0.0, 0.3], [0.0, 0.0, 0.0, 0.1, 0.0, 0.0]])
    shifts, turns = what.off(turn)
    assert shifts == pytest.approx([0.0, 0.0], abs=1e-12)
    assert turns == pytest.approx([0.0, 0.1])


def test_of_a_ball_no_turn_counts():
    every = Symmetry(Z, 0, also=(SymmetryAxis(np.array([1.0, 0.0, 0.0]), 0),))
    what = select_counted(plain(Sphere(0.01), every), found(), None)
    assert what.off(np.array([[0.001, 0, 0, 0.2, 0.3, 0.4]]))[1] == pytest.approx([0.0])


def test_a_turn_about_an_axis_that_the_scan_does_not_show_does_not_count():
    axis = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    turn = np.array([[0.0, 0.0, 0.0, 0.3, 0.0, 0.0]])
    for roll_known, counts in ((True, 0.3), (False, 0.0)):
        assert select_counted(box(), found(roll_known, axis), PLACE).off(turn)[1] == pytest.approx(
            counts
        )


def test_at_a_place_for_any_turn_none_about_its_z_counts():
    anyhow = PartPlace(HERE, free_rotation=np.pi)
    turn = np.array([[0.0, 0.0, 0.0, 0.0, 0.1, 0.3]])
    assert select_counted(box(), found(), anyhow).off(turn)[1] == pytest.approx(0.1)
    assert select_counted(box(), found(), PLACE).off(turn)[1] == pytest.approx(np.hypot(0.1, 0.3))


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_turns_about_free_axes_count_nothing_however_they_lean(count):
    axes = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]])[:count]
    what = Counted(np.zeros(3), axes)
    turns = np.vstack([axes, [[0.0, 1.0, 0.0]]])
    _, left = what.off(np.hstack([np.zeros_like(turns), turns]))
    np.testing.assert_allclose(left, [*np.zeros(count), 1.0], atol=1e-12)

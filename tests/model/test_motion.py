"""What can be sent of a configuration, also at the limits of the joints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.model.errors import InputError
from workbench.model.motion import MotionModel

DEGREES = MotionModel("one", unit="deg", decimals=2)
RADIANS = MotionModel("two", unit="rad", decimals=4)
FLOATS = MotionModel("three")

ANGLES = st.floats(-7.0, 7.0)


@given(st.lists(st.floats(-6.0, 6.0), min_size=7, max_size=7))
def test_the_wire_carries_two_decimals_of_a_degree(values):
    q = DEGREES.rounded(np.array(values))
    assert np.abs(q - values).max() <= DEGREES.quantum / 2 + 1e-12
    assert DEGREES.is_sendable(q)
    assert [f"{value:.2f}" for value in np.rad2deg(q)] == [
        f"{value:.2f}" for value in np.rad2deg(DEGREES.rounded(q))
    ]


@pytest.mark.parametrize("motion", [DEGREES, RADIANS, FLOATS])
@given(lower=ANGLES, range_=st.floats(0.001, 7.0), share=st.floats(0.0, 1.0))
def test_rounding_never_leaves_the_limits(motion, lower, range_, share):
    given_limits = np.array([lower]), np.array([lower + range_])
    low, high = motion.limits(*given_limits)
    assert given_limits[0] - 1e-9 <= low <= high <= given_limits[1] + 1e-9
    assert low <= motion.rounded(low + share * (high - low)) <= high


def test_limits_in_whole_steps_stay():
    limits = np.deg2rad(np.array([-143.5, -168.5])), np.deg2rad(np.array([43.5, 168.5]))
    assert np.allclose(DEGREES.limits(*limits), limits, atol=1e-12, rtol=0)


def test_a_joint_without_room_for_two_steps_keeps_its_limits():
    """Planners need a range to draw from."""
    for limits in ((0.123001, 0.123002), (-0.00001, 0.00001)):
        assert DEGREES.limits(*map(np.atleast_1d, limits)) == limits


def test_a_link_that_sends_numbers_as_they_are_changes_none():
    q = np.array([0.1234567891234, -3.0])
    assert (FLOATS.rounded(q) == q).all() and FLOATS.is_sendable(q)
    assert FLOATS.quantum == 0.0


def test_steps_in_radians_are_told_from_those_in_degrees():
    q = np.array([0.1234567])
    assert RADIANS.rounded(q) == [0.1235] and RADIANS.quantum == pytest.approx(1e-4)
    assert RADIANS.is_sendable(np.array([0.1235])) and not DEGREES.is_sendable(np.array([0.1235]))


def test_what_makes_no_sense_is_refused():
    with pytest.raises(InputError, match="needs a period"):
        MotionModel("x", corners="streamed")
    with pytest.raises(InputError, match="at least one arm"):
        MotionModel("x", arms_at_once=0)

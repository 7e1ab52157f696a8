"""Corners of a path moved to where it takes less time."""

from itertools import pairwise

import numpy as np
import pytest

from workbench.planning.kinematics.execution import compute_times
from workbench.planning.planners.ease import ease_corners

VELOCITY, ACCELERATION, ZONE = np.array([1.0, 1.0]), np.array([4.0, 4.0]), 0.2

WALL = 0.6
"""What is in the way: the box of |x| < 0.3 and y < this."""

DETOUR = np.array([[-1.0, 0.0], [-0.8, 1.8], [0.9, 1.6], [1.0, 0.0]])
"""A path over it that goes far around."""


def clear_of_the_box(a, b) -> bool:
    t = np.linspace(0.0, 1.0, 2001)[:, None]
    x, y = (a + t * (b - a)).T
    return not np.any((np.abs(x) < 0.3) & (y < WALL))


def seconds(path) -> float:
    return float(compute_times(path, VELOCITY, ACCELERATION, ZONE)[-1])


def test_a_detour_takes_less_time_and_stays_clear():
    quick = ease_corners(DETOUR, clear_of_the_box, VELOCITY, ACCELERATION, ZONE)
    assert np.array_equal(quick[[0, -1]], DETOUR[[0, -1]])
    assert all(clear_of_the_box(a, b) for a, b in pairwise(quick))
    assert seconds(quick) < 0.75 * seconds(DETOUR)
    # Straight ahead it would take 2 / 1 + 1 / 4.
    assert seconds(quick) >= 2.25


def test_what_is_cut_off_a_corner_is_clear_straight_across_too():
    quick = ease_corners(DETOUR, clear_of_the_box, VELOCITY, ACCELERATION, ZONE)
    assert len(quick) > 2
    for a, c, b in zip(quick[:-2], quick[1:-1], quick[2:], strict=True):
        if not np.array_equal(c, DETOUR[1]) and not np.array_equal(c, DETOUR[2]):
            assert clear_of_the_box(c + ZONE * (a - c), c + ZONE * (b - c))


def test_corners_that_nothing_needs_are_left_out():
    found = ease_corners(DETOUR, lambda a, b: True, VELOCITY, ACCELERATION, ZONE)
    assert np.array_equal(found, DETOUR[[0, -1]])


@pytest.mark.parametrize("velocity", [(1.0, 0.2), (0.2, 1.0), (3.0, 1.0)])
def test_by_the_pace_of_any_joints_it_takes_less_time(velocity):
    pace = np.array(velocity)
    before, after = (
        compute_times(path, pace, ACCELERATION, ZONE)[-1]
        for path in (DETOUR, ease_corners(DETOUR, clear_of_the_box, pace, ACCELERATION, ZONE))
    )
    assert after < 0.9 * before


@pytest.mark.parametrize("count", [1, 2])
def test_a_straight_path_is_left_as_it_is(count):
    path = np.zeros((2, count))
    assert ease_corners(path, lambda a, b: False, np.ones(count), np.ones(count), ZONE) is path


def test_the_same_path_comes_out_again():
    first, again = (
        ease_corners(DETOUR, clear_of_the_box, VELOCITY, ACCELERATION, ZONE) for _ in range(2)
    )
    assert np.array_equal(first, again)


def test_of_the_edges_at_a_corner_that_is_asked_first_which_was_in_the_way():
    """Nothing gets to the goal but by the corner as it is: all else there is asked of once."""
    path, asked = DETOUR[:3], list[tuple[bytes, bytes]]()

    def is_clear(a, b) -> bool:
        asked.append((a.tobytes(), b.tobytes()))
        return not np.array_equal(b, path[2])

    assert np.array_equal(ease_corners(path, is_clear, VELOCITY, ACCELERATION, ZONE), path)
    assert len(asked) == len(set(asked)) > 5, "where nothing has moved nothing is asked again"
    assert sum(b != path[2].tobytes() for _, b in asked) == 1

"""The fastest motion along a curve, judged by numbers: sampled densely, and differentiated."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from judge_times import at_rest_between, curve_at, soonest

from workbench.planning.kinematics.execution import compute_times
from workbench.proof.claims.timing.fastest import (
    _between,
    ceilings,
    fastest,
    find_infeasible_segment,
    seconds,
)
from workbench.proof.claims.timing.pace import CORNER, STRAIGHT, from_rest_to_rest, marks_of

VELOCITY, ACCELERATION = np.array([1.0, 0.6, 2.5]), np.array([8.0, 3.0, 10.0])
PIECES = 2 * CORNER + STRAIGHT


def path_of(seed: int, count: int) -> np.ndarray:
    """Waypoints (count + 1, 3) [rad], near and far apart, with mild and sharp corners."""
    draw = np.random.default_rng(seed)
    steps = draw.normal(size=(count, 3)) * 10 ** draw.uniform(-2, 0, (count, 1))
    return np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])


def motion(path, zone):
    """The fastest motion: its marks, the squared speeds there, slopes and widths."""
    slopes, widths = marks_of(np.diff(path, axis=0), zone)
    x = fastest(slopes, widths, VELOCITY, ACCELERATION)
    return np.concatenate([[0.0], np.cumsum(widths)]), x, slopes, widths


def times_of(x, widths):
    """What each way takes [s]."""
    starts = range(0, len(widths), PIECES)
    return np.array([seconds(x[k : k + PIECES + 1], widths[k : k + PIECES]) for k in starts])


def sampled(path, zone, marks, x, count):
    """Where the joints are (count, 3) [rad] at times that are even, and how far apart [s]."""
    speed, widths = np.sqrt(x), np.diff(marks)
    t = np.concatenate([[0.0], np.cumsum(2 * widths / (speed[1:] + speed[:-1]))])
    at = np.linspace(0.0, t[-1], count)
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(widths) - 1)
    push = (x[k + 1] - x[k]) / (2 * widths[k])
    s = marks[k] + speed[k] * (at - t[k]) + push * (at - t[k]) ** 2 / 2
    return curve_at(path, np.clip(s, 0.0, marks[-1]), zone)[0], t[-1] / (count - 1)


@pytest.mark.parametrize("zone", [0.05, 0.2, 0.45])
@pytest.mark.parametrize("seed", range(4))
def test_its_speeds_and_accelerations_are_within_limits_and_reach_them(seed, zone):
    path = path_of(seed, 6)
    marks, x, _, _ = motion(path, zone)
    q, apart = sampled(path, zone, marks, x, 200_001)
    speeds = np.abs(np.diff(q, axis=0)) / apart / VELOCITY
    # Over 20 samples: next to each other they differ by less than numbers are exact to.
    wide = q[::20]
    pushes = np.abs(np.diff(wide, n=2, axis=0)) / (20 * apart) ** 2 / ACCELERATION
    assert speeds.max() <= 1.0 + 1e-6
    assert pushes.max() <= 1.0 + 1e-3
    assert pushes.max() > 0.99, "the fastest motion is at a limit"


@pytest.mark.parametrize("zone", [0.1, 0.2, 0.45])
@pytest.mark.parametrize("seed", range(4))
def test_no_motion_takes_less_time(seed, zone):
    """A linear program over other marks: none is quicker, and none that is found much slower.

    Where a corner is sharp, the steeper end of a piece counts for both of its ends.
    """
    path = path_of(seed, 6)
    _, x, _, widths = motion(path, zone)
    other = soonest(path, zone, VELOCITY, ACCELERATION).sum()
    assert other * 0.999 <= times_of(x, widths).sum() <= other * 1.08


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.floats(1.0, 30.0), st.sampled_from([0.1, 0.2, 0.4]))
def test_every_motion_of_a_leg_that_is_slower_is_found(seed, slower, zone):
    path = path_of(seed, 5)
    _, x, slopes, widths = motion(path, zone)
    times = times_of(x, widths)
    most = ceilings(slopes, VELOCITY * 1.001)
    given_ = slopes, widths, x, most, ACCELERATION * 1.001
    assert find_infeasible_segment(*given_, times * slower) == -1
    assert find_infeasible_segment(*given_, times * 0.99) >= 0


def test_a_motion_that_cannot_brake_so_soon_is_not_found():
    """Five short ways in time enough for a halt in the third, but for those before and after."""
    path = np.linspace(0.0, 0.5, 6)[:, None] * np.array([1.0, 0.0, 0.0])
    _, x, slopes, widths = motion(path, 0.2)
    most = ceilings(slopes, VELOCITY * 1.001)
    times = np.full(5, 0.1 / VELOCITY[0])
    times[[0, -1]] *= 3
    assert find_infeasible_segment(slopes, widths, x, most, ACCELERATION * 1.001, times) == -1
    # 0.1 rad with 8 rad/s2 can take up to 0.138 s at 1 rad/s at its ends, and up to 0.153 s where
    # the ways beside it use the 0.1 % of rounding to end at 0.96 rad/s.
    times[2] *= 1.6
    assert find_infeasible_segment(slopes, widths, x, most, ACCELERATION * 1.001, times) >= 0
    assert find_infeasible_segment(slopes, widths, x, most, ACCELERATION * 1.001, times * 3) == -1


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), share=st.floats(0.5, 2.0))
def test_from_rest_to_rest_all_joints_in_proportion(seed, share):
    step = np.diff(path_of(seed, 1), axis=0)
    least = at_rest_between(step[0], VELOCITY, ACCELERATION)
    found = from_rest_to_rest(step, np.array([least * share]), VELOCITY, ACCELERATION)
    if abs(share - 1.0) > 0.002:
        assert (found is None) is (share > 1.0)


@pytest.mark.parametrize("zone", [0.0, 0.1, 0.2, 0.45])
@pytest.mark.parametrize("seed", range(20, 26))
def test_what_planning_has_timed_is_possible(seed, zone):
    """Joints whose limits differ, too: one may be slow, another one lazy."""
    path = path_of(seed, 8)
    times, steps = np.diff(compute_times(path, VELOCITY, ACCELERATION, zone)), np.diff(path, axis=0)
    if zone == 0.0:
        assert from_rest_to_rest(steps, times, VELOCITY, ACCELERATION) is None
        return
    slopes, widths = marks_of(steps, zone)
    x = fastest(slopes, widths, VELOCITY, ACCELERATION)
    most = ceilings(slopes, VELOCITY * 1.001)
    assert find_infeasible_segment(slopes, widths, x, most, ACCELERATION * 1.001, times) == -1


def test_a_way_to_an_equal_waypoint_takes_any_time():
    none = np.zeros((1, 3))
    assert from_rest_to_rest(none, np.array([0.001]), VELOCITY, ACCELERATION) is None


@pytest.mark.parametrize("seed", [9, 384, 537])
def test_a_motion_at_speeds_in_between_is_found(seed):
    """Each way from the speed that the one before has ended with, as fast or as slow as it allows.

    So there is such a motion; few of the speeds at waypoints are the fastest there.
    """
    draw = np.random.default_rng(seed)
    steps = draw.normal(0, 0.1, (8, 4)) + 0.15
    velocity, acceleration = np.full(4, 1.0), np.full(4, 4.0)
    slopes, widths = marks_of(steps, 0.2)
    most = ceilings(slopes, velocity)
    quick = fastest(slopes, widths, velocity, acceleration)
    x, times = 0.0, []
    for k in range(0, len(widths), len(widths) // len(steps)):
        way = slice(k, k + len(widths) // len(steps))
        marks = slice(way.start, way.stop + 1)
        soon, slow = np.inf, 0.0
        while not soon <= slow:
            end = quick[way.stop] * draw.choice([1.0, draw.uniform(0.3, 1.0)])
            known = slopes[marks], widths[way], acceleration, most[marks]
            soon, slow = _between(*known, x, end)
        times.append(soon + draw.choice([0.0, 0.98]) * (min(slow, 3 * soon) - soon))
        x = end
    assert find_infeasible_segment(slopes, widths, quick, most, acceleration, np.array(times)) < 0

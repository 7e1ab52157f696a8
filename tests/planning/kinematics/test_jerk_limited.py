"""Timing with limits of jerk: as quick as Ruckig where nothing turns, within bounds elsewhere."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruckig import InputParameter, Ruckig, Trajectory

from workbench.model.errors import WorkbenchError
from workbench.planning.kinematics.execution import compute_times
from workbench.planning.kinematics.quickness import Pace

VELOCITY, ACCELERATION = np.array([2.0, 3.0, 4.0]), np.array([10.0, 12.0, 15.0])


def by_ruckig(far, velocity, acceleration, jerk) -> float:
    """What the joints need from rest to rest, each by a profile of its own [s]."""
    count = len(far)
    asked, found = InputParameter(count), Trajectory(count)
    asked.current_position, asked.target_position = [0.0] * count, [float(x) for x in far]
    asked.max_velocity = [float(x) for x in velocity]
    asked.max_acceleration = [float(x) for x in acceleration]
    asked.max_jerk = [float(x) for x in jerk]
    Ruckig(count).calculate(asked, found)
    return found.duration


def drawn(seed: int):
    """Distances [rad] that are short and long, and limits that do and do not matter."""
    rng = np.random.default_rng(seed)
    far = rng.normal(size=3) * 10 ** rng.uniform(-3, 0.5)
    return far, VELOCITY, ACCELERATION, ACCELERATION * 10 ** rng.uniform(0, 3, 3)


@pytest.mark.parametrize("seed", range(100))
def test_a_straight_way_takes_as_long_as_ruckig_says(seed):
    far, *limits = drawn(seed)
    for joint in range(3):
        one = [limit[joint : joint + 1] for limit in limits]
        path = np.array([[0.0], far[joint : joint + 1]])
        least = by_ruckig(far[joint : joint + 1], *one)
        assert compute_times(path, one[0], one[1], 0.2, one[2])[-1] == pytest.approx(
            least, rel=1e-9
        )
    # Several joints leave the straight way where each has a profile of its own; `Pace` lets them.
    least = by_ruckig(far, *limits)
    assert Pace(*limits).seconds(far) == pytest.approx(least, rel=1e-9)
    path = np.array([0 * far, far])
    assert compute_times(path, limits[0], limits[1], 0.2, limits[2])[-1] >= least * (1 - 1e-9)


def a_path(seed: int) -> np.ndarray:
    """Waypoints (m, 3) [rad], long and short ways mixed, some equal to the one before."""
    rng = np.random.default_rng(seed)
    steps = rng.choice([-1, 1], (rng.integers(1, 12), 3))
    steps = steps * rng.uniform(0, 1, steps.shape) ** rng.choice([1, 4])
    return np.cumsum(steps * rng.choice([1, 1, 1, 0], (len(steps), 1)), axis=0)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 9999), zone=st.sampled_from([0.0, 0.1, 0.2, 0.45]))
def test_less_jerk_takes_longer(seed, zone):
    path = np.vstack([np.zeros(3), a_path(seed)])
    found = [
        compute_times(path, VELOCITY, ACCELERATION, zone, ACCELERATION * k) for k in (1, 10, 1e4)
    ]
    for times in found:
        assert times[0] == 0.0 and np.isfinite(times).all() and (np.diff(times) > 0).all()
    ends = [times[-1] for times in found]
    assert ends == sorted(ends, reverse=True)
    assert ends[1] >= Pace(VELOCITY, ACCELERATION, ACCELERATION * 10).seconds(path[-1]) - 1e-9


@pytest.mark.parametrize("zone", [0.0, 0.2])
@pytest.mark.parametrize("seed", range(20))
def test_jerk_that_is_no_limit_changes_little(seed, zone):
    """Blends in time are shorter than parabolas as wide as the zone, and without push in them."""
    path = np.vstack([np.zeros(3), a_path(seed)])
    without = compute_times(path, VELOCITY, ACCELERATION, zone)[-1]
    without_limit = compute_times(path, VELOCITY, ACCELERATION, zone, np.full(3, 1e9))[-1]
    assert without_limit == pytest.approx(without, rel=0.25 if zone else 1e-3)


def test_one_joint_may_have_no_limit():
    """Of two arms in step one has."""
    path, limits = a_path(5), np.array([50.0, np.inf, np.inf])
    some = compute_times(path, VELOCITY, ACCELERATION, 0.2, limits)[-1]
    assert some <= compute_times(path, VELOCITY, ACCELERATION, 0.2, np.full(3, 50.0))[-1]
    assert np.isfinite(Pace(VELOCITY, ACCELERATION, limits).seconds(np.array([1.0, 1.0, 0.0])))


def test_limits_that_allow_no_motion_are_an_error():
    with pytest.raises(WorkbenchError, match="jerk limits must be above zero"):
        compute_times(np.array([[0.0], [1.0]]), np.ones(1), np.ones(1), 0.2, np.zeros(1))

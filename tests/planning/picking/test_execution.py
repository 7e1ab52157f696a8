"""The timing of a leg: within the limits, from rest to rest, on any path."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.model.errors import WorkbenchError
from workbench.planning.picking.execution import timed

VELOCITY, ACCELERATION = np.array([2.0, 3.0, 4.0]), np.array([10.0, 12.0, 15.0])


@settings(max_examples=80, deadline=None)
@given(
    seed=st.integers(0, 9999),
    count=st.integers(2, 12),
    spread=st.sampled_from([1, 4, 8]),
    zone=st.sampled_from([0.0, 0.1, 0.2, 0.45]),
)
def test_every_path_has_a_timing_that_keeps_to_the_speeds(seed, count, spread, zone):
    rng = np.random.default_rng(seed)
    # A large spread mixes tiny segments with long ones.
    steps = rng.choice([-1, 1], (count, 3)) * rng.uniform(0, 1, (count, 3)) ** spread
    steps[:, 0] += 1e-4
    path = np.cumsum(steps, axis=0)
    times = timed(path, VELOCITY, ACCELERATION, zone)
    assert times[0] == 0.0 and len(times) == count
    assert np.all(np.diff(times) > 0) and np.all(np.isfinite(times))
    speeds = np.abs(np.diff(path, axis=0)) / np.diff(times)[:, None]
    # A rounded corner is shorter than the waypoints make it look, never by more than its zone.
    assert np.all(speeds <= VELOCITY * 1.001 / (1 - zone))


def test_a_long_way_takes_as_long_as_its_slowest_joint():
    path = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.1], [4.0, 0.2, 0.2]])
    assert timed(path, VELOCITY, ACCELERATION, 0.2)[-1] == pytest.approx(2.0 + 0.2, rel=0.03)


@pytest.mark.parametrize("zone", [0.0, 0.2])
@pytest.mark.parametrize("rows", [[0, 0], [0, 0, 0], [0, 0, 1], [0, 1, 1, 2]])
def test_equal_waypoints_are_a_standstill(rows, zone):
    path = np.array([[row, 0.5 * row, 0.1] for row in rows], dtype=float)
    times = timed(path, VELOCITY, ACCELERATION, zone)
    assert len(times) == len(rows) and np.isfinite(times).all()
    assert np.all(np.diff(times) > 0) and times[-1] < 10


def test_limits_that_allow_no_motion_are_an_error():
    with pytest.raises(WorkbenchError, match="above zero"):
        timed(np.array([[0.0], [1.0]]), np.zeros(1), np.ones(1), 0.2)

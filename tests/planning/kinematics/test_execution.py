"""The timing of a leg: within the limits, from rest to rest, on any path."""

import itertools

import numpy as np
import pytest
from blend_curves import RoundedPolyline
from hypothesis import given, settings
from hypothesis import strategies as st
from toppra import algorithm, constraint

from workbench.model.errors import WorkbenchError
from workbench.planning.kinematics import execution
from workbench.planning.kinematics.execution import compute_times

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
    times = compute_times(path, VELOCITY, ACCELERATION, zone)
    assert times[0] == 0.0 and len(times) == count
    assert np.all(np.diff(times) > 0) and np.all(np.isfinite(times))
    speeds = np.abs(np.diff(path, axis=0)) / np.diff(times)[:, None]
    # A rounded corner is shorter than the waypoints make it look, never by more than its zone.
    assert np.all(speeds <= VELOCITY * 1.001 / (1 - zone))


def test_a_long_way_takes_as_long_as_its_slowest_joint():
    path = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.1], [4.0, 0.2, 0.2]])
    assert compute_times(path, VELOCITY, ACCELERATION, 0.2)[-1] == pytest.approx(
        2.0 + 0.2, rel=0.03
    )


@pytest.mark.parametrize("zone", [0.0, 0.2])
@pytest.mark.parametrize("rows", [[0, 0], [0, 0, 0], [0, 0, 1], [0, 1, 1, 2]])
def test_equal_waypoints_are_a_standstill(rows, zone):
    path = np.array([[row, 0.5 * row, 0.1] for row in rows], dtype=float)
    times = compute_times(path, VELOCITY, ACCELERATION, zone)
    assert len(times) == len(rows) and np.isfinite(times).all()
    assert np.all(np.diff(times) > 0) and times[-1] < 10


def test_limits_that_allow_no_motion_are_an_error():
    with pytest.raises(WorkbenchError, match="above zero"):
        compute_times(np.array([[0.0], [1.0]]), np.zeros(1), np.ones(1), 0.2)


def a_path(seed: int) -> tuple[np.ndarray, float]:
    """Waypoints (m, 3) [rad], long and short segments mixed, and a zone."""
    rng = np.random.default_rng(seed)
    steps = rng.choice([-1, 1], (rng.integers(2, 12), 3))
    steps = steps * rng.uniform(0, 1, steps.shape) ** rng.choice([1, 4])
    return np.cumsum(steps, axis=0), float(rng.choice([0.05, 0.1, 0.2, 0.45]))


@pytest.mark.parametrize("seed", range(40))
def test_limits_hold_along_the_whole_curve(seed):
    path, zone = a_path(seed)
    pieces = execution._pieces(np.diff(path, axis=0), zone)
    squares = execution._squared_speeds(*pieces[:3], VELOCITY, ACCELERATION)
    ends = np.concatenate([[0.0], np.cumsum(pieces[2])])
    curve = RoundedPolyline(path, zone)
    assert squares[0] == squares[-1] == 0.0
    for k, (begin, end) in enumerate(itertools.pairwise(ends)):
        s = np.linspace(begin + 1e-9, end - 1e-9, 9)
        u = (squares[k + 1] - squares[k]) / (end - begin) / 2
        square = np.maximum(squares[k] + 2 * u * (s - begin), 0.0)[:, None]
        assert np.all(np.abs(curve(s, 1)) * np.sqrt(square) <= VELOCITY * (1 + 1e-9))
        assert np.all(np.abs(curve(s, 1) * u + curve(s, 2) * square) <= ACCELERATION * (1 + 1e-9))


@pytest.mark.parametrize("seed", sorted({*range(30)} - {2}))
def test_it_is_about_as_fast_as_toppra_on_a_grid_that_is_twenty_times_finer(seed):
    path, zone = a_path(seed)
    limits = [
        constraint.JointVelocityConstraint(np.column_stack([-VELOCITY, VELOCITY])),
        constraint.JointAccelerationConstraint(np.column_stack([-ACCELERATION, ACCELERATION])),
    ]
    grid = np.linspace(0, len(path) - 1, 320 * (len(path) - 1) + 1)
    solver = algorithm.TOPPRA(
        limits, RoundedPolyline(path, zone), gridpoints=grid, solver_wrapper="seidel"
    )
    speeds = solver.compute_parameterization(0.0, 0.0)[1]
    assert speeds is not None
    fastest = np.sum(2 * np.diff(grid) / (speeds[1:] + speeds[:-1]))
    assert 0.98 * fastest < compute_times(path, VELOCITY, ACCELERATION, zone)[-1] < 1.04 * fastest

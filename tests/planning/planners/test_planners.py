"""The planners, and what shortens and divides its paths, in a plane with a wall."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.planning.planners.shorten import TINY, merge_corners, resample, shorten_path
from workbench.planning.planners.trees import sample_around
from workbench.plugins.planner import planner_named, planner_names

LOWER, UPPER, WEIGHTS = np.zeros(2), np.full(2, 4.0), np.ones(2)
START, GOAL = np.array([0.5, 2.0]), np.array([3.5, 2.0])


def free_of_wall(a: np.ndarray, b: np.ndarray) -> bool:
    """A wall at 1.8 < x < 2.2 with a gap above y = 3.5."""
    # Where the segment crosses the wall's slab it must be above the gap's lower edge: exact.
    low, high = (1.8 - a[0], 2.2 - a[0])
    along = b[0] - a[0]
    if along == 0.0:
        return not (low < 0.0 < high and min(a[1], b[1]) < 3.5)
    first, last = sorted((low / along, high / along))
    first, last = max(first, 0.0), min(last, 1.0)
    return first > last or min(a[1] + s * (b[1] - a[1]) for s in (first, last)) >= 3.5


def found(
    seed: int, is_clear=free_of_wall, iterations: int = 3000, planner: str = "rrtconnect"
) -> np.ndarray | None:
    rng = np.random.default_rng(seed)
    search = planner_named(planner)
    return search(START, GOAL, LOWER, UPPER, WEIGHTS, is_clear, iterations=iterations, rng=rng).path


every_planner = pytest.mark.parametrize("planner", planner_names())


@every_planner
@pytest.mark.parametrize("seed", range(10))
def test_the_path_joins_start_and_goal_clear_of_the_wall(seed, planner):
    path = found(seed, planner=planner)
    assert np.array_equal(path[0], START) and np.array_equal(path[-1], GOAL)
    assert all(free_of_wall(a, b) for a, b in itertools.pairwise(path))
    assert np.all((path >= LOWER) & (path <= UPPER))


@every_planner
def test_the_same_seed_gives_the_same_path(planner):
    assert np.array_equal(found(3, planner=planner), found(3, planner=planner))


@every_planner
def test_no_path_through_a_closed_wall(planner):
    def closed(a, b):
        return not min(a[0], b[0]) <= 2.0 <= max(a[0], b[0])

    assert found(0, closed, iterations=200, planner=planner) is None


@every_planner
def test_the_open_plane_is_crossed(planner):
    path = found(0, lambda a, b: True, planner=planner)
    assert path is not None
    assert np.array_equal(path[-1], GOAL)


@pytest.mark.parametrize("seed", range(10))
def test_shortening_keeps_the_ends_and_never_lengthens(seed):
    path = found(seed)
    short = shorten_path(path, free_of_wall, most=10)
    assert len(short) <= max(10, len(path))
    assert np.array_equal(short[0], START) and np.array_equal(short[-1], GOAL)
    assert all(free_of_wall(a, b) for a, b in itertools.pairwise(short))

    def length(p):
        return np.linalg.norm(np.diff(p, axis=0), axis=1).sum()

    assert length(short) <= length(path) + 1e-9


@settings(max_examples=50, deadline=None)
@given(corners=st.integers(2, 14), count=st.integers(2, 14), seed=st.integers(0, 999))
def test_resampling_keeps_every_corner(corners, count, seed):
    path = np.cumsum(np.random.default_rng(seed).uniform(0.1, 1.0, (corners, 3)), axis=0)
    points = resample(path, count)
    assert len(points) == max(count, corners)
    for corner in path:
        assert np.isclose(points, corner).all(axis=1).any()


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 9999), corners=st.integers(2, 12))
def test_merging_keeps_the_ends_and_leaves_no_tiny_segment_in_the_open(seed, corners):
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.uniform(0, 1, (corners, 3)) ** 6, axis=0)
    short = merge_corners(path, lambda a, b: True)
    assert np.array_equal(short[0], path[0]) and np.array_equal(short[-1], path[-1])
    if len(short) > 2:
        assert np.abs(np.diff(short, axis=0)).max(axis=1).min() >= TINY


def test_nothing_is_merged_through_a_wall():
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.001, 0.0], [1.0, 1.0]])
    assert np.array_equal(merge_corners(path, lambda a, b: False), path)


@every_planner
def test_a_search_is_the_same_whatever_was_searched_before(planner):
    alone = found(5, planner=planner)
    for other in planner_names():
        found(8, iterations=50, planner=other)
    assert np.array_equal(found(5, planner=planner), alone)


@every_planner
def test_what_the_edge_check_raises_ends_the_search(planner):
    asked = itertools.count()

    def late(a, b):
        if next(asked) == 30:
            raise TimeoutError
        return free_of_wall(a, b)

    with pytest.raises(TimeoutError):
        found(0, late, planner=planner)
    assert found(0, planner=planner) is not None


@settings(max_examples=200)
@given(seed=st.integers(0, 2**31), iteration=st.integers(0, 300))
def test_samples_are_uniform_draws_around_start_and_goal_within_the_limits(seed, iteration):
    ours, numpys = np.random.default_rng(seed), np.random.default_rng(seed)
    around = 0.3 + 0.03 * iteration
    low = np.maximum(LOWER, np.minimum(START, GOAL) - around)
    high = np.minimum(UPPER, np.maximum(START, GOAL) + around)
    for _ in range(3):
        sample = sample_around(START, GOAL, LOWER, UPPER, iteration, ours)
        assert np.array_equal(sample, numpys.uniform(low, high))

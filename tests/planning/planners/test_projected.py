"""A planner whose nodes are projected: here points of the plane onto a ring."""

import numpy as np
import pytest

from workbench.planning.planners.projected import LONGEST_EDGE, projected_planner

LOW, HIGH, EVEN = np.full(2, -2.0), np.full(2, 2.0), np.ones(2)


def onto_ring(q):
    far = float(np.linalg.norm(q))
    return None if far < 0.1 else q / far


def is_near_ring(a, b) -> bool:
    between = a + np.linspace(0.0, 1.0, 30)[:, None] * (b - a)
    return bool((np.abs(np.linalg.norm(between, axis=1) - 1.0) < 0.05).all())


def search(is_clear, iterations=200, seed=0):
    start, goal, rng = np.array([1.0, 0.0]), np.array([-1.0, 0.0]), np.random.default_rng(seed)
    plan = projected_planner(onto_ring)
    return plan(start, goal, LOW, HIGH, EVEN, is_clear, iterations=iterations, rng=rng)


@pytest.mark.parametrize("seed", range(10))
def test_it_goes_around_a_ring_from_one_end_to_the_other(seed):
    found = search(is_near_ring, seed=seed)
    assert found.path is not None and found.iterations > 0
    np.testing.assert_array_equal(found.path[[0, -1]], [[1.0, 0.0], [-1.0, 0.0]])
    edges = list(zip(found.path[:-1], found.path[1:], strict=True))
    assert all(is_near_ring(a, b) for a, b in edges)
    assert max(np.linalg.norm(b - a) for a, b in edges) <= 1.1 * LONGEST_EDGE


def test_a_ring_that_is_cut_twice_has_no_path():
    def is_clear(a, b) -> bool:
        return is_near_ring(a, b) and a[0] * b[0] > 0.0

    found = search(is_clear, iterations=60)
    assert found.path is None and found.iterations == 60


def test_one_seed_brings_one_path():
    np.testing.assert_array_equal(
        search(is_near_ring, seed=3).path, search(is_near_ring, seed=3).path
    )

"""The promises of planners, tried on boxes in a joint space that anybody can draw."""

import itertools

import numpy as np

from workbench.model.geometry import Floats
from workbench.plugins.planner import Planner, Search

SEEDS = 12
"""Problems that are tried."""

LEAST_SOLVED = 0.75
"""Share of problems with a way around the wall that a planner has to solve."""


LIMIT = 3.0 + 1e-9
"""Of both joints to either side [rad]."""


class _DeadlinePassed(Exception):
    pass


class _Wall:
    """Two joints and a wall between them with a gap; edges are checked exactly."""

    def __init__(self, gap: float, last: int = 10**9):
        self._gap, self._left = gap, last
        self.lower, self.upper = np.full(2, -3.0), np.full(2, 3.0)

    def is_clear(self, a: Floats, b: Floats) -> bool:
        self._left -= 1
        if self._left < 0:
            raise _DeadlinePassed
        assert np.shape(a) == np.shape(b) == (2,), "configurations have the shape of the start"
        # In plain numbers, and what is plain first: some planners ask a million times.
        ax, ay, bx, by = float(a[0]), float(a[1]), float(b[0]), float(b[1])
        if not (abs(ax) <= LIMIT and abs(ay) <= LIMIT and abs(bx) <= LIMIT and abs(by) <= LIMIT):
            return False
        if (ax < -0.1 and bx < -0.1) or (ax > 0.1 and bx > 0.1):
            return True
        # The share of the edge that lies between the wall's faces; the way is highest at its ends.
        if ax == bx:
            first, last = (0.0, 1.0) if abs(ax) < 0.1 else (1.0, 0.0)
        else:
            enter, leave = (-0.1 - ax) / (bx - ax), (0.1 - ax) / (bx - ax)
            first, last = max(0.0, min(enter, leave)), min(1.0, max(enter, leave))
        if first >= last:
            return True
        return all(abs(ay + t * (by - ay) - 1.5) <= self._gap for t in (first, last))

    def search(self, planner: Planner, seed: int, iterations: int = 3000) -> Search:
        start, goal = np.array([-1.5, -1.0]), np.array([1.5, -1.0])
        rng, weights = np.random.default_rng(seed), np.ones(2)
        return planner(
            start,
            goal,
            self.lower,
            self.upper,
            weights,
            self.is_clear,
            iterations=iterations,
            rng=rng,
        )


def check_planner(planner: Planner) -> None:
    """A planner finds ways that are clear, the same ones again, gives up in time, and ends.

    Args:
        planner: as it is declared.
    """
    solved = 0
    for seed in range(SEEDS):
        wall = _Wall(gap=0.6)
        found = wall.search(planner, seed)
        if found.path is None:
            continue
        solved += 1
        path = np.asarray(found.path)
        assert path.ndim == 2 and path.shape[1] == 2, f"a path is (m, n), this one {path.shape}"
        assert np.allclose(path[0], [-1.5, -1.0]), "a path begins at the start"
        assert np.allclose(path[-1], [1.5, -1.0]), "a path ends at the goal"
        assert all(wall.is_clear(a, b) for a, b in itertools.pairwise(path)), (
            f"with seed {seed} a path leads through the wall"
        )
    assert solved >= LEAST_SOLVED * SEEDS, f"{solved} of {SEEDS} problems were solved"
    first, second = _Wall(0.6).search(planner, 1), _Wall(0.6).search(planner, 1)
    assert (first.path is None) == (second.path is None), "the same seed brings the same path"
    if first.path is not None and second.path is not None:
        assert np.array_equal(first.path, second.path), "the same seed brings the same path"
    assert _Wall(gap=0.0).search(planner, 0, iterations=50).path is None, "there is no way"
    try:
        _Wall(gap=0.0, last=20).search(planner, 0, iterations=100_000)
    except _DeadlinePassed:
        return
    raise AssertionError("an error of `is_clear` was swallowed: a deadline could not end it")

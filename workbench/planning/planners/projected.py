"""RRT-Connect among configurations that a projection allows (Berenson and others 2009, CBiRRT).

Most of what is drawn at random tilts a part too far.  So each step is short, and is put back to
where the part is upright before it is checked.
"""

from collections.abc import Callable

import numpy as np

from workbench.model.geometry import Floats
from workbench.planning.planners.rrt import SearchTree
from workbench.planning.planners.trees import sample_around
from workbench.plugins.planner import EdgeCheck, Planner, Search

LONGEST_EDGE = 0.3
"""[rad] Longest new edge, in the weighted metric: what is between two allowed ends seldom leaves
what is allowed."""

LEAST_PROGRESS = 0.1
"""Share of a step by which each has to come nearer to its target."""

Projection = Callable[[Floats], Floats | None]
"""A configuration (n,) near another one that is allowed, or None."""


def projected_planner(project: Projection) -> Planner:
    """A planner whose nodes are all put where `project` puts them."""

    def connect(
        start: Floats,
        goal: Floats,
        lower: Floats,
        upper: Floats,
        weights: Floats,
        is_clear: EdgeCheck,
        *,
        iterations: int,
        rng: np.random.Generator,
    ) -> Search:
        if is_clear(start, goal):
            return Search(np.array([start, goal]), 0)
        trees = SearchTree(start), SearchTree(goal)
        for iteration in range(iterations):
            # The first looks straight from one end to the other.
            drawn = goal if iteration == 0 else None
            if drawn is None:
                drawn = sample_around(start, goal, lower, upper, iteration, rng)
            mine, other = trees if iteration % 2 == 0 else trees[::-1]
            new, _ = _grow(mine, drawn, weights, is_clear, project)
            met, is_met = _grow(other, mine.q[new].copy(), weights, is_clear, project)
            if is_met:
                ways = mine.branch(new)[::-1], other.branch(met)[1:]
                path = [*ways[0], *ways[1]]
                return Search(np.array(path if mine is trees[0] else path[::-1]), iteration + 1)
        return Search(None, iterations)

    return connect


def _grow(
    tree: SearchTree, target: Floats, weights: Floats, is_clear: EdgeCheck, project: Projection
) -> tuple[int, bool]:
    """Steps from the nearest node towards a target (n,): the last node, and whether it is there."""
    number = tree.nearest(target, weights)
    far = float(np.linalg.norm((target - tree.q[number]) * weights))
    while True:
        here = tree.q[number].copy()
        if far <= LONGEST_EDGE:
            if far > 0.0 and is_clear(here, target):
                number, far = tree.add(target, number), 0.0
            return number, far == 0.0
        q = project(here + (target - here) * (LONGEST_EDGE / far))
        if q is None or not is_clear(here, q):
            return number, False
        nearer = float(np.linalg.norm((target - q) * weights))
        if nearer > far - LEAST_PROGRESS * LONGEST_EDGE:
            return number, False
        number, far = tree.add(q, number), nearer

"""Paths between two configurations: RRT-Connect and RRT.

RRT-Connect (Kuffner and LaValle 2000) is written here rather than taken from OMPL, whose Python
module 2.0.1 takes no sampler: samples near start and goal first are what makes ours quick.
"""

import numpy as np

from workbench.model.geometry import Floats
from workbench.planning.collision.sweeping.edges import ASK
from workbench.planning.planners.asking import edges_in, look_at_the_clock
from workbench.planning.planners.trees import (
    EXHAUSTED,
    FULL,
    LONGEST_EDGE,
    OPEN,
    PAUSED,
    grow_trees,
    join_trees,
    larger,
    plant_trees,
    question,
    sample_around,
)
from workbench.plugins.planner import EdgeCheck, Search

GOAL_BIAS = 10


class SearchTree:
    """Configurations (n,) [rad] with their parents; grows by doubling its array.

    Concurrency: one thread.
    """

    def __init__(self, root: Floats):
        self.q = np.empty((64, len(root)))
        self.q[0] = root
        self.parents = [-1]

    def add(self, q: Floats, parent: int) -> int:
        """Append a configuration and return its number."""
        number = len(self.parents)
        if number == len(self.q):
            self.q = np.concatenate([self.q, np.empty_like(self.q)])
        self.q[number] = q
        self.parents.append(parent)
        return number

    def nearest(self, q: Floats, weights: Floats) -> int:
        """The configuration closest to `q` (n,) in the weighted Euclidean metric."""
        difference = (self.q[: len(self.parents)] - q) * weights
        return int(np.argmin(np.einsum("ij,ij->i", difference, difference)))

    def branch(self, number: int) -> list[Floats]:
        """From a configuration back to the root."""
        path: list[Floats] = []
        while number >= 0:
            path.append(self.q[number].copy())
            number = self.parents[number]
        return path


def rrt_connect(
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
    """A path from start to goal (n,) [rad], or none when the iterations are used up.

    The direct way is tried first.  `weights` (n,) make joints count more in the metric: the
    first ones move more of the arm.
    """
    if is_clear(start, goal):
        return Search(np.array([start, goal]), 0)
    trees, edges, answer = plant_trees(start, goal), edges_in(is_clear, len(start)), OPEN
    box = np.array([lower, upper, weights])
    while True:
        why = grow_trees(trees, box, iterations, rng, edges, answer)
        answer = OPEN
        if why == ASK:
            answer = int(is_clear(*question(trees)))
        elif why == FULL:
            trees = larger(trees)
        elif why == PAUSED:
            look_at_the_clock(is_clear)
        elif why == EXHAUSTED:
            return Search(None, iterations)
        else:
            return Search(join_trees(trees), int(trees.at[1]) + 1)


def rrt(
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
    """As `rrt_connect`, with a single tree that grows from the start (LaValle 1998).

    Every `GOAL_BIAS`-th sample is the goal.  Configurations are (n,) [rad].
    """
    tree = SearchTree(start)
    for iteration in range(iterations):
        is_goal = iteration % GOAL_BIAS == 0
        sample = goal if is_goal else sample_around(start, goal, lower, upper, iteration, rng)
        new = _extend(tree, sample, weights, is_clear)
        if new is None or np.linalg.norm((goal - tree.q[new]) * weights) > LONGEST_EDGE:
            continue
        if is_clear(tree.q[new].copy(), goal):
            return Search(np.array([*tree.branch(new)[::-1], goal]), iteration + 1)
    return Search(None, iterations)


def _extend(tree: SearchTree, target: Floats, weights: Floats, is_clear: EdgeCheck) -> int | None:
    """One edge from the nearest configuration towards the target."""
    near = tree.nearest(target, weights)
    step = target - tree.q[near]
    length = float(np.linalg.norm(step * weights))
    if length == 0.0:
        return None
    q = target if length <= LONGEST_EDGE else tree.q[near] + step * (LONGEST_EDGE / length)
    return tree.add(q, near) if is_clear(tree.q[near].copy(), q) else None

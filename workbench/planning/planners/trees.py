"""Two trees that grow towards each other, compiled.

Growing ends where an edge has to be checked that compiled code cannot check, and goes on with the
answer.

Source: J. J. Kuffner and S. M. LaValle, "RRT-Connect: An efficient approach to single-query path
planning", IEEE International Conference on Robotics and Automation, 2000.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.sweeping.edges import ASK, CLEAR, Edges, edge_answer
from workbench.planning.compiled import njit_in_place

LONGEST_EDGE = 0.6
"""[rad] Longest new edge of a tree, in the weighted metric."""

NEARBY = 0.3
WIDENING = 0.03
"""[rad] Growth of the sampled box around start and goal with each iteration, from `NEARBY` on.
Most paths need no joint to move far, and most of its range leads elsewhere."""

FOUND, EXHAUSTED, FULL, PAUSED = 1, 2, 3, 4
"""Why growing has stopped, beside `ASK`: trees have met, iterations are used up, there is no more
room, or it is time to look at the clock."""

EDGES_A_TURN = 500
"""Number of edges that are checked between two readings of the clock."""

DRAW, EXTEND, CONNECT = 0, 1, 2

OPEN = -2
"""The answer to the question that has not been asked yet."""


class Trees(NamedTuple):
    """Both trees, and where growing them stands.

    `q` (2, m, n) [rad] are configurations, `parents` (2, m) the numbers of those before them,
    `counts` (2,) how many there are.  `at` (4,): the phase, the iteration, the number of the
    nearest configuration, and that of the last one of the tree that drew.  `target` (n,) is what
    the tree grows to, `new` (n,) what it would have next [rad].
    """

    q: Floats
    parents: Ints
    counts: Ints
    at: Ints
    target: Floats
    new: Floats


def plant_trees(start: Floats, goal: Floats) -> Trees:
    """A tree at the start and one at the goal (n,) [rad]."""
    q = np.empty((2, 256, len(start)))
    q[:, 0] = start, goal
    return Trees(
        q, np.full((2, 256), -1), np.ones(2, np.int64), np.zeros(4, np.int64), start.copy(),
        start.copy(),
    )  # fmt: skip


def join_trees(trees: Trees) -> Floats:
    """The path (m, n) [rad] through both trees: the one that drew, and the last of the other."""
    drew = int(trees.at[1] % 2)
    number, ways = [0, 0], []
    number[drew], number[1 - drew] = int(trees.at[3]), int(trees.counts[1 - drew]) - 1
    for tree in (0, 1):
        way, at = [], number[tree]
        while at >= 0:
            way.append(trees.q[tree, at])
            at = int(trees.parents[tree, at])
        ways.append(way)
    return np.array(ways[0][::-1] + ways[1][1:])


def larger(trees: Trees) -> Trees:
    """The same trees with room for twice as many configurations."""
    q, parents = (np.concatenate([both, both], axis=1) for both in (trees.q, trees.parents))
    return trees._replace(q=q, parents=parents)


def question(trees: Trees) -> tuple[Floats, Floats]:
    """The edge, between two configurations (n,) [rad], that growing waits for."""
    tree = int(trees.at[1] % 2) if trees.at[0] != CONNECT else 1 - int(trees.at[1] % 2)
    return trees.q[tree, trees.at[2]].copy(), trees.new.copy()


@njit(cache=True)
def grow_trees(
    trees: Trees,
    box: Floats,
    iterations: int,
    rng: np.random.Generator,
    edges: Edges,
    answer: int,
) -> int:
    """Grow both trees until something has to be said; `box` (3, n): limits [rad] and weights.

    `answer` is that to the question with which it returned, or `OPEN`.
    """
    q, parents, counts, at, target, new = trees
    n, left = len(target), EDGES_A_TURN
    while True:
        # The tree that draws grows one edge; the other one grows on until it is there.
        tree = at[1] % 2 if at[0] != CONNECT else 1 - at[1] % 2
        if answer == OPEN:
            if at[0] == DRAW:
                if at[1] == iterations:
                    return EXHAUSTED
                if left <= 0:
                    return PAUSED
                _draw(target, q[0, 0], q[1, 0], box, at[1], rng)
                at[0] = EXTEND
            if counts[tree] == q.shape[1]:
                return FULL
            answer = 0
            at[2] = _nearest(q, tree, int(counts[tree]), target, box)
            length = 0.0
            for i in range(n):
                length += ((target[i] - q[tree, at[2], i]) * box[2, i]) ** 2
            length = np.sqrt(length)
            if length > 0.0:
                share = LONGEST_EDGE / length
                for i in range(n):
                    near = q[tree, at[2], i]
                    new[i] = (
                        target[i] if length <= LONGEST_EDGE else near + (target[i] - near) * share
                    )
                left -= 1
                answer = edge_answer(q[tree, at[2]], new, edges)
                if answer == ASK:
                    return ASK
        if answer != CLEAR:
            at[0] = DRAW
            at[1] += 1
        else:
            is_there = True
            for i in range(n):
                q[tree, counts[tree], i] = new[i]
                is_there &= new[i] == target[i]
            parents[tree, counts[tree]] = at[2]
            counts[tree] += 1
            if at[0] == CONNECT and is_there:
                return FOUND
            if at[0] == EXTEND:
                at[0], at[3] = CONNECT, counts[tree] - 1
                for i in range(n):
                    target[i] = new[i]
        answer = OPEN


def sample_around(
    start: Floats,
    goal: Floats,
    lower: Floats,
    upper: Floats,
    iteration: int,
    rng: np.random.Generator,
) -> Floats:
    """A configuration (n,) [rad] within limits, in the box around start and goal; see `NEARBY`."""
    around = NEARBY + WIDENING * iteration
    low = np.maximum(lower, np.minimum(start, goal) - around)
    high = np.minimum(upper, np.maximum(start, goal) + around)
    # What `rng.uniform` does with arrays, number for number, in a fifth of the time.
    return low + (high - low) * rng.random(len(low))


@njit(cache=True)
def _draw(
    sample: Floats,
    start: Floats,
    goal: Floats,
    box: Floats,
    iteration: int,
    rng: np.random.Generator,
) -> None:
    """As `sample_around`."""
    around = NEARBY + WIDENING * iteration
    for i in range(len(sample)):
        low = max(box[0, i], min(start[i], goal[i]) - around)
        high = min(box[1, i], max(start[i], goal[i]) + around)
        sample[i] = low + (high - low) * rng.random()


@njit_in_place
def _nearest(q: Floats, tree: int, count: int, target: Floats, box: Floats) -> int:
    """Number of the configuration closest to the target in the weighted Euclidean metric."""
    best, nearest = np.inf, 0
    for k in range(count):
        far = 0.0
        for i in range(len(target)):
            far += ((q[tree, k, i] - target[i]) * box[2, i]) ** 2
        if far < best:
            best, nearest = far, k
    return nearest

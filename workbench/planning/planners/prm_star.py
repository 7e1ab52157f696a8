"""PRM*: a roadmap that is joined ever more densely, and the shortest way through it.

Source: S. Karaman and E. Frazzoli, "Sampling-based algorithms for optimal motion planning",
International Journal of Robotics Research 30(7), 2011, algorithm 4, with the k nearest neighbours.
"""

import math

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from workbench.model.geometry import Floats
from workbench.planning.planners.trees import sample_around
from workbench.plugins.planner import EdgeCheck, Search


def prm_star(
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
    """The shortest way through a roadmap of as many samples as there are iterations.

    The arguments, configurations (n,) [rad], are those of `planners.rrt_connect`.
    """
    if is_clear(start, goal):
        return Search(np.array([start, goal]), 0)
    q = np.empty((iterations + 2, len(start)))
    q[:2] = start, goal
    count = 2
    edges: list[tuple[int, int, float]] = []
    for iteration in range(iterations):
        sample = sample_around(start, goal, lower, upper, iteration, rng)
        if not is_clear(sample, sample):
            continue
        lengths = np.linalg.norm((q[:count] - sample) * weights, axis=1)
        for near in np.argsort(lengths, kind="stable")[: _neighbours(count, len(start))].tolist():
            if is_clear(q[near].copy(), sample):
                edges.append((near, count, float(lengths[near])))
        q[count] = sample
        count += 1
    return Search(_shortest(q[:count], edges), iterations)


def _neighbours(count: int, dimension: int) -> int:
    """How many neighbours make the shortest way converge to the best one."""
    return math.ceil(math.e * (1 + 1 / dimension) * math.log(count))


def _shortest(q: Floats, edges: list[tuple[int, int, float]]) -> Floats | None:
    if not edges:
        return None
    first, second, lengths = (np.array(column) for column in zip(*edges, strict=True))
    graph = coo_array((lengths, (first, second)), shape=(len(q), len(q))).tocsr()
    distances, before = dijkstra(graph, directed=False, indices=0, return_predecessors=True)
    if not np.isfinite(distances[1]):
        return None
    at, path = 1, [1]
    while at != 0:
        at = int(before[at])
        path.append(at)
    return q[path[::-1]].copy()

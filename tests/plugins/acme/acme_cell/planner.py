"""A planner that tries one point on the way after the other."""

import numpy as np

from workbench.model.geometry import Floats
from workbench.plugins.planner import EdgeCheck, Search


def vias(
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
    """Start, one configuration near the way, goal: nearer ones first."""
    if is_clear(start, goal):
        return Search(np.array([start, goal]), 0)
    for number in range(iterations):
        reach = 0.2 + 0.01 * number
        middle = start + rng.uniform() * (goal - start)
        via = np.clip(middle + rng.uniform(-reach, reach, len(start)), lower, upper)
        if is_clear(start, via) and is_clear(via, goal):
            return Search(np.array([start, via, goal]), number + 1)
    return Search(None, iterations)

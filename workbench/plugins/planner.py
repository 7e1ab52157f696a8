"""The seam of planners: free motions between two configurations."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from workbench.model.geometry import Floats
from workbench.plugins.found import Group, load, names

ENTRY_POINTS: Group = "workbench.planners"

EdgeCheck = Callable[[Floats, Floats], bool]
"""Whether the straight joint motion between two configurations (n,) is clear."""


class Search(NamedTuple):
    """What a planner found: a path (m, n) [rad] with start and goal, or None, and its effort."""

    path: Floats | None
    iterations: int


class Planner(Protocol):
    """Finds a path between two configurations; it knows no robot.

    A function with this interface.  What it returns is shortened, rounded to what can be sent, and
    checked as it will be run: a planner has to be quick, not careful.  It draws from `rng` alone,
    so that the same seed brings the same plan, keeps no state, and lets errors of `is_clear` pass:
    that is how a deadline ends it.
    """

    def __call__(
        self,
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
        """Search until there is a path or the iterations are used up.

        Args:
            start: configuration (n,) [rad], clear and within the limits.
            goal: configuration (n,) [rad], likewise.
            lower: (n,) [rad] limits of the joints.
            upper: (n,) [rad] likewise.
            weights: (n,) how much each joint counts in the metric; no unit.
            is_clear: whether a straight motion is clear; what counts are the calls to it.
            iterations: how many samples may be drawn.
            rng: where they are drawn from.
        """
        ...


def planner_names() -> tuple[str, ...]:
    """All planners there are."""
    return names(ENTRY_POINTS)


def planner_named(name: str) -> Planner:
    """The planner of that name.

    Raises:
        InputError: there is none.
    """
    return load(ENTRY_POINTS, name)

"""Sets of configurations that can be halved."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Bools, Floats, Ints


@dataclass(frozen=True, slots=True, eq=False)
class Sets:
    """Sets of configurations (k,), each the hull of the first `sizes` (k,) of its `corners`.

    `corners` (k, 3, n) [rad, m] are of the values whose places in a whole configuration are
    `columns` (n,).  Sets that follow each other are a group, `groups` (k,) ascending from 0: they
    come after waypoint `at` (g,) and lie in the hull of `around` (g, 3, n) [rad, m].
    """

    columns: Ints
    corners: Floats
    sizes: Ints
    groups: Ints
    around: Floats
    at: Ints

    def only(self, chosen: Bools) -> "Sets":
        """Those that are chosen (k,)."""
        numbers, corners, sizes = self.groups[chosen], self.corners[chosen], self.sizes[chosen]
        begins = np.diff(numbers, prepend=-1) > 0
        kept, groups = numbers[begins], np.cumsum(begins) - 1
        return Sets(self.columns, corners, sizes, groups, self.around[kept], self.at[kept])

    def after(self, waypoints: Bools) -> "Sets":
        """Those that come after the waypoints (w,) that are chosen."""
        return self.only(waypoints[self.at[self.groups]])

    def runs(self, most: int) -> Iterator["Sets"]:
        """All of them, this many groups at once."""
        for start in range(0, len(self.at), most):
            ends = slice(start, start + most)
            k = slice(*np.searchsorted(self.groups, (start, start + most)).tolist())
            corners, sizes, groups = self.corners[k], self.sizes[k], self.groups[k] - start
            yield Sets(self.columns, corners, sizes, groups, self.around[ends], self.at[ends])

    def with_others(self, other: "Sets") -> "Sets":
        """These, and others of the same columns after them."""
        groups = np.concatenate([self.groups, other.groups + len(self.at)])
        return Sets(
            self.columns,
            np.concatenate([self.corners, other.corners]),
            np.concatenate([self.sizes, other.sizes]),
            groups,
            np.concatenate([self.around, other.around]),
            np.concatenate([self.at, other.at]),
        )

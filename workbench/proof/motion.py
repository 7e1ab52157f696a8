"""What a controller may make of waypoints, as sets of configurations that can be halved.

Between two waypoints all joints move in proportion: a segment.  A controller that blends cuts the
corner at a waypoint by a parabola, somewhere between not at all and its zone; one that is streamed
cuts it straight, by less than half of both segments.  So a motion is a number of segments and
triangles in joint space, and two arms that move at any speeds are every combination of both.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Bools, Floats, Ints
from workbench.model.motion import MotionModel

STREAMED_ZONE = 0.5
"""A straight line between two samples of a curve cuts a corner by less than this of a segment."""


TWICE = 1
"""How often what a parabola cuts off is halved before triangles stand for it."""


@dataclass(frozen=True, slots=True, eq=False)
class Sets:
    """Sets of configurations (k,), each the hull of its `corners` (k, m, n) [rad, m].

    `columns` (n,) are the places of these values in a whole configuration; `at` (k,) counts the
    waypoint before each set.
    """

    columns: Ints
    corners: Floats
    at: Ints

    @property
    def middles(self) -> Floats:
        """A configuration (k, n) within each set."""
        return self.corners.mean(axis=1)

    @property
    def spans(self) -> Floats:
        """How far each value (k, n) in a set is from that of its middle at most."""
        return np.abs(self.corners - self.middles[:, None]).max(axis=1)

    def only(self, chosen: Ints | Bools) -> "Sets":
        """Some of them."""
        return Sets(self.columns, self.corners[chosen], self.at[chosen])

    def halves(self, weights: Floats) -> "Sets":
        """Every set cut in two through its longest edge, the halves of each after each other.

        Args:
            weights: (n,) how much each value counts in the length.
        """
        count, m, n = self.corners.shape
        i, j = EDGES[m]
        edges = (np.abs(self.corners[:, i] - self.corners[:, j]) * weights).sum(axis=2)
        longest = edges.argmax(axis=1)
        rows, first, second = np.arange(count), i[longest], j[longest]
        middle = (self.corners[rows, first] + self.corners[rows, second]) / 2
        one, other = self.corners.copy(), self.corners.copy()
        one[rows, second] = middle
        other[rows, first] = middle
        corners = np.stack([one, other], axis=1).reshape(2 * count, m, n)
        return Sets(self.columns, corners, np.repeat(self.at, 2))


EDGES = {
    1: (np.zeros(1, int), np.zeros(1, int)),
    2: (np.array([0]), np.array([1])),
    3: (np.array([0, 0, 1]), np.array([1, 2, 2])),
}
"""For a number of corners, the two ends of every edge."""


def moved(columns: Ints, path: Floats, motion: MotionModel, zone: float) -> tuple[Sets, ...]:
    """Everything that a controller may make of waypoints.

    Args:
        columns: (n,) of the values in a whole configuration.
        path: waypoints (m, n) [rad, m].
        motion: how the controller moves.
        zone: the widest blend, as a share of a segment.
    """
    count = len(path) - 1
    segments = Sets(columns, np.stack([path[:-1], path[1:]], axis=1), np.arange(count))
    wide = {"stop": 0.0, "blend": zone, "streamed": STREAMED_ZONE}[motion.corners]
    if count < 2 or wide == 0.0:
        return (segments,)
    steps = np.diff(path, axis=0)
    before, after = path[1:-1] - wide * steps[:-1], path[1:-1] + wide * steps[1:]
    if motion.corners == "streamed":
        corners = [np.stack([before, path[1:-1], after], axis=1)]
    else:
        corners = list(_blended(before, path[1:-1], after, TWICE))
    at = np.tile(np.arange(count - 1), len(corners))
    return (segments, Sets(columns, np.concatenate(corners), at))


def _blended(start: Floats, corner: Floats, end: Floats, times: int) -> Iterator[Floats]:
    """Triangles (k, 3, n) that hold all between corners (k, n) and the parabolas that cut them.

    A parabola from `start` to `end` touches the line between the middles of both sides in its own
    middle: beyond that line it is within two smaller such corners, which are halved `times`.
    """
    a, b = (start + corner) / 2, (corner + end) / 2
    middle = (a + b) / 2
    yield np.stack([a, corner, b], axis=1)
    for one in ((start, a, middle), (middle, b, end)):
        if times:
            yield from _blended(*one, times - 1)
        else:
            yield np.stack(one, axis=1)


def changed(columns: Ints, start: Floats, end: Floats, at: int) -> Sets:
    """The segment between two configurations (n,) [rad, m], at a waypoint."""
    return Sets(columns, np.stack([start, end])[None], np.array([at]))

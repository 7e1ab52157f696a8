"""What a controller may make of waypoints, as sets of configurations that can be halved.

Between two waypoints all joints move in proportion: a segment.  A controller that blends cuts the
corner at a waypoint by a parabola, somewhere between not at all and its zone; one that is streamed
cuts it straight, by less than half of both segments.  So a motion is a number of segments and
triangles in joint space; two arms that move at any speeds are every combination of both.
"""

from collections.abc import Iterator

import numpy as np

from workbench.model.geometry import Floats, Ints
from workbench.model.motion import MotionModel
from workbench.proof.engine.sets import Sets

STREAMED_ZONE = 0.5
"""A straight line between two samples of a curve cuts a corner by less than this of a segment."""


BLEND_HALVINGS = 1
"""How often what a parabola cuts off is halved before triangles stand for it."""

OFTEN = 0.044
"""[rad] The sum of all joints' turns after which a hand is checked again: within 1.2 m of an axis
its chord is then less than 0.3 mm off, by L^2 / 8 times that."""


def sweep_path(columns: Ints, path: Floats, motion: MotionModel, zone: float) -> Sets:
    """Everything that a controller may make of waypoints: a group after each of them.

    Args:
        columns: (n,) of the values in a whole configuration.
        path: waypoints (m, n) [rad, m].
        motion: how the controller moves.
        zone: the widest blend, as a share of a segment.
    """
    wide = {"stop": 0.0, "blend": zone, "streamed": STREAMED_ZONE}[motion.corners]
    cuts = CUTS[motion.corners if wide > 0.0 else "stop"]
    start, end, steps = path[:-1], path[1:], np.diff(path, axis=0)
    after = end.copy()
    after[:-1] += wide * steps[1:]
    segments = np.stack([start, end, end], axis=1)
    tips = np.stack([end[:-1] - wide * steps[:-1], end[:-1], after[:-1]], axis=1)
    # (k, c, 3, n): of each corner the segment before it, and what may be cut off it.
    pieces = np.concatenate([segments[:-1, None], cuts @ tips[:, None]], axis=1)
    corners = np.concatenate([pieces.reshape(-1, 3, path.shape[1]), segments[-1:]])
    at, counts = np.arange(len(start)), np.full(len(start), 1 + len(cuts))
    counts[-1:] = 1
    groups = np.repeat(at, counts)
    sizes = np.where(np.arange(len(groups)) % (1 + len(cuts)), 3, 2)
    return Sets(columns, corners, sizes, groups, np.stack([start, end, after], axis=1), at)


def _blend(tip: Floats, times: int) -> Iterator[Floats]:
    """Triangles (3, n) that hold all between a corner (3, n) and the parabolas that cut it.

    A parabola from start to end touches the line between the middles of both sides in its own
    middle: beyond that line it is within two smaller such corners, which are halved `times`.
    """
    start, corner, end = tip
    a, b = (start + corner) / 2, (corner + end) / 2
    yield np.stack([a, corner, b])
    for half in (np.stack([start, a, (a + b) / 2]), np.stack([(a + b) / 2, b, end])):
        if times:
            yield from _blend(half, times - 1)
        else:
            yield half


CUTS = {
    "stop": np.empty((0, 3, 3)),
    "blend": np.stack(list(_blend(np.eye(3), BLEND_HALVINGS))),
    "streamed": np.eye(3)[None],
}
"""Triangles (c, 3, 3) for what is cut off a corner, whose corners are means of that corner's."""


def sweep_change(columns: Ints, start: Floats, end: Floats, at: int) -> Sets:
    """The segment between two configurations (n,) [rad, m], at a waypoint."""
    corners = np.stack([start, end, end])[None]
    return Sets(columns, corners, np.array([2]), np.array([0]), corners, np.array([at]))


def dense_path(path: Floats) -> tuple[Floats, Ints]:
    """Configurations (k, n) [rad] along waypoints (m, n), and the waypoint (k,) before each."""
    steps = np.diff(path, axis=0)
    counts = np.ceil(np.abs(steps).sum(axis=1) / OFTEN).astype(int).clip(min=1)
    at = np.repeat(np.arange(len(steps)), counts)
    shares = np.concatenate([np.arange(count) / count for count in counts])
    rows = path[at] + shares[:, None] * steps[at]
    return np.vstack([rows, path[-1]]), np.append(at, len(steps) - 1)

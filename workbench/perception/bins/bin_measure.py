"""The size of a bin of which nothing is known, by a scan that shows its floor and its rim.

Walls show a ring at each height over the floor; the highest one is the rim.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.perception.bins.bin_search import rectangle_around
from workbench.perception.bins.floor_search import find_floor

MOST_POINTS = 30_000
"""Points that are checked; of more every second, third, ..."""

LOWEST_RIM, HIGHEST_RIM = 0.015, 0.8
"""[m] Heights of a rim over the floor."""

RING_HALF_HEIGHT, RING_SPACING = 0.004, 0.002
"""[m] Half the height of a ring, and the distance of the rings that are tried."""

WALL_WITHIN, PIECE = 0.01, 0.01
"""[m] Points this near to a side of the ring's rectangle are of its walls: those of cartons are
bent.  Sides are divided in pieces of this length, each shown or not."""

SHOWN_SHARE, SHOWN_A_SIDE = 0.6, 0.5
"""Share of a ring that is shown at least, and of each of its sides but one."""

HOLLOW = 0.5
"""Share of the points at the ring's height that are of its walls, at least."""

SAME_BIN_SHARE = 0.9
"""Rings around this share of the area of the largest one are rings of the same bin."""

LEVELLED = float(np.cos(np.deg2rad(2.0)))
"""Cosine between the normals of the floor within a bin and of what it stands on, at least."""

FEWEST_POINTS, NARROWEST_BIN = 100, 0.1
"""Points of a ring at least, and [m] the shorter side of the smallest bin."""

TOP = 90.0
"""[percent] Of the points of the walls near the rim lie lower than the rim."""


@dataclass(frozen=True, slots=True)
class MeasuredBin:
    """`outside` are the longer and the shorter side around the rim, `height` that over the floor.

    All in [m].
    """

    outside: tuple[float, float]
    height: float


def measure_bin(points: Floats) -> MeasuredBin | None:
    """The bin around the floor in a scan, None where no rim stands on it.

    Args:
        points: (n, 3) [m] in the scanner's frame.
    """
    points = points[:: max(1, len(points) // MOST_POINTS)]
    floor = find_floor(points)
    if floor is None:
        return None
    over, rim = _find_rim(points, floor[0])
    if rim is None:
        return None
    # A table around the bin is a floor as well, and tilts it: that within the ring counts.
    local = (over - rim.T_floor_ring.translation) @ rim.T_floor_ring.rotation
    inside = (np.abs(local[:, :2]) < np.array(rim.outside) / 2 - WALL_WITHIN).all(axis=1)
    inner = find_floor(points[inside & (local[:, 2] < -RING_HALF_HEIGHT)])
    if inner is not None and inner[0].rotation[:, 2] @ floor[0].rotation[:, 2] > LEVELLED:
        over_inner, rim_inner = _find_rim(points, inner[0])
        if rim_inner is not None:
            over, rim = over_inner, rim_inner
    return MeasuredBin(rim.outside, _top(over, rim))


def _find_rim(points: Floats, T_scanner_floor: pin.SE3) -> tuple[Floats, "_Ring | None"]:
    """Points (n, 3) [m] over a floor, and the highest of its large rings."""
    over = (points - T_scanner_floor.translation) @ T_scanner_floor.rotation
    rings = list(_rings(over))
    largest = max((np.prod(ring.outside) for ring in rings), default=0.0)
    return over, next(
        (ring for ring in rings if np.prod(ring.outside) >= SAME_BIN_SHARE * largest), None
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Ring:
    """Walls at one height over the floor: a frame in their middle, and their sides [m]."""

    T_floor_ring: pin.SE3
    outside: tuple[float, float]


def _rings(over: Floats) -> Iterator[_Ring]:
    """The rings that points (n, 3) [m] over the floor show, the highest first."""
    top = min(float(np.percentile(over[:, 2], 99.9)), HIGHEST_RIM)
    for height in np.arange(top, LOWEST_RIM, -RING_SPACING):
        points = over[np.abs(over[:, 2] - height) < RING_HALF_HEIGHT]
        if len(points) < FEWEST_POINTS:
            continue
        T_floor_ring, outside = rectangle_around(points, np.array([0.0, 0.0, 1.0]), float(height))
        if outside[1] >= NARROWEST_BIN and _is_rim(points, T_floor_ring, np.array(outside)):
            yield _Ring(T_floor_ring, outside)


def _is_rim(ring: Floats, T_floor_ring: pin.SE3, outside: Floats) -> bool:
    """Whether points (n, 3) [m] show the sides of a rectangle around them, and little else."""
    local = (ring - T_floor_ring.translation) @ T_floor_ring.rotation
    half = outside / 2
    shown: list[float] = []
    lengths: list[float] = []
    is_wall = np.zeros(len(local), np.bool_)
    for along, across in ((1, 0), (0, 1)):
        for sign in (-1.0, 1.0):
            near = np.abs(sign * local[:, across] - half[across]) < WALL_WITHIN
            is_wall |= near
            pieces = max(1, int(outside[along] / PIECE))
            at = np.clip((local[near, along] / outside[along] + 0.5) * pieces, 0, pieces - 1)
            shown.append(len(np.unique(at.astype(int))) / pieces)
            lengths.append(float(outside[along]))
    share = float(np.average(shown, weights=lengths))
    return share >= SHOWN_SHARE and sorted(shown)[1] >= SHOWN_A_SIDE and is_wall.mean() >= HOLLOW


def _top(over: Floats, ring: _Ring) -> float:
    """How high the walls are [m] whose highest ring that is."""
    local = (over - ring.T_floor_ring.translation) @ ring.T_floor_ring.rotation
    beyond = (np.abs(local[:, :2]) - np.array(ring.outside) / 2).max(axis=1)
    wall = over[(np.abs(beyond) < WALL_WITHIN) & (np.abs(local[:, 2]) < 2 * RING_HALF_HEIGHT), 2]
    return float(np.percentile(wall, TOP))

"""Hulls joined, two by two, as long as their common hull is close enough to the mesh."""

import heapq
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import ConvexHull

from workbench.formats.meshes.pieces.hulls import outside, points_on, together
from workbench.formats.meshes.pieces.surfaces import Surface
from workbench.model.geometry import Floats

APART = 1e-6
"""[m] Hulls that are no further apart may touch, and a corner no further away lies on one."""

FINE = 0.5
"""Of the tolerance: so far apart, about, are points at which a common hull is looked at."""
FEWEST, MOST = 50, 2_000
"""Such points of a pair."""

ENOUGH = 0.5
"""Of the tolerance: distances below it need not be known closer."""


@dataclass(order=True, slots=True)
class _Pair:
    """Two hulls by number, and by how much their common hull is too large [m].

    At least so much, until it is measured.
    """

    excess: float
    numbers: tuple[int, int]
    both: ConvexHull = field(compare=False)
    is_measured: bool = field(default=False, compare=False)


def joined(
    hulls: list[ConvexHull], surface: Surface, tolerance: float, most: int
) -> list[ConvexHull]:
    """The hulls, those in one whose common hull is close enough to the mesh.

    Where they are more than `most`, also those whose common hull is the least too large.

    Args:
        hulls: together they cover the surface.
        surface: of the mesh.
        tolerance: [m] by which a common hull may be too large.
        most: hulls that may be left.
    """
    left: dict[int, ConvexHull] = {}
    queue: list[_Pair] = []
    for number, hull in enumerate(hulls):
        for pair in _pairs(left, number, hull):
            heapq.heappush(queue, pair)
        left[number] = hull
    new = len(hulls)
    while queue:
        pair = heapq.heappop(queue)
        if pair.excess > tolerance and len(left) <= most:
            break
        if not left.keys() >= set(pair.numbers):
            continue
        if not pair.is_measured:
            points = _new_points(pair.both, [left[number] for number in pair.numbers], tolerance)
            far = surface.farthest(points, ENOUGH * tolerance)[0] if len(points) else 0.0
            pair.excess, pair.is_measured = max(pair.excess, far), True
            heapq.heappush(queue, pair)
            continue
        for number in pair.numbers:
            del left[number]
        for other in _pairs(left, new, pair.both):
            heapq.heappush(queue, other)
        left[new] = pair.both
        new += 1
    return list(left.values())


def _pairs(hulls: dict[int, ConvexHull], number: int, hull: ConvexHull) -> Iterable[_Pair]:
    """A hull with each of those that it may touch."""
    if not hulls:
        return
    numbers = list(hulls)
    lows, highs = (
        np.array([getattr(one, bound) for one in hulls.values()])
        for bound in ("min_bound", "max_bound")
    )
    touch = (np.maximum(lows, hull.min_bound) <= np.minimum(highs, hull.max_bound) + APART).all(1)
    for k in np.flatnonzero(touch).tolist():
        other = hulls[numbers[k]]
        both = together(hull, other)
        gap = max(0.0, float((both.volume - hull.volume - other.volume) / both.area))
        yield _Pair(gap, (numbers[k], number), both)


def _new_points(both: ConvexHull, parts: list[ConvexHull], tolerance: float) -> Floats:
    """Points (n, 3) [m] on those faces of a common hull that no part has."""
    is_new = np.ones(len(both.simplices), bool)
    for part in parts:
        is_on = outside(part, both.points) <= APART
        is_new &= ~is_on[both.simplices].all(axis=1)
    if not is_new.any():
        return np.empty((0, 3))
    corners = both.points[both.simplices[is_new]]
    a, b, c = np.moveaxis(corners, 1, 0)
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2
    count = int(np.clip(area / (FINE * tolerance) ** 2, FEWEST, MOST))
    return points_on(corners, count)[0]

"""Hulls joined, two by two, as long as their common hull is close enough to the mesh."""

import heapq
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import ConvexHull

from workbench.formats.meshes.pieces.hulls import area_of, outside, points_for, points_on, together
from workbench.formats.meshes.pieces.surfaces import Surface
from workbench.model.geometry import Floats

TOUCHING_WITHIN = 1e-6
"""[m] Hulls that are no further apart may touch, and a corner no further away lies on one."""

FIRST_POINTS = 100
"""Points that show most common hulls to be too large."""

MEASURED_TWICE = 2
"""A pair is measured at few points, and closely only when no other pair seems better."""

NEAR_ENOUGH_SHARE = 0.5
"""Of the tolerance: distances below it need not be known closer."""


@dataclass(order=True, slots=True)
class _Pair:
    """Two hulls by number, and by how much their common hull is too large [m].

    At least so much, until it has had all its `looks`.
    """

    excess: float
    numbers: tuple[int, int]
    both: ConvexHull = field(compare=False)
    looks: int = field(default=0, compare=False)


def join_hulls(
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
        if pair.looks < MEASURED_TWICE:
            faces = _new_faces(pair.both, [left[number] for number in pair.numbers])
            too_far = tolerance if len(left) <= most else np.inf
            far = _excess(faces, surface, tolerance, too_far, pair.looks)
            pair.excess, pair.looks = max(pair.excess, far), pair.looks + 1
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
        np.array([getattr(other_hull, bound) for other_hull in hulls.values()])
        for bound in ("min_bound", "max_bound")
    )
    touch = (
        np.maximum(lows, hull.min_bound) <= np.minimum(highs, hull.max_bound) + TOUCHING_WITHIN
    ).all(1)
    for k in np.flatnonzero(touch).tolist():
        other = hulls[numbers[k]]
        both = together(hull, other)
        gap = max(0.0, float((both.volume - hull.volume - other.volume) / both.area))
        yield _Pair(gap, (numbers[k], number), both)


def _new_faces(both: ConvexHull, parts: list[ConvexHull]) -> Floats:
    """The faces (n, 3, 3) [m] of a common hull that no part has."""
    is_new = np.ones(len(both.simplices), bool)
    for part in parts:
        is_on = outside(part, both.points) <= TOUCHING_WITHIN
        is_new &= ~is_on[both.simplices].all(axis=1)
    return both.points[both.simplices[is_new]]


def _excess(faces: Floats, surface: Surface, tolerance: float, too_far: float, look: int) -> float:
    """How far faces (n, 3, 3) [m] lie outside of a surface at most [m], the last look closest."""
    if not len(faces):
        return 0.0
    count = FIRST_POINTS if look < MEASURED_TWICE - 1 else points_for(area_of(faces), tolerance)
    return surface.farthest(points_on(faces, count)[0], NEAR_ENOUGH_SHARE * tolerance, too_far)[0]

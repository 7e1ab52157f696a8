"""The point of a set that lies farthest from triangles: compiled, over a tree of boxes.

Most points are dropped as soon as some triangle is nearer to them than the best distance.
"""

from dataclasses import dataclass
from typing import cast

import numpy as np
from numba import njit

from workbench.model.geometry import Bools, Floats, Ints

FIRST = cast(int, np.int64(0))
"""The number of a triangle, with a type: numba compiles a function anew for a plain 0."""

LEAF = 4
"""Triangles in a box that is not divided further."""

EQUALLY_NEAR = 1e-7
"""[m] Triangles whose distance differs by no more meet at the nearest place."""

ALMOST = 0.95
"""A point is the new farthest one only where the last is nearer than this share: of points about
as far the first counts, whatever the last digit is."""

BITS = 10
"""Of each coordinate, by which triangles are sorted along a curve that fills space."""

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class TriangleTree:
    """Triangles (n, 3, 3) [m] with normals (n, 3), and boxes around them.

    Boxes `low` and `high` (2 k, 3) [m]: box i goes around boxes 2 i and 2 i + 1, box k + j around
    the j-th `LEAF` triangles.
    """

    triangles: Floats
    normals: Floats
    low: Floats
    high: Floats


def tree_of(triangles: Floats, normals: Floats) -> TriangleTree:
    """The tree over triangles (n, 3, 3) [m] whose normals are (n, 3)."""
    order = np.argsort(_along_curve(triangles.mean(axis=1)), kind="stable")
    triangles, normals = np.ascontiguousarray(triangles[order]), normals[order]
    starts = np.arange(0, len(triangles), LEAF)
    leaves = 1 << int(np.ceil(np.log2(max(len(starts), 1))))
    low = np.full((2 * leaves, 3), np.inf)
    high = np.full((2 * leaves, 3), -np.inf)
    low[leaves : leaves + len(starts)] = np.minimum.reduceat(triangles.min(axis=1), starts)
    high[leaves : leaves + len(starts)] = np.maximum.reduceat(triangles.max(axis=1), starts)
    while leaves > 1:
        children, parents = slice(leaves, 2 * leaves), slice(leaves // 2, leaves)
        low[parents] = low[children].reshape(-1, 2, 3).min(axis=1)
        high[parents] = high[children].reshape(-1, 2, 3).max(axis=1)
        leaves //= 2
    return TriangleTree(triangles, np.ascontiguousarray(normals), low, high)


def farthest(
    tree: TriangleTree,
    points: Floats,
    bounds: Floats,
    may_be_inside: Bools,
    enough: float,
    too_far: float,
) -> tuple[float, int]:
    """How far the farthest of points lies outside at most [m], and which it is, nearly.

    Args:
        tree: of the triangles.
        points: (n, 3) [m]; of those that are about as far the first counts.
        bounds: (n,) [m] no point is farther than this.
        may_be_inside: (n,) such a point counts 0 where the nearest triangle looks away from it.
        enough: [m] distances below it are not found closer.
        too_far: [m] the search ends at a point that is farther.
    """
    order = np.argsort(-bounds, kind="stable")
    far, at = _farthest(
        tree.triangles,
        tree.normals,
        tree.low,
        tree.high,
        np.ascontiguousarray(points),
        bounds,
        may_be_inside,
        order,
        enough,
        too_far,
    )
    return float(far), int(at)


def _along_curve(points: Floats) -> Ints:
    """Numbers (n,) that are near for points (n, 3) that are near (Morton, 1966)."""
    low, high = points.min(axis=0), points.max(axis=0)
    cells = ((points - low) / np.maximum(high - low, 1e-12) * ((1 << BITS) - 1)).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(BITS):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return code


@njit(cache=True)
def _farthest(
    triangles: Floats,
    normals: Floats,
    low: Floats,
    high: Floats,
    points: Floats,
    bounds: Floats,
    may_be_inside: Bools,
    order: Ints,
    enough: float,
    too_far: float,
) -> tuple[float, int]:
    far, marked, at, unknown, last = 0.0, 0.0, order[0], 0.0, FIRST
    for i in order:
        limit = max(far, enough)
        if bounds[i] <= limit:
            unknown = max(unknown, float(bounds[i]))
            break
        away, side, last = _nearest(triangles, normals, low, high, points[i], limit, last)
        if away <= limit:
            unknown = max(unknown, away)
            continue
        if may_be_inside[i] and side <= 0.0:
            continue
        far = away
        if far > marked / ALMOST:
            marked, at = far, i
        if far > too_far:
            break
    return max(far, min(enough, unknown)), at


@njit(cache=True)
def _nearest(
    triangles: Floats,
    normals: Floats,
    low: Floats,
    high: Floats,
    point: Floats,
    limit: float,
    which: int,
) -> tuple[float, float, int]:
    """The distance [m] to the nearest triangle, or one within `limit`; its side; and which it is.

    The triangle `which` is tried first; if it is near, few boxes are opened.
    """
    best, side = _measure(triangles[which], normals[which], point)
    leaves = len(low) // 2
    stack = np.empty(64, np.int64)
    stack[0], size = 1, 1
    while size and best > limit:
        size -= 1
        node = stack[size]
        if _to_box(low[node], high[node], point) > best + EQUALLY_NEAR:
            continue
        if node < leaves:
            left, right = 2 * node, 2 * node + 1
            if _to_box(low[left], high[left], point) < _to_box(low[right], high[right], point):
                left, right = right, left
            stack[size], stack[size + 1] = left, right
            size += 2
            continue
        first = (node - leaves) * LEAF
        for k in range(first, min(first + LEAF, len(triangles))):
            away, turned = _measure(triangles[k], normals[k], point)
            # Where several meet, the one that looks most at the point, or away, tells its side.
            if away < best - EQUALLY_NEAR or (
                away <= best + EQUALLY_NEAR and abs(turned) > abs(side)
            ):
                side = turned
            if away < best:
                best, which = away, k
    return best, side, which


@njit(cache=True)
def _measure(triangle: Floats, normal: Floats, point: Floats) -> tuple[float, float]:
    """How far a point is from a triangle [m], and how far along its normal [m]."""
    off = _offset(triangle, point)
    return np.sqrt(_dot(off, off)), _dot(off, normal)


@njit(cache=True)
def _to_box(low: Floats, high: Floats, point: Floats) -> float:
    """The distance [m] of a point from a box; from one without anything it is infinite."""
    total = 0.0
    for k in range(3):
        off = max(low[k] - point[k], point[k] - high[k], 0.0)
        total += off * off
    return np.sqrt(total)


@njit(cache=True)
def _offset(triangle: Floats, point: Floats) -> Triple:
    """From the nearest place on a triangle to a point [m] (Ericson 2005, 5.1.5)."""
    ab, ac, ap = (
        _minus(triangle[1], triangle[0]),
        _minus(triangle[2], triangle[0]),
        _minus(point, triangle[0]),
    )
    d1, d2 = _dot(ab, ap), _dot(ac, ap)
    if d1 <= 0 and d2 <= 0:
        return ap
    bp = _minus(point, triangle[1])
    d3, d4 = _dot(ab, bp), _dot(ac, bp)
    if d3 >= 0 and d4 <= d3:
        return bp
    vc = d1 * d4 - d3 * d2
    if vc <= 0 and d1 >= 0 and d3 <= 0 and d1 > d3:
        return _from(ap, ab, ac, d1 / (d1 - d3), 0.0)
    cp = _minus(point, triangle[2])
    d5, d6 = _dot(ab, cp), _dot(ac, cp)
    if d6 >= 0 and d5 <= d6:
        return cp
    vb = d5 * d2 - d1 * d6
    if vb <= 0 and d2 >= 0 and d6 <= 0 and d2 > d6:
        return _from(ap, ab, ac, 0.0, d2 / (d2 - d6))
    va = d3 * d6 - d5 * d4
    if va <= 0 and d4 >= d3 and d5 >= d6 and d4 - d3 + d5 - d6 > 0:
        w = (d4 - d3) / (d4 - d3 + d5 - d6)
        return _from(ap, ab, ac, 1 - w, w)
    whole = va + vb + vc
    return _from(ap, ab, ac, vb / whole, vc / whole)


@njit(cache=True)
def _minus(a: Floats, b: Floats) -> Triple:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True)
def _from(ap: Triple, ab: Triple, ac: Triple, v: float, w: float) -> Triple:
    return (
        ap[0] - v * ab[0] - w * ac[0],
        ap[1] - v * ab[1] - w * ac[1],
        ap[2] - v * ab[2] - w * ac[2],
    )


@njit(cache=True)
def _dot(a: Triple | Floats, b: Triple | Floats) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]

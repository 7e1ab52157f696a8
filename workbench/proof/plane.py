"""Compiled: how much nearer two convex bodies may come, seen along the line between them.

Where the nearest points of two convex bodies are `d` apart, two planes across the line between
these points are `d` apart, with one body behind each.  What moves along the planes brings nothing
nearer, so that only motion along their normal counts.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.proof.sieve import Boxes, Chain, World

LOST = 1e-5
"""[m] By so much the nearest points that Coal tells may not be the nearest."""


@njit(cache=True)
def nearer(
    normal: Floats,
    k: int,
    first: int,
    second: int,
    common: int,
    chain: Chain,
    boxes: Boxes,
    world: World,
    spans: Floats,
    corners: Floats,
) -> float:  # pragma: no cover (compiled)
    """How much nearer [m] two convex bodies may come within a set of configurations.

    Args:
        normal: (3,) unit vector in the world, from the nearest point of the first to that of the
            second, at the middle of the set.
        k: which of the sets, an index.
        first: the one body, an index.
        second: the other one.
        common: the joint next to both that moves both, an index.
        chain: the joints.
        boxes: around all bodies.
        world: where things are at the middles, see `poses`.
        spans: (k, nq) [rad, m] how far each value is from that of its middle at most.
        corners: (k, p, m, nq) [rad, m]: the set is all sums of one point of each of p hulls of m
            corners, as differences from the middle.
    """
    _, blocks, count, _ = corners.shape
    total = LOST + _bent(normal, k, first, common, chain, boxes, world, spans)
    total += _bent(normal, k, second, common, chain, boxes, world, spans)
    for p in range(blocks):
        most = 0.0
        for m in range(count):
            change = corners[k, p, m]
            comes = _comes(normal, 1.0, k, first, common, chain, boxes, world, change)
            comes += _comes(normal, -1.0, k, second, common, chain, boxes, world, change)
            most = max(most, comes)
        total += most
    return float(total)


@njit(cache=True)
def _comes(
    normal: Floats,
    sign: float,
    k: int,
    b: int,
    common: int,
    chain: Chain,
    boxes: Boxes,
    world: World,
    change: Floats,
) -> float:  # pragma: no cover (compiled)
    """To first order, how far [m] the foremost point of the box around a body goes along a normal.

    A point x that joint j turns about its axis a through o goes d (a x (x - o)) n = d (x - o) c
    along n, with c = n x a: a linear function of x, whose largest value in a box is at a corner.
    """
    x, y, z, shift = 0.0, 0.0, 0.0, 0.0
    j = boxes.joints[b]
    while j != common and j != 0:
        d = sign * change[chain.columns[j]]
        a, o = world.axes[k, j], world.places[k, j]
        if chain.slides[j]:
            shift += d * (normal[0] * a[0] + normal[1] * a[1] + normal[2] * a[2])
        else:
            cx = d * (normal[1] * a[2] - normal[2] * a[1])
            cy = d * (normal[2] * a[0] - normal[0] * a[2])
            cz = d * (normal[0] * a[1] - normal[1] * a[0])
            x, y, z = x + cx, y + cy, z + cz
            shift -= cx * o[0] + cy * o[1] + cz * o[2]
        j = chain.parents[j]
    R, centre, half = world.turns[k, b], world.centres[k, b], boxes.halves[b]
    reach = 0.0
    for i in range(3):
        reach += half[i] * abs(x * R[0, i] + y * R[1, i] + z * R[2, i])
    return float(shift + x * centre[0] + y * centre[1] + z * centre[2] + reach)


@njit(cache=True)
def _bent(
    normal: Floats,
    k: int,
    b: int,
    common: int,
    chain: Chain,
    boxes: Boxes,
    world: World,
    spans: Floats,
) -> float:  # pragma: no cover (compiled)
    """How far [m] a body goes along a normal beyond the first order.

    The joints are turned one after the other, that nearest to the body first, each about its axis
    in the middle: then the body is within `moved` of where it was, which changes the first order
    by d |c| moved, and a turn by d leaves its tangent by d^2 / 2 times the distance from the axis.
    """
    moved, bent = 0.0, 0.0
    j = boxes.joints[b]
    while j != common and j != 0:
        d = spans[k, chain.columns[j]]
        if chain.slides[j]:
            moved += d
        elif d > 0.0:
            a = world.axes[k, j]
            square, along, across = 0.0, 0.0, 0.0
            for i in range(3):
                off = world.centres[k, b, i] - world.places[k, j, i]
                square += off * off
                along += off * a[i]
                across += normal[i] * a[i]
            away = np.sqrt(max(square - along * along, 0.0)) + boxes.radii[b]
            tilt = np.sqrt(max(1.0 - across * across, 0.0))
            bent += d * tilt * moved + d * d / 2 * (away + moved)
            moved += d * (away + moved)
        j = chain.parents[j]
    return bent

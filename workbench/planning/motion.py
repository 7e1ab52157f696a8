"""What the robot really does between waypoints, as curves, and the continuous check of them.

The controller interpolates all joints of an arm linearly and rounds the corners: within a
`zone` (a fraction of the neighbouring segments) it follows a parabola that touches both.  So a
motion is a chain of quadratic Bezier curves in joint space: straight pieces and corners.

A curve is proven clear by halving: at its middle no pair may be closer than its margin plus
the most that the rest of the curve can bring it nearer (`bounds`).  Where that cannot be told,
each half is looked at.  Below `RESOLUTION` of motion a state counts as itself.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.world import Contact, World

RESOLUTION = 0.0005
"""[m] Where a state is clear and no body moves further than this around it, it is not halved."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A quadratic Bezier curve in joint space: control points (3, n), after which waypoint."""

    points: Floats
    waypoint: int


def segment(start: Floats, end: Floats, waypoint: int = 0) -> Curve:
    """The straight curve between two configurations (n,)."""
    return Curve(np.array([start, (start + end) / 2, end]), waypoint)


def curves_of(path: Floats, zone: float) -> list[Curve]:
    """The curves that the controller makes of waypoints (m, n) with zones 0 <= zone < 0.5."""
    steps = np.diff(path, axis=0)
    last = len(steps) - 1
    curves: list[Curve] = []
    for k, step in enumerate(steps):
        start = path[k] if k == 0 else path[k] + zone * step
        end = path[k + 1] if k == last else path[k + 1] - zone * step
        curves.append(segment(start, end, k))
        if k < last and zone > 0:
            leave = path[k + 1] + zone * steps[k + 1]
            curves.append(Curve(np.array([end, path[k + 1], leave]), k))
    return curves


def first_contact(
    world: World,
    columns: Ints,
    base: Floats,
    curve: Curve,
    resolution: float = RESOLUTION,
    among: Ints | None = None,
) -> tuple[Contact, Floats] | None:
    """The first contact found along a curve of the joints `columns`, others standing at `base`.

    Only the pairs `among` are looked at, all that count in the phase when it is None.

    Returns:
        The contact and the arm's configuration (n,) there; None when the whole curve is clear.
    """
    contact, left = world.sweep(curve.points, columns, base, resolution, among)
    if contact is not None or left is None or len(left) == 0:
        return contact
    q, d = base.copy(), np.zeros(len(base))
    # Breadth first: what is in the way is mostly met by the coarse looks already.  A pair that
    # a look has cleared for the whole curve is not looked at again in its halves.
    pending: deque[tuple[Floats, Ints | None]] = deque([(curve.points, left)])
    while pending:
        points, left_open = pending.popleft()
        middle, span, left, right = halved(points)
        q[columns], d[columns] = middle, span
        met, unclear, move = world.look(q, d, left_open)
        if met is not None:
            return met, middle
        # Where the bound is finer than the resolution, what counts is the state itself.
        if len(unclear) and move > resolution:
            pending.append((left, unclear))
            pending.append((right, unclear))
    return None


@njit(cache=True)
def halved(points: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Middle of a quadratic Bezier curve (3, n), the most any joint leaves it, and both halves."""
    n = points.shape[1]
    middle, span = np.empty(n), np.empty(n)
    left, right = np.empty((3, n)), np.empty((3, n))
    for i in range(n):
        a, b, c = points[0, i], points[1, i], points[2, i]
        m = (a + 2.0 * b + c) / 4.0
        middle[i], span[i] = m, max(abs(a - m), abs(b - m), abs(c - m))
        left[0, i], left[1, i], left[2, i] = a, (a + b) / 2.0, m
        right[0, i], right[1, i], right[2, i] = m, (b + c) / 2.0, c
    return middle, span, left, right


def path_contact(
    world: World,
    columns: Ints,
    base: Floats,
    path: Floats,
    zone: float,
    resolution: float = RESOLUTION,
    among: Ints | None = None,
) -> tuple[Contact, Floats, int] | None:
    """The first contact along waypoints (m, n) as executed, with the waypoint before it."""
    return chain_contact(world, columns, base, curves_of(path, zone), resolution, among)


def chain_contact(
    world: World,
    columns: Ints,
    base: Floats,
    curves: Sequence[Curve],
    resolution: float = RESOLUTION,
    among: Ints | None = None,
) -> tuple[Contact, Floats, int] | None:
    """The first contact along a chain of curves, with the waypoint before it."""
    for curve in curves:
        found = first_contact(world, columns, base, curve, resolution, among)
        if found is not None:
            return (*found, curve.waypoint)
    return None

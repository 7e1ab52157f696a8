"""What the robot really does between waypoints, as curves, and the continuous check of them.

The controller interpolates all joints of an arm linearly and rounds the corners: within a
`zone` (a fraction of the neighbouring segments) it follows a parabola that touches both.  So a
motion is a chain of quadratic Bezier curves in joint space: straight pieces and corners.

A curve is proven clear by halving: at its middle no pair may be closer than its margin plus
the most that the rest of the curve can bring it nearer (`bounds`).  Where that cannot be told,
each half is looked at.  Below `RESOLUTION` of motion a state counts as itself.
"""

from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats
from workbench.planning.world import Contact, World

RESOLUTION = 0.0005
"""[m] Where a state is clear and no body moves further than this around it, it is not halved."""

WIRE_STEP = np.deg2rad(0.01)
"""Configurations travel in degrees with two decimals."""


def on_wire(q: Floats) -> Floats:
    """The nearest configuration that can be sent: whole hundredths of a degree [rad]."""
    return np.deg2rad(np.round(np.rad2deg(q), 2))


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A quadratic Bezier curve in joint space: control points (3, n), after which waypoint."""

    points: Floats
    waypoint: int


def segment(start: Floats, end: Floats, waypoint: int = 0) -> Curve:
    """The straight curve between two configurations (n,)."""
    return Curve(np.array([start, (start + end) / 2, end]), waypoint)


def curves_of(path: Floats, zone: float) -> list[Curve]:
    """The curves that the controller makes of waypoints (m, n) with corner zones 0 <= zone < 0.5."""
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
    world: World, columns: Floats, base: Floats, curve: Curve, resolution: float = RESOLUTION
) -> tuple[Contact, Floats] | None:
    """The first contact found along a curve of the joints `columns`, others standing at `base`.

    Returns:
        The contact and the arm's configuration (n,) there; None when the whole curve is clear.
    """
    q, d = base.copy(), np.zeros(len(base))
    pending = [curve.points]
    while pending:
        a, b, c = pending.pop()
        middle = (a + 2 * b + c) / 4
        span = np.maximum(np.maximum(np.abs(a - middle), np.abs(c - middle)), np.abs(b - middle))
        q[columns], d[columns] = middle, span
        contact = world.contact(q, d)
        if contact is None:
            continue
        if contact.distance < contact.margin:
            return contact, middle
        if contact.move <= resolution:
            # The bound is finer than the resolution; what counts is the state itself.
            contact = world.contact(q)
            if contact is not None:
                return contact, middle
            continue
        left, right = (a + b) / 2, (b + c) / 2
        pending.append(np.array([middle, right, c]))
        pending.append(np.array([a, left, middle]))
    return None


def path_contact(
    world: World, columns: Floats, base: Floats, path: Floats, zone: float
) -> tuple[Contact, Floats, int] | None:
    """The first contact along waypoints (m, n) as executed, with the waypoint before it."""
    for curve in curves_of(path, zone):
        found = first_contact(world, columns, base, curve)
        if found is not None:
            return (*found, curve.waypoint)
    return None

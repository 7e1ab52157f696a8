"""What the robot really does between waypoints, as curves, and the continuous check of them.

The controller interpolates all joints of an arm linearly.  Either it stops at every waypoint, or
it rounds the corners: within a `zone` (a fraction of the neighbouring segments) it follows a
parabola that touches both.  So a motion is a chain of quadratic Bezier curves in joint space:
straight pieces and corners.  A corner that the controller cannot round as asked is rounded less or
becomes a stop.  So where corners are rounded the sharp ones are checked as well, and where they are
wide roundings between the two.  One that is streamed cuts corners straight, from sample to sample,
by less than half of both segments (`bound_curves`).

A curve is proven clear by halving: at its middle no pair may be closer than its margin plus
the most that the rest of the curve can bring it nearer (`bounds`).  Where that is unknown,
each half is checked.  Below `RESOLUTION` of motion a state counts as itself.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.model.motion import MotionModel
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.world import World
from workbench.planning.compiled import njit_in_place

SHARP_CORNER = 0.02
"""[rad] Roundings of a corner at which no joint differs by more than this have none between."""

CHORDS = 4
"""Straight pieces that stand for a rounding.

The proof's triangles reach as far from the corner as these chords of the widest rounding: with more
of them a plan would be refused for a state between both.
"""

STREAMED_ZONE = 0.5
"""By less than this share of a segment a straight line between two samples cuts a corner."""

RESOLUTION = 0.0005
"""[m] Where a state is clear and no body moves further than this around it, it is not halved."""


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """A chain of quadratic Bezier curves in joint space.

    `points` (k, 3, n) [rad]: control points of each; `waypoints` (k,): index of the waypoint before
    each.
    """

    points: Floats
    waypoints: Ints


def segment(start: Floats, end: Floats) -> Curves:
    """The one straight curve between two configurations (n,) [rad]."""
    return Curves(np.array([[start, (start + end) / 2, end]]), np.zeros(1, np.int64))


def straight(path: Floats) -> Curves:
    """The linear motions from waypoint to waypoint (m, n) [rad]."""
    starts, ends = path[:-1], path[1:]
    return Curves(np.stack([starts, (starts + ends) / 2, ends], axis=1), np.arange(len(starts)))


def bound_curves(path: Floats, motion: MotionModel, zone: float) -> Curves:
    """All that a controller may make of waypoints (m, n) [rad], with a zone below 0.5.

    That is every linear motion from waypoint to waypoint, where it stops or a zone cannot be done;
    and every corner rounded, or cut straight where it is streamed, by as much as may be and by
    less, in steps of `SHARP_CORNER`.
    """
    if motion.corners == "stop" or zone <= 0 or len(path) < 3:
        return straight(path)
    wide, pieces = (STREAMED_ZONE, 1) if motion.corners == "streamed" else (zone, CHORDS)
    # A copy can be written to: read-only arrays would be compiled for once more.
    return Curves(*_walk(np.array(path), wide, pieces))


@njit(cache=True)
def _walk(path: Floats, wide: float, pieces: int) -> tuple[Floats, Ints]:
    """Curves of a path (m, n) [rad] and the waypoints before them; every corner in `pieces`."""
    last, n = len(path) - 1, path.shape[1]
    counts = np.zeros(last, np.int64)
    for k in range(1, last):
        turn = 0.0
        for i in range(n):
            turn = max(turn, abs(path[k - 1, i] - 2.0 * path[k, i] + path[k + 1, i]))
        # The middle of a parabola is a quarter of this from its corner, of a straight cut half.
        count = np.ceil(wide * turn / (SHARP_CORNER * (2.0 if pieces == 1 else 4.0)))
        counts[k - 1] = max(int(count), 1)
    total = last + pieces * counts.sum()
    points, waypoints = np.empty((total, 3, n)), np.empty(total, np.int64)
    at = 0
    for k in range(last):
        for i in range(n):
            a, b = path[k, i], path[k + 1, i]
            points[at, 0, i], points[at, 1, i], points[at, 2, i] = a, (a + b) / 2, b
        waypoints[at] = k
        at += 1
        # Each corner's after the linear motion that leads to it.
        for step in range(counts[k], 0, -1):
            share = wide * (step / counts[k])
            for piece in range(pieces):
                for i in range(n):
                    a, b = path[k, i], path[k + 1, i]
                    enter, leave = b + share * (a - b), b + share * (path[k + 2, i] - b)
                    start = _rounding(enter, b, leave, piece / pieces)
                    end = _rounding(enter, b, leave, (piece + 1) / pieces)
                    points[at, 0, i], points[at, 1, i] = start, (start + end) / 2
                    points[at, 2, i] = end
                waypoints[at] = k
                at += 1
    return points, waypoints


@njit_in_place
def _rounding(enter: float, corner: float, leave: float, t: float) -> float:
    """Where a joint is on a parabola about a corner, at a parameter from 0 to 1 [rad]."""
    rest = 1.0 - t
    return rest * rest * enter + t * t * leave + 2.0 * t * rest * corner


@njit(cache=True)
def halve_curve(points: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Middle of a quadratic Bezier curve (3, n) [rad], how far each joint leaves it, its halves."""
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
    among: Ints | None = None,
) -> tuple[Contact, Floats, int] | None:
    """The first contact along waypoints (m, n) [rad] as executed; see `chain_contact`."""
    curves = bound_curves(path, world.motion, world.policy.zone)
    return chain_contact(world, columns, base, curves, among=among)


def arm_contact(
    world: World, arm: str, path: Floats, among: Ints | None = None
) -> tuple[Contact, Floats, int] | None:
    """The first contact of an arm along its path (m, n) [rad], other arms at home."""
    columns = world.kinematics.columns[arm]
    return path_contact(world, columns, world.configuration({}), path, among)


def chain_contact(
    world: World,
    columns: Ints,
    base: Floats,
    curves: Curves,
    resolution: float = RESOLUTION,
    among: Ints | None = None,
) -> tuple[Contact, Floats, int] | None:
    """The first contact along a chain of curves of the joints `columns`, others at `base`.

    Only the pairs `among` are checked, all that count in the phase when it is None.

    Returns:
        The contact, the arm's configuration (n,) [rad] there, and the waypoint before it; None
        when all of the chain is clear.
    """
    first = 0
    while first < len(curves.points):
        swept = world.sweep(curves.points[first:], columns, base, resolution, among)
        stopped = first + swept.clear
        measured = first
        if len(swept.left):
            rest = curves.points[first:stopped]
            measured = stopped - world.count_parted(rest, columns, base, resolution, swept.left)
        for k in range(first, measured):
            found = _curve_contact(world, columns, base, curves.points[k], resolution, swept.left)
            if found is not None:
                return (*found, int(curves.waypoints[k]))
        if stopped == len(curves.points):
            return None
        found = swept.met or _curve_contact(
            world, columns, base, curves.points[stopped], resolution, among
        )
        if found is not None:
            return (*found, int(curves.waypoints[stopped]))
        first = stopped + 1
    return None


def _curve_contact(
    world: World,
    columns: Ints,
    base: Floats,
    points: Floats,
    resolution: float,
    among: Ints | None,
) -> tuple[Contact, Floats] | None:
    """The first contact along one curve (3, n), every state checked by Coal."""
    q, d = base.copy(), np.zeros(len(base))
    # Breadth first: what is in the way is mostly met by the coarse looks already.  A pair that
    # a look has cleared for the whole curve is not looked at again in its halves.
    pending: deque[tuple[Floats, Ints | None]] = deque([(points, among)])
    while pending:
        points, left_open = pending.popleft()
        middle, span, left, right = halve_curve(points)
        q[columns], d[columns] = middle, span
        met, unclear, move = world.look(q, d, left_open)
        if met is not None:
            return met, middle
        # Where the bound is finer than the resolution, what counts is the state itself.
        if len(unclear) and move > resolution:
            pending.append((left, unclear))
            pending.append((right, unclear))
    return None

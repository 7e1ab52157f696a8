"""Whether two arms can collide while each follows its own path, at any speed.

The check has two parameters, the progress of each arm.  It works as for one arm (`motion`), at the
state in the middle of both paths.  There each pair needs its margin plus a bound of how much nearer
the rest of both paths can bring it.  Otherwise the longer path is halved.
"""

from collections import deque
from dataclasses import dataclass
from itertools import product

import numpy as np

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.motion import RESOLUTION, halve_curve
from workbench.planning.collision.sweeping.look import IS_CLEAR
from workbench.planning.collision.sweeping.two_ways import ways_met
from workbench.planning.collision.world import World

MOST_LOOKS = 4_000
"""After this many looks the arms count as meeting: they come that close over a long way."""

MOST_OPEN = 1 << 18
"""Pairs left open by all looks together: there is room for this many."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmSweep:
    """The way of one arm: its name and the control points (k, 3, n) [rad] of its curves."""

    arm: str
    points: Floats


@dataclass(frozen=True, slots=True, eq=False)
class ArmContact:
    """Where two arms come too close: `q`, (n,) [rad] of each, and their curves, counted from 0."""

    contact: Contact
    q: tuple[Floats, Floats]
    curves: tuple[int, int]


def standing(arm: str, q: Floats) -> ArmSweep:
    """An arm that stays at `q` (n,) [rad]."""
    return ArmSweep(arm, np.array([[q, q, q]]))


def first_contact(
    world: World, base: Floats, first: ArmSweep, second: ArmSweep, resolution: float = RESOLUTION
) -> ArmContact | None:
    """The first place found where two arms come too close; None when there surely is none.

    Args:
        world: in a phase in which both arms may move; only pairs between the two are checked.
        base: whole configuration (nq,) of all other joints.
        first: the way of one arm.
        second: the way of the other.
        resolution: [m] see `motion`.
    """
    columns = [world.kinematics.columns[sweep.arm] for sweep in (first, second)]
    among = world.pairs.between(first.arm, second.arm)
    edges = world.edges(np.concatenate(columns), base, resolution, among)
    if edges is None or not edges.is_all:
        return _measure(world, base, first, second, resolution)
    scratch = edges.scratch._replace(open_pairs=np.empty(MOST_OPEN, np.int64))
    edges = edges._replace(scratch=scratch)
    found, curves, looks = ways_met(first.points, second.points, MOST_LOOKS, edges)
    world.checks += looks
    if found == IS_CLEAR:
        return None
    contact = world.contact(scratch.q, among) if found >= 0 else None
    contact = contact or world.nearest(scratch.q, among)
    ends = (scratch.q[columns[0]], scratch.q[columns[1]])
    return ArmContact(contact, ends, (int(curves[0]), int(curves[1])))


def _measure(
    world: World, base: Floats, first: ArmSweep, second: ArmSweep, resolution: float
) -> ArmContact | None:
    """As `first_contact`, every state checked by Coal: for bodies that are not convex."""
    q, d = base.copy(), np.zeros(len(base))
    columns = [world.kinematics.columns[sweep.arm] for sweep in (first, second)]
    pending: deque[tuple[tuple[Floats, Floats], tuple[int, int], Ints]] = deque()
    among = world.pairs.between(first.arm, second.arm)
    pending.append(((first.points, second.points), (0, 0), among))
    # Where arms meet they mostly do so where a way begins or ends.
    for a, b in product((0, -1), repeat=2):
        ends = (first.points[a, a], second.points[b, b])
        q[columns[0]], q[columns[1]] = ends
        contact, _, _ = world.look(q, d, among)
        if contact is not None:
            return ArmContact(contact, ends, (a % len(first.points), b % len(second.points)))
    looks = 0
    while pending:
        ways, starts, among = pending.popleft()
        middles, spans = [], []
        for way, column in zip(ways, columns, strict=True):
            middle, span = _middle(way)
            q[column], d[column] = middle, span
            middles.append(middle)
            spans.append(float(span.max()))
        contact, unclear, move = world.look(q, d, among)
        looks += 1
        at = (starts[0] + len(ways[0]) // 2, starts[1] + len(ways[1]) // 2)
        if contact is not None:
            return ArmContact(contact, (middles[0], middles[1]), at)
        if len(unclear) == 0 or move <= resolution:
            continue
        if looks > MOST_LOOKS:
            return ArmContact(world.nearest(q, unclear), (middles[0], middles[1]), at)
        longer = 0 if spans[0] >= spans[1] else 1
        way, start = ways[longer], starts[longer]
        if len(way) > 1:
            half = len(way) // 2
            parts = ((way[:half], start), (way[half:], start + half))
        else:
            _, _, left, right = halve_curve(way[0])
            parts = ((left[None], start), (right[None], start))
        for part, begin in parts:
            if longer == 0:
                pending.append(((part, ways[1]), (begin, starts[1]), unclear))
            else:
                pending.append(((ways[0], part), (starts[0], begin), unclear))
    return None


def _middle(points: Floats) -> tuple[Floats, Floats]:
    """A state in the middle of a chain of curves (k, 3, n), and the most any joint leaves it."""
    half = len(points) // 2
    middle = points[half, 0] if half else (points[0, 0] + 2.0 * points[0, 1] + points[0, 2]) / 4.0
    return middle, np.abs(points - middle).max(axis=(0, 1))

"""Compiled: where the boxes around bodies are, and which pairs these alone do not tell apart."""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Bools, Floats, Ints

ROUNDING = 1e-9
"""[m] What sums of floats may be off by."""

PARALLEL = 1e-3
"""Sine of an angle below which two edges count as parallel: their normal is badly known."""


class Chain(NamedTuple):
    """Joints as arrays, joint 0 being the world; parents come before children.

    `parents` (j,), `turns` (j, 3, 3) and `places` (j, 3) [m] of each joint in the one before,
    `axes` (j, 3), `slides` (j,): whether it is prismatic, `columns` (j,): its place in `q`.
    """

    parents: Ints
    turns: Floats
    places: Floats
    axes: Floats
    slides: Bools
    columns: Ints


class World(NamedTuple):
    """Where things are at configurations (k,).

    `turns` (k, b, 3, 3) and `centres` (k, b, 3) [m] are those of boxes, `places` (k, j, 3) [m] and
    `axes` (k, j, 3) those of joints.
    """

    turns: Floats
    centres: Floats
    places: Floats
    axes: Floats


class Boxes(NamedTuple):
    """Boxes around bodies: the joints (b,) that carry them, turns and centres in those.

    `turns` (b, 3, 3), `centres` (b, 3) [m], `halves` (b, 3) [m] half lengths, `radii` (b,) [m] of
    the balls around the bodies, which have the same centres.  `rounds` (b,) tells that a body fills
    the same space however its own joint is turned.
    """

    joints: Ints
    turns: Floats
    centres: Floats
    halves: Floats
    radii: Floats
    rounds: Bools


@njit(cache=True)
def poses(chain: Chain, boxes: Boxes, q: Floats) -> World:  # pragma: no cover (compiled)
    """Where everything is at configurations (k, nq) [rad, m].

    What Pinocchio's `forwardKinematics` gives, for many at once.
    """
    count, joints, bodies = len(q), len(chain.parents), len(boxes.joints)
    turns, centres = np.empty((count, bodies, 3, 3)), np.empty((count, bodies, 3))
    places, axes = np.zeros((count, joints, 3)), np.zeros((count, joints, 3))
    R, p = np.zeros((joints, 3, 3)), np.zeros((joints, 3))
    own, before = np.empty((3, 3)), np.empty((3, 3))
    for i in range(3):
        R[0, i, i] = 1.0
    for k in range(count):
        for j in range(1, joints):
            u, value = chain.parents[j], q[k, chain.columns[j]]
            x, y, z = chain.axes[j]
            _product(R[u], chain.turns[j], before)
            for i in range(3):
                p[j, i] = p[u, i]
                for m in range(3):
                    p[j, i] += R[u, i, m] * chain.places[j, m]
                axes[k, j, i] = before[i, 0] * x + before[i, 1] * y + before[i, 2] * z
                places[k, j, i] = p[j, i]
            if chain.slides[j]:
                for i in range(3):
                    p[j, i] += axes[k, j, i] * value
                    for m in range(3):
                        R[j, i, m] = before[i, m]
                continue
            sin, cos = np.sin(value), np.cos(value)  # Rodrigues
            rest = 1.0 - cos
            own[0, 0], own[0, 1], own[0, 2] = (
                cos + x * x * rest,
                x * y * rest - z * sin,
                x * z * rest + y * sin,
            )
            own[1, 0], own[1, 1], own[1, 2] = (
                y * x * rest + z * sin,
                cos + y * y * rest,
                y * z * rest - x * sin,
            )
            own[2, 0], own[2, 1], own[2, 2] = (
                z * x * rest - y * sin,
                z * y * rest + x * sin,
                cos + z * z * rest,
            )
            _product(before, own, R[j])
        for b in range(bodies):
            j = boxes.joints[b]
            _product(R[j], boxes.turns[b], turns[k, b])
            for i in range(3):
                centres[k, b, i] = p[j, i]
                for m in range(3):
                    centres[k, b, i] += R[j, i, m] * boxes.centres[b, m]
    return World(turns, centres, places, axes)


@njit(cache=True)
def _product(A: Floats, B: Floats, C: Floats) -> None:  # pragma: no cover (compiled)
    """Write A B into C, all (3, 3)."""
    for i in range(3):
        for j in range(3):
            C[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@njit(cache=True)
def gap(
    Ra: Floats, ca: Floats, ha: Floats, Rb: Floats, cb: Floats, hb: Floats
) -> float:  # pragma: no cover (compiled)
    """A lower bound [m] of the distance of two boxes, negative when they may overlap.

    They are `R` (3, 3), `c` (3,) [m], `h` (3,) [m].  It is the largest gap along the axes of both
    and the nine normals to two of them: boxes that are apart are apart along one of these.
    """
    between = cb - ca
    best = -np.inf
    for i in range(3):
        for own in range(2):
            R = Ra if own == 0 else Rb
            x, y, z = R[0, i], R[1, i], R[2, i]
            best = max(best, _along(x, y, z, between, Ra, ha, Rb, hb))
    for i in range(3):
        for j in range(3):
            x = Ra[1, i] * Rb[2, j] - Ra[2, i] * Rb[1, j]
            y = Ra[2, i] * Rb[0, j] - Ra[0, i] * Rb[2, j]
            z = Ra[0, i] * Rb[1, j] - Ra[1, i] * Rb[0, j]
            norm = np.sqrt(x * x + y * y + z * z)
            if norm > PARALLEL:
                x, y, z = x / norm, y / norm, z / norm
                best = max(best, _along(x, y, z, between, Ra, ha, Rb, hb))
    return float(best)


@njit(cache=True)
def _along(
    x: float, y: float, z: float, between: Floats, Ra: Floats, ha: Floats, Rb: Floats, hb: Floats
) -> float:  # pragma: no cover (compiled)
    """The gap of two boxes along a unit direction."""
    reach = 0.0
    for i in range(3):
        reach += abs(x * Ra[0, i] + y * Ra[1, i] + z * Ra[2, i]) * ha[i]
        reach += abs(x * Rb[0, i] + y * Rb[1, i] + z * Rb[2, i]) * hb[i]
    return float(abs(x * between[0] + y * between[1] + z * between[2]) - reach)


@njit(cache=True)
def _moved(
    k: int, b: int, common: int, chain: Chain, boxes: Boxes, world: World, spans: Floats
) -> float:  # pragma: no cover (compiled)
    """How far [m] no point of a body gets from where it is, against joint `common`.

    The joints between are turned one after the other, that nearest to the body first, each by up to
    `spans` (k, nq): its axis is still where it was, and the body within `moved` of where it was.
    """
    moved = 0.0
    j = boxes.joints[b]
    while j != common and j != 0:
        span = spans[k, chain.columns[j]]
        if chain.slides[j]:
            moved += span
        elif span > 0.0 and not (boxes.rounds[b] and j == boxes.joints[b]):
            square, along = 0.0, 0.0
            for i in range(3):
                off = world.centres[k, b, i] - world.places[k, j, i]
                square += off * off
                along += off * world.axes[k, j, i]
            away = np.sqrt(max(square - along * along, 0.0)) + boxes.radii[b]
            moved += span * (away + moved)
        j = chain.parents[j]
    return moved


@njit(cache=True)
def lower_to(
    bounds: Floats, at: Ints, values: Floats, counts: Bools
) -> None:  # pragma: no cover (compiled)
    """Lower bounds (w,) [m] to those of the values (n,) [m] at places (n,) that count (n,)."""
    for n in range(len(at)):
        if counts[n] and values[n] < bounds[at[n]]:
            bounds[at[n]] = values[n]


@njit(cache=True)
def sieve(
    items: Ints,
    first: Ints,
    second: Ints,
    commons: Ints,
    needs: Floats,
    spans: Floats,
    chain: Chain,
    boxes: Boxes,
    world: World,
) -> tuple[Floats, Floats]:  # pragma: no cover (compiled)
    """How far pairs are apart at least, and how much nearer they may come: (n,) [m] each.

    Args:
        items: (n,) at which of the configurations, an index.
        first: (n,) the one body, an index.
        second: (n,) the other one.
        commons: (n,) the joint next to both that moves both, an index.
        needs: (n,) [m] what is enough when nearness is taken off; then boxes are not looked at.
        spans: (k, nq) [rad, m] how far each value is from that of its configuration.
        chain: the joints.
        boxes: around all bodies.
        world: see `poses`.
    """
    lower, moves = np.empty(len(items)), np.empty(len(items))
    most = np.empty((len(spans), len(boxes.joints)))
    for k in range(len(spans)):
        for b in range(len(boxes.joints)):
            most[k, b] = _moved(k, b, 0, chain, boxes, world, spans)
    for n in range(len(items)):
        k, a, b = items[n], first[n], second[n]
        if commons[n] == 0:
            moves[n] = most[k, a] + most[k, b]
        else:
            moves[n] = _moved(k, a, commons[n], chain, boxes, world, spans)
            moves[n] += _moved(k, b, commons[n], chain, boxes, world, spans)
        square = 0.0
        for i in range(3):
            off = world.centres[k, a, i] - world.centres[k, b, i]
            square += off * off
        lower[n] = np.sqrt(square) - boxes.radii[a] - boxes.radii[b] - ROUNDING
        if lower[n] - moves[n] < needs[n]:
            apart = gap(
                world.turns[k, a], world.centres[k, a], boxes.halves[a],
                world.turns[k, b], world.centres[k, b], boxes.halves[b],
            )  # fmt: skip
            lower[n] = max(lower[n], apart - ROUNDING)
    return lower, moves

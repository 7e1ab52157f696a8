"""Compiled: where all bodies are at many configurations, and how far each may get from there."""

from typing import NamedTuple, cast

import numpy as np
from numba import njit

from workbench.model.geometry import Bools, Floats, Ints
from workbench.proof.engine.compiled import njit_in_place

FIRST = cast(int, np.int64(0))
"""The number of a state or joint, with a type: numba compiles a function anew for a plain 0."""


class JointTree(NamedTuple):
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


class Bodies(NamedTuple):
    """Bodies as arrays; each body is a hull of points, thickened by a box, a disc and a ball.

    Attributes:
        joints: joints that carry the bodies (b,).
        turns: rotations of the bodies in the joints' frames (b, 3, 3).
        centres: centres of the bodies in the joints' frames (b, 3) [m].
        halves: half lengths of the boxes around the bodies (b, 3) [m].
        radii: radii of the balls around the bodies (b,) [m].
        rounds: whether a body fills the same space at any angle of its own joint (b,).
        points: points of all hulls, seen from the centres (m, 3) [m].
        starts: the points of body b run from `starts[b]` to `starts[b + 1]`.
        boxes: half lengths of the box at each point (b, 3) [m].
        discs: radius of the disc across z at each point (b,) [m].
        balls: radius of the ball at each point (b,) [m].
    """

    joints: Ints
    turns: Floats
    centres: Floats
    halves: Floats
    radii: Floats
    rounds: Bools
    points: Floats
    starts: Ints
    boxes: Floats
    discs: Floats
    balls: Floats


class BodyPoses(NamedTuple):
    """Poses of all bodies and joints at configurations (k,).

    `turns` (k, b, 3, 3) and `centres` (k, b, 3) [m] are those of bodies.  `places` (k, j, 3) [m]
    and `axes` (k, j, 3) are those of joints.  `moves` (k, b) [m] bounds the motion of a body.
    """

    turns: Floats
    centres: Floats
    places: Floats
    axes: Floats
    moves: Floats


class SetExtents(NamedTuple):
    """Sets of configurations (k,) around their middles.

    `spans` (k, nq) [rad, m]: how far each value is from that of the middle at most; `changes`
    (k, c, nq) [rad, m], of which the first `counts` (k,) count: a set is their hull.
    """

    spans: Floats
    changes: Floats
    counts: Ints


@njit_in_place
def max_distance_to_axis(
    k: int, b: int, j: int, bodies: Bodies, world: BodyPoses
) -> float:  # pragma: no cover
    """An upper bound [m] of the distance from any point of a body to the axis of a joint."""
    square, along = 0.0, 0.0
    for i in range(3):
        off = world.centres[k, b, i] - world.places[k, j, i]
        square += off * off
        along += off * world.axes[k, j, i]
    return float(np.sqrt(max(square - along * along, 0.0)) + bodies.radii[b])


@njit_in_place
def bound_motion(
    k: int, b: int, common: int, chain: JointTree, bodies: Bodies, world: BodyPoses, spans: Floats
) -> float:  # pragma: no cover (compiled)
    """An upper bound [m] of how far any point of a body moves, against joint `common`.

    The joints between are turned one after the other, that nearest to the body first, each by up to
    `spans` (k, nq): its axis is still where it was, and the body within `far` of where it was.
    """
    far, j = 0.0, int(bodies.joints[b])
    while j != common and j != 0:
        span = spans[k, chain.columns[j]]
        if chain.slides[j]:
            far += span
        elif span > 0.0 and not (bodies.rounds[b] and j == bodies.joints[b]):
            far += span * (max_distance_to_axis(k, b, j, bodies, world) + far)
        j = int(chain.parents[j])
    return far


@njit(cache=True)
def poses(
    chain: JointTree, bodies: Bodies, q: Floats, spans: Floats, needed: Bools
) -> BodyPoses:  # pragma: no cover (compiled)
    """Where bodies are at configurations (k, nq) [rad, m], with `spans` around them (k, nq).

    What Pinocchio's `forwardKinematics` gives, for many at once.  Of bodies that are not `needed`
    (b,) nothing is reported.
    """
    some = np.flatnonzero(needed)
    count, joints, number = len(q), len(chain.parents), len(bodies.joints)
    turns, centres = np.empty((count, number, 3, 3)), np.empty((count, number, 3))
    places, axes = np.zeros((count, joints, 3)), np.zeros((count, joints, 3))
    world = BodyPoses(turns, centres, places, axes, np.empty((count, number)))
    R, p = np.zeros((joints, 3, 3)), np.zeros((joints, 3))
    own, before = np.empty((3, 3)), np.empty((3, 3))
    for i in range(3):
        R[0, i, i] = 1.0
    _place(chain, bodies, q, spans, some, world, R, p, own, before)
    return world


@njit_in_place
def _place(
    chain: JointTree,
    bodies: Bodies,
    q: Floats,
    spans: Floats,
    some: Ints,
    world: BodyPoses,
    R: Floats,
    p: Floats,
    own: Floats,
    before: Floats,
) -> None:  # pragma: no cover (compiled)
    """Write what `poses` returns of the bodies `some` (n,), by index, into `world`.

    `R` (j, 3, 3) and `p` (j, 3) [m] are written to, those of joint 0 are known; so are `own` and
    `before` (3, 3), without a unit.
    """
    axes = world.axes
    for k in range(len(q)):
        for j in range(1, len(chain.parents)):
            u, value = chain.parents[j], q[k, chain.columns[j]]
            x, y, z = chain.axes[j, 0], chain.axes[j, 1], chain.axes[j, 2]
            _product(R[u], chain.turns[j], before)
            for i in range(3):
                p[j, i] = p[u, i]
                for m in range(3):
                    p[j, i] += R[u, i, m] * chain.places[j, m]
                axes[k, j, i] = before[i, 0] * x + before[i, 1] * y + before[i, 2] * z
                world.places[k, j, i] = p[j, i]
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
        for b in some:
            j = bodies.joints[b]
            _product(R[j], bodies.turns[b], world.turns[k, b])
            for i in range(3):
                world.centres[k, b, i] = p[j, i]
                for m in range(3):
                    world.centres[k, b, i] += R[j, i, m] * bodies.centres[b, m]
    for k in range(len(q)):
        for b in some:
            world.moves[k, b] = bound_motion(k, int(b), FIRST, chain, bodies, world, spans)


@njit_in_place
def _product(A: Floats, B: Floats, C: Floats) -> None:  # pragma: no cover (compiled)
    """Write A B into C, all (3, 3)."""
    for i in range(3):
        for j in range(3):
            C[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@njit(cache=True)
def levers(
    chain: JointTree, bodies: Bodies, world: BodyPoses
) -> Floats:  # pragma: no cover (compiled)
    """How far [m/rad, m/m] each value moves the farthest body in the first world: about (nq,)."""
    most = np.zeros(len(chain.columns) - 1)
    for b in range(len(bodies.joints)):
        j = int(bodies.joints[b])
        while j != 0:
            lever = 1.0 if chain.slides[j] else max_distance_to_axis(FIRST, b, j, bodies, world)
            most[chain.columns[j]] = max(most[chain.columns[j]], lever)
            j = int(chain.parents[j])
    return most

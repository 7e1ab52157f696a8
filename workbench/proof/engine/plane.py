"""Compiled: how far two bodies are apart at least, seen along one direction.

Two planes across any direction, one touching each body, with both bodies behind them: how far these
planes are apart is a lower bound of the distance, however the direction was found.  What moves
along the planes brings nothing nearer, so that only motion along the direction counts.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.proof.engine.compiled import njit_in_place
from workbench.proof.engine.frames import (
    Bodies,
    BodyPoses,
    JointTree,
    SetExtents,
    max_distance_to_axis,
)

ROUNDING = 1e-9
"""[m] What sums of floats may be off by."""


@njit_in_place
def apart(
    normal: Floats,
    ka: int,
    a: int,
    kb: int,
    b: int,
    common: int,
    chain: JointTree,
    bodies: Bodies,
    world: BodyPoses,
    spread: SetExtents,
) -> float:  # pragma: no cover (compiled)
    """How far [m] two bodies stay apart along a direction, each in a whole set of configurations.

    Args:
        normal: (3,) unit vector in the world, from the one towards the other.
        ka: in which of the sets the one is, an index.
        a: the one body, an index.
        kb: in which of the sets the other is.
        b: the other body.
        common: the joint next to both that moves both, an index.
        chain: the joints.
        bodies: all bodies.
        world: where things are at the middles, see `poses`.
        spread: the sets.
    """
    reach = _reach(normal, 1.0, ka, a, common, chain, bodies, world, spread)
    reach += _reach(normal, -1.0, kb, b, common, chain, bodies, world, spread)
    return -reach - ROUNDING


# Called, it would be handed some thirty arrays, which takes longer than what it does.
@njit(cache=True, inline="always")
def _reach(
    normal: Floats,
    sign: float,
    k: int,
    b: int,
    common: int,
    chain: JointTree,
    bodies: Bodies,
    world: BodyPoses,
    spread: SetExtents,
) -> float:  # pragma: no cover (compiled)
    """A bound [m] of a body's reach along a normal n, or against it by its `sign`.

    Joint j rotates a point x by d about its axis a through o.  To first order x moves along n by
    d (a x (x - o)) n = d (x - o) c, with c = n x a.  So the first-order reach is that of the body
    in a direction a little off n.  It is linear in d, hence largest at a corner of the set.

    The rest is bounded joint by joint, from the body inwards, each about its axis in the middle
    of the set.  The body is then within `far` of its place.  This changes the first order by
    d |c| far.  A rotation by d leaves its tangent by d^2 / 2 times the distance from the axis.
    """
    best = -np.inf
    nx, ny, nz = sign * normal[0], sign * normal[1], sign * normal[2]
    R, centre = world.turns[k, b], world.centres[k, b]
    for m in range(spread.counts[k] if world.moves[k, b] > 0.0 else 1):
        x, y, z, shift = nx, ny, nz, 0.0
        j = int(bodies.joints[b])
        while j != common and j != 0:
            d = spread.changes[k, m, chain.columns[j]]
            a, o = world.axes[k, j], world.places[k, j]
            if chain.slides[j]:
                shift += d * (nx * a[0] + ny * a[1] + nz * a[2])
            else:
                cx = d * (ny * a[2] - nz * a[1])
                cy = d * (nz * a[0] - nx * a[2])
                cz = d * (nx * a[1] - ny * a[0])
                x, y, z = x + cx, y + cy, z + cz
                shift -= cx * o[0] + cy * o[1] + cz * o[2]
            j = int(chain.parents[j])
        shift += x * centre[0] + y * centre[1] + z * centre[2]
        best = max(best, shift + _support(x, y, z, R, b, bodies))
    far, bent, j = 0.0, 0.0, int(bodies.joints[b])
    while j != common and j != 0:
        d = spread.spans[k, chain.columns[j]]
        if chain.slides[j]:
            far += d
        elif d > 0.0:
            a = world.axes[k, j]
            across = nx * a[0] + ny * a[1] + nz * a[2]
            tilt = np.sqrt(max(1.0 - across * across, 0.0))
            off = max_distance_to_axis(k, b, j, bodies, world)
            bent += d * tilt * far + d * d / 2 * (off + far)
            far += d * (off + far)
        j = int(chain.parents[j])
    return float(best + bent)


@njit_in_place
def _support(
    x: float, y: float, z: float, R: Floats, b: int, bodies: Bodies
) -> float:  # pragma: no cover (compiled)
    """How far [m] a body, seen from its centre, reaches along a vector, times its length."""
    u = R[0, 0] * x + R[1, 0] * y + R[2, 0] * z
    v = R[0, 1] * x + R[1, 1] * y + R[2, 1] * z
    w = R[0, 2] * x + R[1, 2] * y + R[2, 2] * z
    most = -np.inf
    for n in range(bodies.starts[b], bodies.starts[b + 1]):
        p = bodies.points[n]
        most = max(most, p[0] * u + p[1] * v + p[2] * w)
    box, disc, ball = bodies.boxes[b], bodies.discs[b], bodies.balls[b]
    most += box[0] * abs(u) + box[1] * abs(v) + box[2] * abs(w)
    return float(most + disc * np.sqrt(u * u + v * v) + ball * np.sqrt(u * u + v * v + w * w))

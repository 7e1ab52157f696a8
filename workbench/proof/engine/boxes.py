"""Compiled: how far the boxes around two bodies are apart, and along what."""

import numpy as np

from workbench.model.geometry import Floats
from workbench.proof.engine.compiled import njit_in_place
from workbench.proof.engine.frames import FIRST, Bodies, BodyPoses

PARALLEL = 1e-3
"""Sine of an angle below which two edges count as parallel: their normal is badly known."""


@njit_in_place
def gap(
    ka: int,
    a: int,
    kb: int,
    b: int,
    bodies: Bodies,
    world: BodyPoses,
    enough: float,
    axis: Floats,
    scratch: Floats,
) -> float:  # pragma: no cover (compiled)
    """A lower bound [m] of the distance of the boxes around two bodies; negative: may overlap.

    It is the largest gap along the axes of both and the nine normals to two of them: boxes that
    are apart are apart along one of these.

    Args:
        ka: at which configuration the one is, an index.
        a: the one body.
        kb: at which configuration the other is.
        b: the other body.
        bodies: all bodies.
        world: where they are.
        enough: [m] nothing larger is searched for.
        axis: (3,) becomes the direction of the gap in the world, from the one to the other.
        scratch: (4, 3) is written to: the axes of the other and the way to it, as the one sees
            them.
    """
    Ra, Rb = world.turns[ka, a], world.turns[kb, b]
    ha, hb = bodies.halves[a], bodies.halves[b]
    best, first, second = -np.inf, FIRST, FIRST
    for i in range(3):
        for j in range(3):
            scratch[j, i] = Ra[0, i] * Rb[0, j] + Ra[1, i] * Rb[1, j] + Ra[2, i] * Rb[2, j]
        scratch[3, i] = 0.0
        for m in range(3):
            scratch[3, i] += Ra[m, i] * (world.centres[kb, b, m] - world.centres[ka, a, m])
    way = scratch[3]
    for i in range(3):
        far = abs(way[i]) - ha[i]
        for j in range(3):
            far -= hb[j] * abs(scratch[j, i])
        if far > best:
            best, first, second = far, i, 3
    for j in range(3):
        other, along = scratch[j], 0.0
        far = -hb[j]
        for i in range(3):
            along += way[i] * other[i]
            far -= ha[i] * abs(other[i])
        far += abs(along)
        if far > best:
            best, first, second = far, 3, j
    for i in range(3 if best < enough else 0):
        u, v = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            other = scratch[j]
            norm = np.sqrt(other[u] * other[u] + other[v] * other[v])
            if norm > PARALLEL:
                far = abs(way[v] * other[u] - way[u] * other[v])
                far -= ha[u] * abs(other[v]) + ha[v] * abs(other[u])
                far -= hb[(j + 1) % 3] * abs(scratch[(j + 2) % 3, i])
                far -= hb[(j + 2) % 3] * abs(scratch[(j + 1) % 3, i])
                if far / norm > best:
                    best, first, second = far / norm, i, j
    _towards(Ra, Rb, first, second, way, axis)
    return float(best)


@njit_in_place
def _towards(
    Ra: Floats, Rb: Floats, first: int, second: int, way: Floats, axis: Floats
) -> None:  # pragma: no cover (compiled)
    """Write the unit vector along one axis of both, or across two, from the one to the other."""
    for i in range(3):
        u, v = (i + 1) % 3, (i + 2) % 3
        if second == 3:
            axis[i] = Ra[i, first]
        elif first == 3:
            axis[i] = Rb[i, second]
        else:
            axis[i] = Ra[u, first] * Rb[v, second] - Ra[v, first] * Rb[u, second]
    along, square = 0.0, 0.0
    for i in range(3):
        square += axis[i] * axis[i]
        for m in range(3):
            along += axis[m] * Ra[m, i] * way[i]
    factor = (1.0 if along > 0.0 else -1.0) / np.sqrt(square)
    for i in range(3):
        axis[i] *= factor

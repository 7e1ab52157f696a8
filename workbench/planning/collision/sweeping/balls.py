"""Pairs of which one body is a ball: how far apart they are has a formula.

The distance of a point from a ball, a box or an upright cylinder, less the ball's radius: exact, so
that there is nothing to bound and nothing to search.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.planning.collision.gjk import BALL, BOX, OTHER, Cores


@njit(cache=True)
def has_formula(a: int, b: int, cores: Cores) -> bool:
    """Whether `ball_gap` knows the distance of bodies a and b."""
    one, other = cores.form[a], cores.form[b]
    return (one == BALL and other != OTHER) or (other == BALL and one != OTHER)


@njit(cache=True)
def ball_gap(a: int, b: int, R: Floats, c: Floats, half: Floats, cores: Cores) -> float:
    """Distance [m] of two bodies, one of which is a ball; where they overlap, not above zero.

    Args:
        a: a ball, or else b is one.
        b: a ball, a box or a cylinder; see `has_formula`.
        R: rotations (b, 3, 3) of all bodies.
        c: centres (b, 3) of all bodies [m].
        half: half sizes (b, 3) of their boxes [m].
        cores: of all bodies.
    """
    if cores.form[a] != BALL:
        a, b = b, a
    x, y, z = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
    swell = cores.swell[a] + cores.swell[b]
    if cores.form[b] == BALL:
        return float(np.sqrt(x * x + y * y + z * z) - swell)
    u = R[b, 0, 0] * x + R[b, 1, 0] * y + R[b, 2, 0] * z
    v = R[b, 0, 1] * x + R[b, 1, 1] * y + R[b, 2, 1] * z
    w = R[b, 0, 2] * x + R[b, 1, 2] * y + R[b, 2, 2] * z
    if cores.form[b] == BOX:
        u, v, w = abs(u) - half[b, 0], abs(v) - half[b, 1], abs(w) - half[b, 2]
    else:
        u = np.sqrt(u * u + v * v) - cores.radius[b]
        v, w = -1e9, abs(w) - cores.length[b]
    inside = max(u, v, w)
    if inside <= 0.0:
        return float(inside - swell)
    u, v, w = max(u, 0.0), max(v, 0.0), max(w, 0.0)
    return float(np.sqrt(u * u + v * v + w * w) - swell)

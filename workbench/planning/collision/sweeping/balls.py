"""Pairs of which one body is a ball: how far apart they are has a formula.

The distance of a point from a ball, a box or an upright cylinder, less the ball's radius: exact, so
that there is nothing to bound and nothing to search.
"""

import numpy as np

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.distances.cores import BALL, BOX, OTHER
from workbench.planning.compiled import njit_in_place


@njit_in_place
def has_formula(a: int, b: int, form: Ints) -> bool:
    """Whether `ball_gap` knows the distance of bodies a and b; `form` (b,) has no unit."""
    first, second = form[a], form[b]
    return (first == BALL and second != OTHER) or (second == BALL and first != OTHER)


@njit_in_place
def ball_gap(
    a: int,
    b: int,
    R: Floats,
    c: Floats,
    half: Floats,
    form: Ints,
    grown: Floats,
    radius: Floats,
    length: Floats,
    normal: Floats,
) -> float:
    """Distance [m] of two bodies, one of which is a ball; where they overlap, not above zero.

    Where they do not, the direction of that distance is written to `normal`.

    Args:
        a: a ball, or else b is one.
        b: a ball, a box or a cylinder; see `has_formula`.
        R: rotations (b, 3, 3) of all bodies.
        c: centres (b, 3) of all bodies [m].
        half: half sizes (b, 3) of their boxes [m].
        form: of all bodies (b,), see `Cores`.
        grown: swell of all bodies (b,) [m].
        radius: of cylinders (b,) [m].
        length: of cylinders (b,), half [m].
        normal: (3,), no unit.
    """
    if form[a] != BALL:
        a, b = b, a
    x, y, z = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
    swell = grown[a] + grown[b]
    if form[b] == BALL:
        far = np.sqrt(x * x + y * y + z * z)
        if far > 0.0:
            normal[0], normal[1], normal[2] = x / far, y / far, z / far
        return float(far - swell)
    u = R[b, 0, 0] * x + R[b, 1, 0] * y + R[b, 2, 0] * z
    v = R[b, 0, 1] * x + R[b, 1, 1] * y + R[b, 2, 1] * z
    w = R[b, 0, 2] * x + R[b, 1, 2] * y + R[b, 2, 2] * z
    if form[b] == BOX:
        i, j, k = abs(u) - half[b, 0], abs(v) - half[b, 1], abs(w) - half[b, 2]
        inside = max(i, j, k)
        i, j = max(i, 0.0) * np.sign(u), max(j, 0.0) * np.sign(v)
    else:
        flat = np.sqrt(u * u + v * v)
        i, k = flat - radius[b], abs(w) - length[b]
        inside = max(i, k)
        out = max(i, 0.0) / max(flat, 1e-12)
        i, j = out * u, out * v
    if inside <= 0.0:
        return float(inside - swell)
    k = max(k, 0.0) * np.sign(w)
    far = np.sqrt(i * i + j * j + k * k)
    i, j, k = i / far, j / far, k / far
    for m in range(3):
        normal[m] = R[b, m, 0] * i + R[b, m, 1] * j + R[b, m, 2] * k
    return float(far - swell)

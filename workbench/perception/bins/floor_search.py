"""The floor in a scan of which nobody knows where its scanner hangs, and whose bin has no rim.

The floor is the plane on which many points lie and behind which there are next to none: nothing is
seen through it.
"""

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.geometry import Floats, Ints

MOST_POINTS, PLANES_TRIED = 4_000, 6_000
"""Points that are checked, and planes that are tried."""

PLANE_WITHIN = 0.006
"""[m] A point this near to a plane lies on it: floors of cartons are bent."""

GATES = (0.006, 0.006, 0.004, 0.003, 0.003)
"""[m] The same, step by step, once the floor is known: what lies on it would tilt it."""

BEHIND = 2.0
"""What a point behind the plane counts against one on it."""

LEAST_SHARE = 0.02
"""Share of the points that a floor has at least, after those behind it are taken off."""

FLOOR_COSINE = float(np.cos(np.deg2rad(45.0)))
"""Cosine to the scanner's axis: what it looks along more than at is a wall."""

OUTLYING = 1.0
"""[percent] Of the points on the floor may lie further out than its sides, at each end."""


def find_floor(points: Floats) -> tuple[pin.SE3, Floats] | None:
    """The floor in a scan, None where there is none.

    Args:
        points: (n, 3) [m] in the scanner's frame.

    Returns:
        A frame in the middle of what is seen over the floor, z towards the scanner and x along the
        scanner's own; and the sides (2,) [m] of what is seen, along x and y.
    """
    few = np.ascontiguousarray(points[:: max(1, len(points) // MOST_POINTS)])
    if len(few) < 3:
        return None
    drawn = np.random.default_rng(0).integers(len(few), size=(PLANES_TRIED, 3))
    normal, height, value = _search(few, drawn, PLANE_WITHIN, FLOOR_COSINE)
    if value < LEAST_SHARE * len(few):
        return None
    for gate in GATES:
        on = np.abs(few @ normal - height) < gate
        middle = few[on].mean(axis=0)
        normal = np.linalg.svd(few[on] - middle, full_matrices=False)[2][2]
        normal = normal if normal @ middle < 0 else -normal
        height = float(normal @ middle)
    x = np.array([1.0, 0.0, 0.0]) - normal * normal[0]
    x = x / np.linalg.norm(x)
    y = np.cross(normal, x)
    low, high = np.percentile(points @ np.stack([x, y]).T, (OUTLYING, 100 - OUTLYING), axis=0)
    middle = (low + high) / 2 @ np.stack([x, y]) + height * normal
    return pin.SE3(np.stack([x, y, normal], axis=1), middle), high - low


@njit(cache=True)
def _search(
    points: Floats, drawn: Ints, gate: float, steepest: float
) -> tuple[Floats, float, float]:  # pragma: no cover (compiled)
    """Normal towards the scanner, offset along it [m], and value of the best plane."""
    best, height, most = np.zeros(3), 0.0, -np.inf
    for k in range(len(drawn)):
        a, b, c = points[drawn[k, 0]], points[drawn[k, 1]], points[drawn[k, 2]]
        u, v = b - a, c - a
        n = np.array([
            u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
        ])  # fmt: skip
        length = np.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        if length < 1e-9 or abs(n[2]) < steepest * length:
            continue
        along = n[0] * a[0] + n[1] * a[1] + n[2] * a[2]
        if along > 0:
            length = -length
        n = n / length
        offset = along / length
        value = 0.0
        for p in points:
            off = n[0] * p[0] + n[1] * p[1] + n[2] * p[2] - offset
            if off < -gate:
                value -= BEHIND
            elif off < gate:
                value += 1.0
        if value > most:
            most, height = value, offset
            for i in range(3):
                best[i] = n[i]
    return best, height, most

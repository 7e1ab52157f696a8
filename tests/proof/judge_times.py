"""How soon the waypoints of a leg can be passed: a linear program over a dense sample.

With x the squared speed of the parameter at marks, and x a straight line between them, the speed of
a joint, q'(s)^2 x(s), and its acceleration, q'(s) x'(s) / 2 + q''(s) x(s), are linear in x at any
place s.  Limits are asked at places between the marks, too.  The largest sum of x is the fastest
motion: of two motions the faster one at each mark is one.  Limits that are asked at places alone
are missed between them by little, so that times are rather too short than too long.
"""

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, vstack

COARSE, FINE = (13, 21), (40, 60)
"""Pieces of half a corner, and of what is straight; those of the proof lie otherwise.  Beside a way
that is much longer or shorter, coarse ones find times that are up to a sixth too long."""

INSIDE = np.array([0.05, 0.5, 0.95])
"""Places in each piece."""

SOONEST = 0.001
"""[s] From a waypoint to the next."""


def curve_at(path: np.ndarray, s: np.ndarray, zone: float):
    """The curve, q' and q'' (k, n) at parameters (k,), i at waypoint i; corners are parabolas."""
    steps = np.diff(path, axis=0)
    i = np.clip(s.astype(int), 0, len(steps) - 1)
    along = s - i
    q, slope, bend = path[i] + along[:, None] * steps[i], steps[i].copy(), np.zeros_like(steps[i])
    before, after = (along < zone) & (i > 0), (along > 1 - zone) & (i < len(steps) - 1)
    for side, inside in ((-1, before), (1, after)):
        deep = np.where(side < 0, zone - along, along - 1 + zone)[inside][:, None]
        turn = side * (steps[i[inside] + side] - steps[i[inside]]) / (2 * zone)
        q[inside] += turn * deep**2 / 2
        slope[inside] += side * turn * deep
        bend[inside] = turn
    return q, slope, bend


def soonest(
    path: np.ndarray,
    zone: float,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    pieces: tuple[int, int] = COARSE,
):
    """The least times (m - 1,) [s] between waypoints (m, n), from rest to rest, corners rounded."""
    count = len(path) - 1
    corner = np.linspace(0, zone, pieces[0] + 1)
    ticks = np.concatenate([corner, np.linspace(zone, 1 - zone, pieces[1] + 1), 1 - corner])
    marks = np.unique(np.concatenate([ticks + i for i in range(count)]).round(12))
    width = np.diff(marks)
    piece = np.repeat(np.arange(len(width)), len(INSIDE))
    share = np.tile(INSIDE, len(width))
    _, slope, bend = curve_at(path, marks[piece] + share * width[piece], zone)
    half = slope / (2 * width[piece][:, None])
    before, after = bend * (1 - share)[:, None] - half, bend * share[:, None] + half
    rows, n = len(piece), path.shape[1]
    number = np.arange(rows * n).reshape(rows, n)
    columns = np.repeat(piece, n), np.repeat(piece + 1, n)
    pushes = coo_array(
        (
            np.concatenate([before.ravel(), after.ravel()]),
            (np.tile(number.ravel(), 2), np.concatenate(columns)),
        ),
        shape=(rows * n, len(marks)),
    )
    limits = np.tile(acceleration, rows)
    steep = np.maximum(np.abs(slope) / velocity, 1e-12).max(axis=1) ** 2
    number = np.arange(rows)
    speeds = coo_array(
        (
            np.concatenate([steep * (1 - share), steep * share]),
            (np.tile(number, 2), np.concatenate([piece, piece + 1])),
        ),
        shape=(rows, len(marks)),
    )
    most = np.full(len(marks), SOONEST**-2)
    most[[0, -1]] = 0.0
    found = linprog(
        -np.ones(len(marks)),
        A_ub=vstack([pushes, -pushes, speeds]).tocsr(),
        b_ub=np.concatenate([limits, limits, np.ones(rows)]),
        bounds=np.stack([np.zeros(len(marks)), most], axis=1),
        method="highs",
    )
    assert found.status == 0, found.message
    x = np.sqrt(np.maximum(found.x, 0.0))
    times = 2 * width / np.maximum(x[1:] + x[:-1], 1e-12)
    return np.add.reduceat(times, np.searchsorted(marks, np.arange(count) - 1e-9))


def at_rest_between(step: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> float:
    """The least time [s] for a way (n,) of all joints in proportion, from rest to rest.

    The speed rises, stays, and falls: how far it gets in a time rises with the time.
    """
    moves = np.abs(step) > 1e-12
    if not moves.any():
        return 0.0
    v = (velocity[moves] / np.abs(step[moves])).min()
    a = (acceleration[moves] / np.abs(step[moves])).min()

    def far(seconds: float) -> float:
        ramp = min(seconds / 2, v / a)
        return a * ramp**2 + a * ramp * (seconds - 2 * ramp)

    low, high = 0.0, 1.0
    while far(high) < 1.0:
        high *= 2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if far(middle) < 1.0 else (low, middle)
    return high

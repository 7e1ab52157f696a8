"""When the arm passes each waypoint: the fastest timing of a leg within speed and acceleration.

Time-optimal path parameterization by reachability analysis (Pham and Pham, "A new approach to
time-optimal path parameterization based on reachability analysis", IEEE T-RO 2018; library
`toppra`) over the curve that the controller follows, from rest to rest.
"""

import logging
from functools import lru_cache

import numpy as np
import toppra
from toppra import algorithm, constraint

from workbench.model.errors import WorkbenchError
from workbench.model.geometry import Floats

logging.getLogger("toppra").setLevel(logging.ERROR)

GRIDS = (8, 16, 32)
"""Grid points of the parameterization between two waypoints; the next when the one finds none."""

STANDSTILL = 0.001
"""[s] Between two equal waypoints: times have to increase."""


class RoundedPolyline(toppra.interpolator.AbstractGeometricPath):
    """Waypoints (m, n) [rad] joined straight, corners rounded by parabolas within `zone`.

    The parameter, which has no unit, runs from 0 to m - 1 and is k at waypoint k; the derivative is
    continuous.
    """

    def __init__(self, path: Floats, zone: float):
        self._path = np.asarray(path)
        self._steps = np.diff(self._path, axis=0)
        self._zone = zone

    def __call__(self, path_positions: float | Floats, order: int = 0) -> Floats:
        """Position (order 0) or derivatives (1, 2) at the parameters (k,), shape (k, n)."""
        s = np.atleast_1d(np.asarray(path_positions, dtype=np.float64))
        last = len(self._steps) - 1
        piece = np.clip(np.floor(s).astype(int), 0, last)
        corner = np.clip(np.round(s).astype(int), 0, last + 1)
        inside = (np.abs(s - corner) < self._zone) & (corner > 0) & (corner <= last)
        before, after = (
            self._steps[np.maximum(corner - 1, 0)],
            self._steps[np.minimum(corner, last)],
        )
        z = max(self._zone, 1e-9)
        u = np.where(inside, s - corner, 0.0)[:, None]
        rounded = inside[:, None]
        if order == 0:
            straight = self._path[piece] + (s - piece)[:, None] * self._steps[piece]
            # a + integral of the linearly changing derivative, from the zone's entry on
            curve = self._path[corner] - z * before + (u + z) * before
            curve = curve + (u + z) ** 2 / (4 * z) * (after - before)
            values = np.where(rounded, curve, straight)
        elif order == 1:
            share = (u + z) / (2 * z)
            values = np.where(rounded, (1 - share) * before + share * after, self._steps[piece])
        else:
            values = np.where(rounded, (after - before) / (2 * z), 0.0)
        return values if np.ndim(path_positions) else values[0]

    @property
    def dof(self) -> int:
        """Number of joints."""
        return self._path.shape[1]

    @property
    def path_interval(self) -> Floats:
        """The range (2,) of the parameter."""
        return np.array([0.0, len(self._steps)])


def timed(path: Floats, velocity: Floats, acceleration: Floats, zone: float) -> Floats:
    """Times (m,) [s] at which the waypoints (m, n) are passed, starting at 0, from rest to rest.

    Args:
        path: waypoints, at least two; from one to an equal one it takes `STANDSTILL`, or longer.
        velocity: largest joint speeds (n,) [rad/s], already scaled.
        acceleration: largest joint accelerations (n,) [rad/s2].
        zone: corner rounding, fraction of the neighbouring segments.

    Raises:
        WorkbenchError: the limits are not positive.
    """
    if not (np.all(velocity > 0) and np.all(acceleration > 0)):
        raise WorkbenchError("an arm's speed and acceleration limits must be above zero")
    if zone <= 0.0 or not np.diff(path, axis=0).any():
        return _stopping(path, velocity, acceleration)  # sharp corners are taken at rest
    curve = RoundedPolyline(path, zone)
    limits = _limits(tuple(velocity.tolist()), tuple(acceleration.tolist()))
    for count in GRIDS:
        grid = np.linspace(0.0, len(path) - 1, count * (len(path) - 1) + 1)
        solver = algorithm.TOPPRA(limits, curve, gridpoints=grid, solver_wrapper="seidel")
        speeds = solver.compute_parameterization(0.0, 0.0)[1]
        if speeds is not None and np.all(np.isfinite(speeds)):
            steps = 2 * np.diff(grid) / np.maximum(speeds[1:] + speeds[:-1], 1e-9)
            return np.concatenate([[0.0], np.cumsum(steps)])[::count]
    return _stopping(path, velocity, acceleration)


def _stopping(path: Floats, velocity: Floats, acceleration: Floats) -> Floats:
    """Times (m,) [s] with a stop at every waypoint: slower, and possible on every path."""
    steps = np.abs(np.diff(path, axis=0))
    # Up to speed and down again, or never quite up to speed.
    ramps = velocity / acceleration
    times = np.where(
        steps >= velocity * ramps, steps / velocity + ramps, 2 * np.sqrt(steps / acceleration)
    )
    return np.concatenate([[0.0], np.cumsum(np.maximum(times.max(axis=1), STANDSTILL))])


@lru_cache(maxsize=32)
def _limits(
    velocity: tuple[float, ...], acceleration: tuple[float, ...]
) -> list[constraint.Constraint]:
    """The constraints of an arm; making them takes longer than using them."""
    most, push = np.array(velocity), np.array(acceleration)
    return [
        constraint.JointVelocityConstraint(np.column_stack([-most, most])),
        constraint.JointAccelerationConstraint(np.column_stack([-push, push])),
    ]

"""The curve that a blending controller makes of waypoints, written down a second time for tests."""

import numpy as np
import toppra

from workbench.planning.collision.motion import Curves


class RoundedPolyline(toppra.interpolator.AbstractGeometricPath):
    """Waypoints (m, n) [rad] joined straight, corners rounded by parabolas within `zone`.

    The parameter, which has no unit, runs from 0 to m - 1 and is k at waypoint k.
    """

    def __init__(self, path, zone: float):
        self._path = np.asarray(path)
        self._steps = np.diff(self._path, axis=0)
        self._zone = zone

    def __call__(self, path_positions, order: int = 0):
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
    def path_interval(self):
        """The range (2,) of the parameter."""
        return np.array([0.0, len(self._steps)])


def curves_of(path, zone: float) -> Curves:
    """The polyline with each corner rounded by a zone below 0.5."""
    steps = np.diff(path, axis=0)
    starts, ends = path[:-1] + zone * steps, path[1:] - zone * steps
    starts[0], ends[-1] = path[0], path[-1]
    straight = np.stack([starts, (starts + ends) / 2, ends], axis=1)
    if zone <= 0:
        return Curves(straight, np.arange(len(steps)))
    points = np.empty((2 * len(steps) - 1, *straight.shape[1:]))
    points[::2] = straight
    points[1::2] = np.stack([ends[:-1], path[1:-1], starts[1:]], axis=1)
    return Curves(points, np.arange(len(points)) // 2)

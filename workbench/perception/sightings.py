"""What a pose predicts the scanner to see, pixel by pixel, held against what it saw."""

from dataclasses import dataclass

import numpy as np
import open3d as o3d
from numba import njit

from workbench.model.geometry import Floats, frozen, put
from workbench.perception.maps import DepthMap
from workbench.perception.part_surface import PartSurface

AGREEING = 0.5
"""Cosine between predicted and measured normal above which a pixel is explained."""

AGAINST = 2.0
"""What a pixel where the scan looks through the part counts against one that it explains."""

MISSED, EXPLAINED, VIOLATED, HIDDEN = 0, 1, 2, 3
"""What a ray says of a pose; see `Sighting`."""


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """The pixels (flat indices) in which a pose shows the part, sorted out.

    `explained` are measured on the predicted surface, `off` (n,) [m] from it, along its
    normal; `violated` are measured behind it, so that the part cannot be there; `hidden` are
    measured in front of it, or not at all.
    """

    explained: np.ndarray
    off: Floats
    violated: np.ndarray
    hidden: np.ndarray

    def __post_init__(self) -> None:
        put(
            self,
            explained=frozen(self.explained, np.int64),
            off=frozen(self.off),
            violated=frozen(self.violated, np.int64),
            hidden=frozen(self.hidden, np.int64),
        )

    @property
    def shown(self) -> int:
        """Pixels in which the pose shows the part, if nothing were in the way."""
        return len(self.explained) + len(self.violated) + len(self.hidden)

    @property
    def visible(self) -> float:
        """Share of the surface facing the scanner that was seen, 0..1."""
        return len(self.explained) / max(self.shown, 1)

    @property
    def gain(self) -> float:
        """Pixels that speak for the pose less those that speak against it."""
        return len(self.explained) - AGAINST * len(self.violated)

    @property
    def score(self) -> float:
        """The gain over all pixels that the pose shows, 0..1."""
        return max(self.gain, 0.0) / max(self.shown, 1)

    def closeness(self, tolerance: float) -> float:
        """The gain, with explained pixels counting less the further they are off [m]."""
        return self.gain - float(np.sum((self.off / tolerance) ** 2))


def look(maps: DepthMap, surface: PartSurface, poses: Floats, tolerance: float) -> list[Sighting]:
    """Cast a ray through each pixel near each of `poses` (k, 4, 4) onto the part's mesh.

    Args:
        maps: the scan.
        surface: the part.
        poses: (k, 4, 4) in the scanner's frame.
        tolerance: [m] how far from the predicted surface a measured point may lie.
    """
    if len(poses) == 0:
        return []
    poses = np.ascontiguousarray(poses)
    windows = _windows(maps.camera.shape, *maps.view, poses, surface.coarse.points)
    pixels, ends, rays = _rays_in_part(maps.rays, poses, windows)
    hits = surface.scene.cast_rays(o3d.core.Tensor(rays))
    states, off = _states(
        maps.rays, maps.depth, maps.normals, maps.foreground, poses, pixels, ends,
        hits["t_hit"].numpy(), hits["primitive_normals"].numpy(), tolerance,
    )  # fmt: skip
    sightings: list[Sighting] = []
    for start, end in zip([0, *ends[:-1]], ends, strict=True):
        state, pixel = states[start:end], pixels[start:end]
        explained = state == EXPLAINED
        sightings.append(
            Sighting(
                pixel[explained],
                off[start:end][explained],
                pixel[state == VIOLATED],
                pixel[state == HIDDEN],
            )
        )
    return sightings


@njit(cache=True)
def _windows(shape, focal, column, row, poses, points):  # pragma: no cover (compiled)
    """First and last (exclusive) row and column (k, 4) around the part at each pose."""
    windows = np.empty((len(poses), 4), np.int64)
    for k in range(len(poses)):
        T = poses[k]
        low_u, high_u, low_v, high_v = np.inf, -np.inf, np.inf, -np.inf
        for p in points:
            z = T[2, 0] * p[0] + T[2, 1] * p[1] + T[2, 2] * p[2] + T[2, 3]
            if z <= 0.0:
                continue
            x = (T[0, 0] * p[0] + T[0, 1] * p[1] + T[0, 2] * p[2] + T[0, 3]) / z
            y = (T[1, 0] * p[0] + T[1, 1] * p[1] + T[1, 2] * p[2] + T[1, 3]) / z
            low_u, high_u = min(low_u, x), max(high_u, x)
            low_v, high_v = min(low_v, y), max(high_v, y)
        if low_u > high_u:  # wholly behind the scanner
            windows[k] = 0
            continue
        windows[k, 0] = min(max(int(low_v * focal + row) - 2, 0), shape[0])
        windows[k, 1] = min(max(int(high_v * focal + row) + 4, 0), shape[0])
        windows[k, 2] = min(max(int(low_u * focal + column) - 2, 0), shape[1])
        windows[k, 3] = min(max(int(high_u * focal + column) + 4, 0), shape[1])
    return windows


@njit(cache=True)
def _rays_in_part(rays, poses, windows):  # pragma: no cover (compiled)
    """For all windows one after the other: pixels (n,), ends of windows (k,), rays (n, 6).

    Rays have origin and direction in the part's frame; their parameter is the depth.
    """
    ends = np.empty(len(poses), np.int64)
    total = 0
    for k in range(len(poses)):
        high = max(0, windows[k, 1] - windows[k, 0])
        wide = max(0, windows[k, 3] - windows[k, 2])
        total += high * wide
        ends[k] = total
    pixels = np.empty(total, np.int64)
    out = np.empty((total, 6), np.float32)
    n = 0
    for k in range(len(poses)):
        T = poses[k]
        for v in range(windows[k, 0], windows[k, 1]):
            for u in range(windows[k, 2], windows[k, 3]):
                pixels[n] = v * rays.shape[1] + u
                for i in range(3):
                    out[n, i] = -(T[0, i] * T[0, 3] + T[1, i] * T[1, 3] + T[2, i] * T[2, 3])
                    out[n, 3 + i] = T[0, i] * rays[v, u, 0] + T[1, i] * rays[v, u, 1] + T[2, i]
                n += 1
    return pixels, ends, out


@njit(cache=True)
def _states(
    rays, depth, scan_normals, foreground, poses, pixels, ends, predicted, normals, tolerance
):  # pragma: no cover (compiled)
    """What each ray says (n,), and how far off the surface its measurement is (n,) [m]."""
    states = np.full(len(pixels), MISSED, np.int8)
    off = np.zeros(len(pixels))
    k = 0
    for n in range(len(pixels)):
        while n >= ends[k]:
            k += 1
        if not np.isfinite(predicted[n]):
            continue
        v, u = pixels[n] // depth.shape[1], pixels[n] % depth.shape[1]
        states[n] = HIDDEN
        if depth[v, u] == 0.0:
            continue
        along, agreement = 0.0, 0.0
        for i in range(3):
            turned = 0.0
            for j in range(3):
                turned += poses[k, i, j] * normals[n, j]
            along += turned * rays[v, u, i]
            agreement += turned * scan_normals[v, u, i]
        facing = 1.0 if along < 0.0 else -1.0
        # Along the normal that faces the scanner; negative is behind the surface.
        off[n] = -abs(along) * (depth[v, u] - predicted[n])
        if off[n] < -tolerance:
            states[n] = VIOLATED
        elif off[n] <= tolerance and foreground[v, u] and facing * agreement > AGREEING:
            states[n] = EXPLAINED
    return states, off

"""What a pose predicts the scanner to see, pixel by pixel, held against what it saw."""

from dataclasses import dataclass

import numpy as np
import open3d as o3d

from workbench.model.geometry import Floats, frozen, put
from workbench.perception.maps import DepthMap
from workbench.perception.part_surface import PartSurface

AGREEING = 0.5
"""Cosine between predicted and measured normal above which a pixel is explained."""

VIOLATED = 2.0
"""What a pixel where the scan looks through the part counts against one it explains."""


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
        return len(self.explained) - VIOLATED * len(self.violated)

    @property
    def score(self) -> float:
        """The gain over all pixels that the pose shows, 0..1."""
        return max(self.gain, 0.0) / max(self.shown, 1)

    def closeness(self, tolerance: float) -> float:
        """The gain, with explained pixels counting less the further they are off [m]."""
        return self.gain - float(np.sum((self.off / tolerance) ** 2))


def look(
    maps: DepthMap, surface: PartSurface, poses: Floats, tolerance: float, *, stride: int = 1
) -> list[Sighting]:
    """Cast a ray through each pixel near each of `poses` (k, 4, 4) onto the part's mesh.

    Args:
        maps: the scan.
        surface: the part.
        poses: (k, 4, 4) in the scanner's frame.
        tolerance: [m] how far from the predicted surface a measured point may lie.
        stride: 2 for every second pixel of every second row, and so on.
    """
    windows = [_window(maps, surface, pose, stride) for pose in poses]
    if not windows:
        return []
    rays = [
        _rays_in_part(maps.rays.reshape(-1, 3)[window], pose)
        for window, pose in zip(windows, poses, strict=True)
    ]
    hits = surface.scene.cast_rays(o3d.core.Tensor(np.concatenate(rays)))
    ends = np.cumsum([len(window) for window in windows])[:-1]
    depths = np.split(hits["t_hit"].numpy(), ends)
    normals = np.split(hits["primitive_normals"].numpy(), ends)
    return [
        _sorted_out(maps, window, depth, normal @ pose[:3, :3].T, tolerance)
        for window, depth, normal, pose in zip(windows, depths, normals, poses, strict=True)
    ]


def _window(maps: DepthMap, surface: PartSurface, pose: Floats, stride: int) -> np.ndarray:
    """Flat indices of the pixels in the rectangle around the part."""
    rows, columns = maps.camera.shape
    points = surface.coarse.points @ pose[:3, :3].T + pose[:3, 3]
    z = np.maximum(points[:, 2], 1e-6)
    image = points[:, :2] / z[:, None] * maps.camera.focal + maps.camera.centre
    low = np.floor(image.min(axis=0)).astype(int) - 2
    high = np.ceil(image.max(axis=0)).astype(int) + 3
    u = np.arange(max(low[0], 0), min(high[0], columns), stride)
    v = np.arange(max(low[1], 0), min(high[1], rows), stride)
    return (v[:, None] * columns + u).ravel()


def _rays_in_part(rays: Floats, pose: Floats) -> np.ndarray:
    """Origin and direction (n, 6) in the part's frame; their parameter is the depth."""
    directions = rays @ pose[:3, :3]
    origin = -pose[:3, :3].T @ pose[:3, 3]
    return np.concatenate(
        [np.broadcast_to(origin, directions.shape), directions], axis=1
    ).astype(np.float32)


def _sorted_out(
    maps: DepthMap, window: np.ndarray, predicted: Floats, normals: Floats, tolerance: float
) -> Sighting:
    hit = np.isfinite(predicted)
    pixels, predicted, normals = window[hit], predicted[hit], normals[hit]
    rays = maps.rays.reshape(-1, 3)[pixels]
    measured = maps.depth.ravel()[pixels]
    normals = normals * -np.sign(np.sum(normals * rays, axis=1))[:, None]
    # Along the predicted normal; positive is nearer to the scanner than the surface.
    off = np.sum(normals * rays, axis=1) * (measured - predicted)
    agreeing = np.sum(normals * maps.normals.reshape(-1, 3)[pixels], axis=1) > AGREEING
    known = measured > 0
    on_surface = known & (np.abs(off) <= tolerance)
    explained = on_surface & agreeing & maps.foreground.ravel()[pixels]
    violated = known & (off < -tolerance)
    return Sighting(
        explained=pixels[explained],
        off=off[explained],
        violated=pixels[violated],
        hidden=pixels[~explained & ~violated],
    )

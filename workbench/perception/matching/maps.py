"""The scan as maps: one depth and one normal a pixel of a camera looking into the bin."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.geometry import Bools, Floats, frozen, own, put, sampled
from workbench.model.part import Bin
from workbench.model.scan import Scan
from workbench.perception.bins.bin_fit import SeenBin, inside_by
from workbench.perception.views.camera import Pinhole
from workbench.perception.views.depth_images import averaged, normals_of

FLOOR_GATE = 0.0015
"""[m] Points lower than this above the bin's floor, or nearer to a wall, are the bin."""

FLOOR_GATE_OVER_NOISE = 4.0
"""Or this many deviations of the points of the floor."""

BELOW = 0.02
"""[m] Points deeper than this under the bin's floor are no part of the scene."""

POINTS_A_PIXEL = 2.0
"""The pixels are made so large that they hold this many points on average, or more."""

MOST_PIXELS = 600_000

MIXED = 2
"""[pixels] Within this distance of a thing's edge measurements of both sides are mixed."""

POINTS_A_SQUARE, MOST_COUNTED = 8.0, 50_000
"""Points that the squares in which they are counted hold on average, and how many are counted; of
more every second, third, ..."""


class Seen(NamedTuple):
    """A `DepthMap` as compiled code takes it.

    `rays` and `normals` (rows, columns, 3), `depth` [m] and `foreground` (rows, columns); `focal`
    [pixels], and `column` and `row` of the optical axis.
    """

    rays: Floats
    depth: Floats
    normals: Floats
    foreground: Bools
    focal: float
    column: float
    row: float


@dataclass(frozen=True, slots=True, eq=False)
class DepthMap:
    """What was measured in each direction; all in the scanner's frame.

    `rays` (rows, columns, 3), z = 1, pass through the mean of the points in a pixel, or
    through its centre; `depth` (rows, columns) [m] is along z, 0 where nothing was measured;
    `normals` (rows, columns, 3) look at the scanner, zero where unknown.  `foreground` marks
    the pixels that see something inside the bin.  `pitch` [m] is the width of a pixel at the
    bin's floor.  Within `mixed` pixels of a thing's edge measurements of both sides are mixed.
    """

    camera: Pinhole
    rays: Floats
    depth: Floats
    normals: Floats
    foreground: np.ndarray
    pitch: float
    mixed: int = MIXED

    def __post_init__(self) -> None:
        own(self, "rays", "depth", "normals")
        put(self, foreground=frozen(self.foreground, np.bool_))

    @property
    def seen(self) -> Seen:
        """The same for compiled code."""
        column, row = map(float, self.camera.centre)
        return Seen(
            self.rays, self.depth, self.normals, self.foreground, self.camera.focal, column, row
        )

    def halved(self) -> "DepthMap":
        """Every second pixel of every second row: for a glance, four times as fast."""
        rays = self.rays[::2, ::2]
        camera = Pinhole(self.camera.focal / 2, self.camera.centre / 2, rays.shape[:2])
        return DepthMap(
            camera,
            rays,
            self.depth[::2, ::2],
            self.normals[::2, ::2],
            self.foreground[::2, ::2],
            2 * self.pitch,
            self.mixed,
        )


def make_map(scan: Scan, bin: Bin, seen: SeenBin, *, size: float, pitch: float) -> DepthMap | None:
    """Project a scan, organised or not, into a camera that sees just the bin.

    An organised cloud is treated like any other: pixel indices add no information to the points,
    and the intrinsics of real scanners are often unknown.

    Args:
        scan: the cloud.
        bin: the bin of the cell.
        seen: the bin as the scan shows it.  The foreground is its inside up to `size` above the
            rim; with regions, only what is within `size` of them.
        size: diameter of the searched part [m].
        pitch: pixel width at the bin's floor [m]; a sparse cloud gets wider pixels.

    Returns:
        The map, or None when no point of the scan lies in the bin.
    """
    T_bin_scanner = bin.T_world_bin.inverse() * scan.T_world_scanner
    # Without walls a part reaches over the side as far as its middle does not.
    beside = bin.wall if bin.has_walls else size / 2
    reach = np.array([*(bin.size[:2] / 2 + beside), bin.size[2] + size])
    points = scan.points[_near_bin(scan.points, T_bin_scanner.homogeneous, reach)]
    shown = bin.size if bin.has_walls else bin.size + [size, size, 0.0]
    if len(points) == 0:
        return None
    low, high = _picture(_corners(shown, T_bin_scanner.inverse()), points)
    distance = float(np.linalg.norm(T_bin_scanner.translation))
    density = _density(points, low, high)
    widest = np.sqrt(float(np.prod(high - low)) / MOST_PIXELS)
    step = max(pitch / distance, np.sqrt(POINTS_A_PIXEL / density), widest)
    columns, rows = np.ceil((high - low) / step).astype(int) + 1
    camera = Pinhole(1.0 / step, -low / step, (int(rows), int(columns)))
    column, row = camera.centre
    rays, depth = averaged(points, camera.rays(), 1.0 / step, column, row, 0.03 * size)
    normals = normals_of(rays, depth, max(2, round(0.03 * size / (step * distance))), 0.03 * size)
    foreground = _inside(
        rays, depth, T_bin_scanner.homogeneous, bin.size, seen.floor, seen.walls,
        max(FLOOR_GATE, FLOOR_GATE_OVER_NOISE * seen.noise), size,
    )  # fmt: skip
    if bin.regions:
        p = (rays * depth[..., None]).reshape(-1, 3)
        p = p @ T_bin_scanner.rotation.T + T_bin_scanner.translation
        inside = np.any([region.near(p, size) for region in bin.regions], axis=0)
        foreground &= inside.reshape(depth.shape)
    if not foreground.any():
        return None
    return DepthMap(camera, rays, depth, normals, foreground, step * distance)


def _picture(corners: Floats, points: Floats) -> tuple[Floats, Floats]:
    """The corners (2,) of the picture on the plane z = 1.

    Args:
        corners: (8, 3) [m] of the bin.  Where one of them is behind the scanner its whole inside
            fits in no picture: that of nearly all points, then.
        points: (n, 3) [m] of the bin, before the scanner.
    """
    if corners[:, 2].min() > 0:
        image = corners[:, :2] / corners[:, 2:]
        return image.min(axis=0), image.max(axis=0)
    low, high = np.quantile(points[:, :2] / points[:, 2:], (0.005, 0.995), axis=0)
    return low, np.maximum(high, low + 1e-6)


def _density(points: Floats, low: Floats, high: Floats) -> float:
    """Points over the area of the picture [1] where most of them are, not where nothing is seen.

    Args:
        points: (n, 3) [m] before the scanner.
        low: (2,) corner of the picture, on the plane z = 1.
        high: (2,) the opposite one.
    """
    few = sampled(points, MOST_COUNTED)
    side = np.sqrt(float(np.prod(high - low)) * POINTS_A_SQUARE / len(few))
    columns, rows = np.ceil((high - low) / side).astype(np.int64) + 1
    u, v = (np.floor((few[:, k] / few[:, 2] - low[k]) / side).astype(np.int64) for k in (0, 1))
    is_shown = (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
    at = u[is_shown] * rows + v[is_shown]
    if len(at) == 0:
        return 1.0
    # Half of the points are in squares with more.
    return float(np.median(np.bincount(at)[at])) / side**2 * len(points) / len(few)


def _corners(size: Floats, T_scanner_bin: pin.SE3) -> Floats:
    """The eight corners (8, 3) of a box of a size (3,) on the bin's floor, in scanner's frame."""
    signs = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [0.0, 1.0]), axis=-1).reshape(-1, 3)
    return (signs * size) @ T_scanner_bin.rotation.T + T_scanner_bin.translation


@njit(cache=True)
def _inside(
    rays: Floats,
    depth: Floats,
    T: Floats,
    size: Floats,
    floor: Floats,
    walls: Floats,
    gate: float,
    above: float,
) -> Bools:  # pragma: no cover (compiled)
    """Which pixels see something that is further than `gate` from floor and walls."""
    inside = np.zeros(depth.shape, np.bool_)
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            if depth[v, u] == 0.0:
                continue
            c = depth[v, u]
            a, b = rays[v, u, 0] * c, rays[v, u, 1] * c
            x = T[0, 0] * a + T[0, 1] * b + T[0, 2] * c + T[0, 3]
            y = T[1, 0] * a + T[1, 1] * b + T[1, 2] * c + T[1, 3]
            z = T[2, 0] * a + T[2, 1] * b + T[2, 2] * c + T[2, 3]
            height, left = inside_by(floor, walls, size, x, y, z)
            inside[v, u] = left >= gate and gate <= height <= size[2] + above
    return inside


@njit(cache=True)
def _near_bin(points: Floats, T: Floats, reach: Floats) -> Bools:  # pragma: no cover (compiled)
    """Points of the bin and of what is in it, before the scanner: stray ones hide nothing."""
    near = np.zeros(len(points), np.bool_)
    for k in range(len(points)):
        p = points[k]
        x = T[0, 0] * p[0] + T[0, 1] * p[1] + T[0, 2] * p[2] + T[0, 3]
        y = T[1, 0] * p[0] + T[1, 1] * p[1] + T[1, 2] * p[2] + T[1, 3]
        z = T[2, 0] * p[0] + T[2, 1] * p[1] + T[2, 2] * p[2] + T[2, 3]
        is_in_bin = abs(x) <= reach[0] and abs(y) <= reach[1] and -BELOW <= z <= reach[2]
        near[k] = is_in_bin and p[2] > 0.0
    return near

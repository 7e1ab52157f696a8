"""What each scan saw of the region in which the part is, as a depth image of its own camera."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy import ndimage

from workbench.model.errors import InputError
from workbench.model.geometry import Bools, Floats, frozen, put, transform
from workbench.model.scan import Scan
from workbench.perception.views.camera import Pinhole
from workbench.perception.views.depth_images import averaged, normals_of

POINTS_A_PIXEL = 1.5
"""The pixels are made so large that they hold this many points on average."""

MOST_PIXELS = 2_000_000

WINDOW = 2
"""[pixels] To each side: the plane whose normal a pixel has."""

EDGE_STEEPNESS = 6.0
"""Neighbouring pixels whose depths differ by more times their width lie on both sides of an edge,
or one of them is measured wrongly."""


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """An upright box in the model's frame, in which the part is and nothing else.

    `low` and `high` (3,) [m].  What else there is, such as a table or a finger, is outside.
    """

    low: Floats
    high: Floats

    def __post_init__(self) -> None:
        put(self, low=frozen(self.low), high=frozen(self.high))
        if self.low.shape != (3,) or self.high.shape != (3,):
            raise InputError("a region has three lowest and three highest coordinates")
        if not np.all(self.high > self.low):
            raise InputError("each highest coordinate of a region must exceed the lowest one")

    def holds(self, points: Floats) -> Bools:
        """Which of some points (n, 3) [m] lie in it."""
        return np.asarray(((points > self.low) & (points < self.high)).all(axis=-1))

    @property
    def corners(self) -> Floats:
        """(8, 3) [m]."""
        ends = np.stack([self.low, self.high])
        picked = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), axis=-1).reshape(-1, 3)
        return ends[picked, np.arange(3)]


@dataclass(frozen=True, slots=True, eq=False)
class DepthView:
    """One scan as an image of the region.

    `T_model_camera` is where the scanner was; `rays` (rows, columns, 3), z = 1; `depth` (rows,
    columns) [m] along z, 0 where nothing was measured or not surely; `normals` (rows, columns, 3)
    look at the camera, zero where unknown; `is_part` (rows, columns) marks what was measured inside
    the region.
    """

    T_model_camera: pin.SE3
    camera: Pinhole
    rays: Floats
    depth: Floats
    normals: Floats
    is_part: Bools

    def points(self) -> tuple[Floats, Floats]:
        """What was measured of the part: points (n, 3) [m] and normals (n, 3), camera's frame."""
        here = self.is_part & self.normals.any(axis=2)
        return self.rays[here] * self.depth[here][:, None], self.normals[here]


def pixel_width(scan: Scan, bounds: Bounds) -> float:
    """Between neighbouring points of a scan, about [m], at the region's middle.

    Raises:
        InputError: no point of it lies in the region, or the region reaches behind the scanner.
    """
    _, _, step, distance = _window(scan, bounds)
    return step * distance


def depth_view(scan: Scan, bounds: Bounds) -> DepthView:
    """The part of a scan that looks into the region, whose frame is the scan's world.

    Raises:
        InputError: no point of it lies in the region, or the region reaches behind the scanner.
    """
    low, high, step, distance = _window(scan, bounds)
    columns, rows = np.ceil((high - low) / step).astype(int) + 1
    camera = Pinhole(1.0 / step, -low / step, (int(rows), int(columns)))
    before = scan.points[scan.points[:, 2] > 0]
    column, row = camera.centre
    steep = EDGE_STEEPNESS * step * distance
    rays, depth = averaged(before, camera.rays(), camera.focal, column, row, steep)
    depth = _sure(depth, steep)
    normals = normals_of(rays, depth, WINDOW, steep)
    points = (rays * depth[..., None]) @ scan.T_world_scanner.rotation.T
    is_part = (depth > 0) & bounds.holds(points + scan.T_world_scanner.translation)
    return DepthView(scan.T_world_scanner, camera, rays, depth, normals, is_part)


def _window(scan: Scan, bounds: Bounds) -> tuple[Floats, Floats, float, float]:
    """Corners (2,) of the picture of the region, width of a pixel in it, and distance [m]."""
    T_camera_model = scan.T_world_scanner.inverse()
    corners = transform(T_camera_model, bounds.corners)
    if corners[:, 2].min() <= 0:
        raise InputError(
            f"{scan.source}: the region reaches behind the scanner; is its pose right?"
        )
    image = corners[:, :2] / corners[:, 2:]
    low, high = image.min(axis=0), image.max(axis=0)
    inside = bounds.holds(scan.points_world)
    if not inside.any():
        near, far = np.percentile(scan.points_world * 1000, (1, 99), axis=0)
        reach = "; ".join(f"{a:.0f} to {b:.0f}" for a, b in zip(near, far, strict=True))
        raise InputError(
            f"{scan.source}: no point of it lies in the region; in the model's frame its points "
            f"are at x, y, z of {reach} mm. Are pose, axes and region right?"
        )
    seen = scan.points[scan.points[:, 2] > 0]
    seen = seen[:, :2] / seen[:, 2:]
    in_window = ((seen >= low) & (seen <= high)).all(axis=1)
    # Gaps count for nothing: the density is that of cells that hold something.
    cells = np.floor((seen[in_window] - low) / (high - low) * 64).astype(int)
    filled = len(np.unique(cells @ [64, 1])) / 64**2
    area = float(np.prod(high - low)) * filled
    step = np.sqrt(POINTS_A_PIXEL * area / max(int(in_window.sum()), 1))
    step = max(float(step), float(np.sqrt(np.prod(high - low) / MOST_PIXELS)))
    return low, high, step, float(np.linalg.norm(corners.mean(axis=0)))


def _sure(depth: Floats, steep: float) -> Floats:
    """Depths without those beside an edge, where scanners mix what lies on both sides of it."""
    near = ndimage.minimum_filter(np.where(depth > 0, depth, np.inf), 3)
    far = ndimage.maximum_filter(depth, 3)
    return np.where(far - near > steep, 0.0, depth)

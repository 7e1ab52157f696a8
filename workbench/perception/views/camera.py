"""The pinhole camera that stands for a scanner: z forward, x right, y down."""

from dataclasses import dataclass

import numpy as np

from workbench.model.cell import ScannerMount
from workbench.model.geometry import Bools, Floats, own

RARE, SAMPLED = 0.002, 50_000
"""Share of points that set no bounds of a picture, and points by which that is measured."""


def picture_of(points: Floats) -> Floats:
    """Where points (n, 3) [m] before the camera lie on the plane z = 1: (n, 2), no unit.

    By columns, here and below: numpy works on long ones fast, and on pairs slowly.
    """
    return np.stack([points[:, k] / points[:, 2] for k in (0, 1)]).T


def picture_bounds(image: Floats) -> tuple[Floats, Floats]:
    """The corners (2,) of the picture of points (n, 2) on the plane z = 1; no unit.

    A stray point at the scanner would make it endless.  So what is further from nearly all
    others than these from each other lies outside.
    """
    some = image[:: max(1, len(image) // SAMPLED)]
    first, last = np.array([np.quantile(column, (RARE, 1 - RARE)) for column in some.T]).T
    width = (last - first).max()
    is_near = are_within(image, first - width, last + width)
    near = [column[is_near] for column in image.T]
    return np.array([column.min() for column in near]), np.array([column.max() for column in near])


def are_within(image: Floats, low: Floats, high: Floats) -> Bools:
    """Which points (n, 2) of a picture lie between two corners (2,): (n,); no unit."""
    (u, v), (left, top), (right, bottom) = image.T, low, high
    return (u >= left) & (u <= right) & (v >= top) & (v <= bottom)


@dataclass(frozen=True, slots=True, eq=False)
class Pinhole:
    """A camera without distortion; pixel (row, column) has its centre at whole numbers.

    `focal` is the focal length [px], `centre` (2,) [px] the column and row, not necessarily
    inside the image, where the optical axis passes; `shape` is (rows, columns).
    """

    focal: float
    centre: Floats
    shape: tuple[int, int]

    def __post_init__(self) -> None:
        own(self, "centre")

    @classmethod
    def of_scanner(cls, mount: ScannerMount) -> "Pinhole":
        """The camera with the mount's resolution and field of view, centred."""
        columns, rows = mount.resolution
        focal = columns / 2 / np.tan(mount.field_of_view / 2)
        return cls(focal, np.array([columns - 1, rows - 1]) / 2, (rows, columns))

    @property
    def matrix(self) -> Floats:
        """The camera matrix (3, 3) [px]."""
        column, row = self.centre
        return np.array([[self.focal, 0, column], [0, self.focal, row], [0, 0, 1]])

    def rays(self) -> Floats:
        """Directions (rows, columns, 3) through the pixel centres, scaled to z = 1: no unit."""
        rows, columns = self.shape
        x = (np.arange(columns) - self.centre[0]) / self.focal
        y = (np.arange(rows) - self.centre[1]) / self.focal
        return np.stack([*np.meshgrid(x, y), np.ones(self.shape)], axis=-1)

"""The soft dark of what stands on the table: without it things seem to float.

Real shadows take a third of the time of a picture where no graphics processor draws; this is one
image that lies on the table.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import trimesh
from scipy import ndimage

from workbench.formats.meshes.triangles import triangles_of
from workbench.model.cell import Cell
from workbench.model.derived.by_bin import surfaces
from workbench.model.geometry import Floats, Solid

Image = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]
"""Rows, columns and channels."""

PIXEL = 0.004
"""[m] Of the image."""

HIGH = 0.15
"""[m] Above the table: what is higher darkens nothing."""

SAME_TOP_WITHIN = 0.002
"""[m] Tops that differ by no more are one surface."""

SOFT = (0.008, 0.035)
"""[m] Width of the dark right at an edge, and of that around it."""

DARKEST = 0.5
"""Of the image, 0..1."""

POINTS_A_BODY = 5_000
"""Points on each body."""

MOST_PIXELS = 1000
"""Of an edge of the image."""


@dataclass(frozen=True, slots=True, eq=False)
class Shade:
    """An image (rows, columns, 4) of 0..255, rows along y, and where it lies in the world.

    `middle` (3,) [m] and `size` (2,) [m] along x and y.
    """

    image: Image
    middle: Floats
    size: Floats


def shade_of(cell: Cell) -> Shade | None:
    """The shade on the surface on which the bin stands; None where there is none.

    Same cell, same shade.
    """
    fixed = [_surface(s, f.T_world_fixture) for f in surfaces(cell) for s in f.solids]
    foot = float(cell.bin.T_world_bin.translation[2]) + SAME_TOP_WITHIN
    tops = [body.bounds[1, 2] for body in fixed if body.bounds[1, 2] <= foot]
    if not tops:
        return None
    height = float(max(tops))
    under = [body for body in fixed if abs(body.bounds[1, 2] - height) <= SAME_TOP_WITHIN]
    bodies = [*fixed, *(_surface(s, cell.bin.T_world_bin) for s in cell.bin.solids)]
    over = [body for body in bodies if body.bounds[1, 2] > height + SAME_TOP_WITHIN]
    if not over:
        return None
    low = np.min([body.bounds[0, :2] for body in under], axis=0)
    high = np.max([body.bounds[1, :2] for body in under], axis=0)
    pixels = np.ceil((high - low) / PIXEL).astype(int)
    if pixels.max() > MOST_PIXELS or pixels.min() < 2:
        return None
    dark = np.zeros(pixels)
    for body in over:
        points = np.asarray(trimesh.sample.sample_surface(body, POINTS_A_BODY, seed=0)[0])
        points = points[(points[:, 2] > height - 0.001) & (points[:, 2] < height + HIGH)]
        at = np.floor((points[:, :2] - low) / PIXEL).astype(int)
        inside = np.all((at >= 0) & (at < pixels), axis=1)
        weights = 1.0 - (points[inside, 2] - height) / HIGH
        np.maximum.at(dark, tuple(at[inside].T), weights)
    soft = sum(ndimage.gaussian_filter(_close_gaps(dark), width / PIXEL) for width in SOFT) / len(
        SOFT
    )
    image = np.zeros((*pixels[::-1], 4), np.uint8)
    image[..., 3] = np.round(255 * DARKEST * np.clip(soft, 0.0, 1.0)).T
    middle = np.array([*(low + high) / 2, height + 0.0005])
    return Shade(image, middle, high - low)


def _surface(solid: Solid, T_world_owner: pin.SE3) -> trimesh.Trimesh:
    surface = triangles_of(solid.shape)
    surface.apply_transform((T_world_owner * solid.T_owner_shape).homogeneous)
    return surface


def _close_gaps(dark: Floats) -> Floats:
    """The image (n, m) without the gaps between points."""
    return ndimage.grey_closing(dark, size=5)

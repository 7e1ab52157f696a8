"""Upright boxes around points: what is seen from above, down to the floor.

A heap becomes one box where it fills that; more where it does not, and where its one box would
reach into a known part that none of its points is under.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree  # pyright: ignore[reportAttributeAccessIssue]

from workbench.model.geometry import Floats, Ints
from workbench.model.scan import Obstacle
from workbench.perception.scene.roofs import NO_ROOFS, Roofs

FILLED = 0.75
"""Share of its box that a heap must fill seen from above; otherwise it is split in two."""

SAME_BOX_HEIGHT = 0.03
"""[m] Heights in one box may differ by this much before it is split."""

NARROW_BOX = 0.03
"""[m] A box no wider than this is not split."""

FEWEST_CELLS = 6
"""Grid cells up to which a heap is not split."""

MOST_BOXES = 40
"""Boxes; heaps that are nearest to each other become one, and are no longer split."""

FLATTEST = 0.006
"""[m] Height of a box around what lies lower than the floor."""

LARGEST_AREA_RATIO = 1.5
"""Area of a rectangle that is clear of a known part, over that of the smallest."""

SMALLEST = 0.006
"""[m] A box no longer than this is not split, whatever it reaches into."""


@dataclass(frozen=True, slots=True)
class Grid:
    """How finely things are seen from above.

    Attributes:
        edge: of a cell [m].
        coarse: this many cells apart things are one, and what lies between them is full.
    """

    edge: float
    coarse: int = 1


def upright_boxes(
    cells: Ints, tops: Floats, grid: Grid, roofs: Roofs = NO_ROOFS
) -> tuple[Obstacle, ...]:
    """Boxes in the frame of the cells that hold all of them, `MOST_BOXES` at the most.

    Args:
        cells: (n, 2) whole numbers, of a grid seen from above, each once.
        tops: (n,) height of the highest point in each [m].
        grid: of the cells.
        roofs: that boxes stay under, as far as they are split for it.
    """
    if len(cells) == 0:
        return ()
    heaps = _few_heaps(cells, grid.coarse)
    count = int(heaps.max()) + 1
    boxes: list[Obstacle] = []
    for number in range(count):
        is_here = heaps == number
        left = MOST_BOXES - len(boxes) - (count - 1 - number)
        boxes += _boxes(cells[is_here], tops[is_here], grid, roofs, left)
    return tuple(boxes)


def _few_heaps(cells: Ints, reach: int) -> Ints:
    """Which of at most `MOST_BOXES` heaps each of the cells (k, 2) belongs to, (k,)."""
    while (heaps := _heaps(cells, reach)).max(initial=-1) >= MOST_BOXES:
        reach *= 2
    return heaps


def _heaps(cells: Ints, reach: int = 1) -> Ints:
    """Which heap each of the cells (k, 2) belongs to, (k,); it ends where no cell is in `reach`."""
    if len(cells) == 0:
        return np.empty(0, np.int64)
    # Cells further apart are joined block by block: their pairs would be too many.
    blocks, place = np.unique(cells // reach, axis=0, return_inverse=True)
    first, second = cKDTree(blocks).query_pairs(1.5, p=np.inf, output_type="ndarray").T
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(blocks), len(blocks)))
    return connected_components(graph, directed=False)[1][place.reshape(-1)]


def _boxes(cells: Ints, heights: Floats, grid: Grid, roofs: Roofs, most: int) -> list[Obstacle]:
    """A heap of grid cells (n, 2) with heights (n,) [m] as few boxes."""
    centres: Any = (cells + 0.5) * grid.edge
    around = _rectangles(centres, grid.edge)
    boxes = [_box(*rectangle, heights) for rectangle in around]
    clear = [k for k, obstacle in enumerate(boxes) if not _reaches_into(obstacle, roofs)]
    chosen = clear[0] if clear else 0
    (yaw, middle, size), box = around[chosen], boxes[chosen]
    along = (centres - middle) @ np.array([np.cos(yaw), np.sin(yaw)])
    first = along <= float(np.median(along))
    if most <= 1 or first.all():
        return [box]
    coarse, edge = np.unique(cells // grid.coarse, axis=0), grid.coarse * grid.edge
    # The grid adds a rim of half a cell to whatever lies aslant in it.
    is_full = len(coarse) * edge**2 >= FILLED * np.prod(size - grid.edge)
    is_level = float(np.ptp(heights)) <= SAME_BOX_HEIGHT
    is_small = size[0] <= NARROW_BOX or len(coarse) <= FEWEST_CELLS
    is_neat = is_small or (is_full and is_level)
    if is_neat and (clear or size[0] <= SMALLEST):
        return [box]
    first_boxes = _boxes(cells[first], heights[first], grid, roofs, most - 1)
    return first_boxes + _boxes(
        cells[~first], heights[~first], grid, roofs, most - len(first_boxes)
    )


def _reaches_into(box: Obstacle, roofs: Roofs) -> bool:
    """Whether a box is higher than a roof above it."""
    T = box.T_world_box
    flat = (roofs.places - T.translation[:2]) @ T.rotation[:2, :2]
    is_over = np.all(np.abs(flat) <= box.size[:2] / 2, axis=1)
    top = T.translation[2] + box.size[2] / 2
    return bool(np.any(roofs.heights[is_over] < top))


def _rectangles(centres: Floats, edge: float) -> list[tuple[float, Floats, Floats]]:
    """Rectangles around grid cells (n, 2), smallest first: yaw of the longer side, middle, sizes.

    One has a side along each side of the convex hull; those of more than `LARGEST_AREA_RATIO` are
    left out.
    """
    half = edge / 2
    corners = np.vstack([centres + (x, y) for x in (-half, half) for y in (-half, half)])
    hull = corners[ConvexHull(corners).vertices]
    edges = np.roll(hull, -1, axis=0) - hull
    found: list[tuple[float, float, Floats, Floats]] = []
    for yaw in np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 6)):
        axes = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        turned = hull @ axes.T
        low, high = turned.min(axis=0), turned.max(axis=0)
        size, middle = high - low, (low + high) / 2 @ axes
        if size[0] < size[1]:
            yaw, size = yaw + np.pi / 2, size[::-1]
        # Areas that are equal but for rounding keep the order of their angles.
        found.append((round(float(np.prod(size)), 12), float(yaw), middle, size))
    found.sort(key=lambda rectangle: rectangle[0])
    return [
        rectangle[1:] for rectangle in found if rectangle[0] <= LARGEST_AREA_RATIO * found[0][0]
    ]


def _box(yaw: float, middle: Floats, size: Floats, heights: Floats) -> Obstacle:
    """From the floor, or from the lowest of the heights where that is lower, up to the highest."""
    top = float(heights.max())
    bottom = min(0.0, top - FLATTEST, float(heights.min()))
    centre = np.array([*middle, (top + bottom) / 2])
    T = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, yaw), centre)
    return Obstacle(T, np.array([*size, top - bottom]))

"""Upright boxes around points: what is seen from above, down to the floor."""

from typing import Any

import numpy as np
import pinocchio as pin
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree  # pyright: ignore[reportAttributeAccessIssue]

from workbench.model.geometry import Floats, Ints
from workbench.model.scan import Obstacle

FILLED = 0.75
"""Share of its box that a heap must fill seen from above; otherwise it is split in two."""

STEEPEST = 0.03
"""[m] Heights in one box may differ by this much before it is split."""

NARROW = 0.03
"""[m] A box no wider than this is not split."""

FEWEST = 6
"""Grid cells up to which a heap is not split."""

MOST = 40
"""Boxes; heaps that are nearest to each other become one, and are no longer split."""

FLATTEST = 0.006
"""[m] Height of a box around what lies lower than the floor."""


def upright_boxes(cells: Ints, tops: Floats, edge: float) -> tuple[Obstacle, ...]:
    """Boxes in the frame of the cells that hold all of them, `MOST` at the most.

    Args:
        cells: (n, 2) whole numbers, of a grid seen from above, each once.
        tops: (n,) height of the highest point in each [m].
        edge: of a grid cell [m].
    """
    if len(cells) == 0:
        return ()
    heaps = _few_heaps(cells)
    count = int(heaps.max()) + 1
    boxes: list[Obstacle] = []
    for number in range(count):
        is_here = heaps == number
        centres: Any = (cells[is_here] + 0.5) * edge
        left = MOST - len(boxes) - (count - 1 - number)
        boxes += _boxes(centres, tops[is_here], edge, left)
    return tuple(boxes)


def _few_heaps(cells: Ints) -> Ints:
    """Which of at most `MOST` heaps each of the cells (k, 2) belongs to, (k,)."""
    reach = 1
    while (heaps := _heaps(cells, reach)).max(initial=-1) >= MOST:
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


def _boxes(centres: Floats, heights: Floats, edge: float, most: int) -> list[Obstacle]:
    """A heap of grid cells (n, 2) with heights (n,) [m] as few boxes."""
    yaw, middle, size = _rectangle(centres, edge)
    # The grid adds a rim of half a cell to whatever lies aslant in it.
    is_full = len(centres) * edge**2 >= FILLED * (size[0] - edge) * (size[1] - edge)
    is_level = float(np.ptp(heights)) <= STEEPEST
    along = (centres - middle) @ np.array([np.cos(yaw), np.sin(yaw)])
    first = along <= float(np.median(along))
    is_small = size[0] <= NARROW or len(centres) <= FEWEST or first.all()
    if (is_full and is_level) or is_small or most <= 1:
        return [_box(yaw, middle, size, heights)]
    one = _boxes(centres[first], heights[first], edge, most - 1)
    return one + _boxes(centres[~first], heights[~first], edge, most - len(one))


def _rectangle(centres: Floats, edge: float) -> tuple[float, Floats, Floats]:
    """The smallest rectangle around grid cells (n, 2): yaw of its longer side, middle, sizes."""
    half = edge / 2
    corners = np.vstack([centres + (x, y) for x in (-half, half) for y in (-half, half)])
    hull = corners[ConvexHull(corners).vertices]
    edges = np.roll(hull, -1, axis=0) - hull
    best: tuple[float, float, Floats, Floats] | None = None
    for yaw in np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 6)):
        axes = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        turned = hull @ axes.T
        low, high = turned.min(axis=0), turned.max(axis=0)
        area = float(np.prod(high - low))
        if best is None or area < best[0] - 1e-12:
            best = area, float(yaw), (low + high) / 2 @ axes, high - low
    assert best is not None
    _, yaw, middle, size = best
    return (yaw, middle, size) if size[0] >= size[1] else (yaw + np.pi / 2, middle, size[::-1])


def _box(yaw: float, middle: Floats, size: Floats, heights: Floats) -> Obstacle:
    """From the floor, or from the lowest of the heights where that is lower, up to the highest."""
    top = float(heights.max())
    bottom = min(0.0, top - FLATTEST, float(heights.min()))
    centre = np.array([*middle, (top + bottom) / 2])
    T = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, yaw), centre)
    return Obstacle(T, np.array([*size, top - bottom]))

"""What a scan shows that neither the cell nor the parts found explain: obstacles nobody modelled.

Points near a known surface are explained by it.  What is left is gathered on a grid seen from
above, lonely points are dropped, and each heap becomes a few upright boxes.  They reach down to
the floor below: the scanner does not see what is underneath.
"""

import numpy as np
import open3d as o3d
import pinocchio as pin
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree

from workbench.model.cell import Cell
from workbench.model.geometry import Floats, Ints
from workbench.model.scan import Detection, Obstacle, Scan
from workbench.perception.surfaces import add_surface, surface_of

TOLERANCE = 0.006
"""[m] So far from a known surface a point still belongs to it: noise, and pose errors."""

CELL = 0.006
"""[m] Of the grid seen from above."""

ENOUGH = 60_000
"""Points that are looked at; of a denser scan every second, third, ... is left out."""

FARTHEST = 20.0
"""[m] Points further from the bin along one of its axes are outliers: no arm gets there."""

FEWEST = 3
"""Points in a grid cell, and cells in a heap, below which it counts as noise."""

FILLED = 0.75
"""Share of its box that a heap must fill seen from above; otherwise it is split in two."""

STEEPEST = 0.03
"""[m] Heights in one box may differ by this much before it is split."""

NARROW = 0.03
"""[m] A box no wider than this is not split."""

MOST = 40
"""Boxes; from then on a heap is no longer split."""

OF_THE_CELL = -1
UNEXPLAINED = -2


def explained_by(cell: Cell, detections: tuple[Detection, ...], points: Floats) -> Ints:
    """What each point (n, 3) [m] in the world belongs to, as integers (n,).

    Returns:
        The number of the detection, `OF_THE_CELL` for bin and fixtures, or `UNEXPLAINED`.
    """
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    owners: list[int] = []
    solids = [(solid, cell.bin.T_world_bin) for solid in cell.bin.solids]
    solids += [
        (solid, fixture.T_world_fixture) for fixture in cell.fixtures for solid in fixture.solids
    ]
    for solid, T in solids:
        add_surface(scene, surface_of(solid.shape), T * solid.T_owner_shape)
        owners.append(OF_THE_CELL)
    for number, detection in enumerate(detections):
        mesh = cell.part(detection.part).mesh
        add_surface(scene, surface_of(mesh), detection.T_world_part)
        owners.append(number)
    queries = np.ascontiguousarray(points, dtype=np.float32)
    nearest = scene.compute_closest_points(o3d.core.Tensor(queries), nthreads=1)
    away = np.linalg.norm(nearest["points"].numpy() - queries, axis=1)
    found = np.array(owners, dtype=np.int64)[nearest["geometry_ids"].numpy().astype(np.int64)]
    return np.where(away <= TOLERANCE, found, UNEXPLAINED)


def unexplained(cell: Cell, scan: Scan, detections: tuple[Detection, ...]) -> tuple[Obstacle, ...]:
    """Upright boxes around all that nothing known explains, in the frame of the bin.

    Args:
        cell: bin and fixtures; the robot is expected to be out of the picture.
        scan: what was seen.
        detections: the parts found in it.
    """
    points = scan.points_world[:: -(-len(scan.points) // ENOUGH)]
    T_bin_world = cell.bin.T_world_bin.inverse()
    p_bin = points @ T_bin_world.rotation.T + T_bin_world.translation
    is_near = np.abs(p_bin).max(axis=1) <= FARTHEST
    points, p_bin = points[is_near], p_bin[is_near]
    p_bin = p_bin[explained_by(cell, detections, points) == UNEXPLAINED]
    if len(p_bin) == 0:
        return ()
    low = p_bin[:, :2].min(axis=0)
    cells, tops = _grid_cells(p_bin, low)
    heaps = _heaps(cells)
    boxes: list[Obstacle] = []
    for number in range(heaps.max(initial=-1) + 1):
        heap = heaps == number
        if np.count_nonzero(heap) >= FEWEST:
            centres = low + (cells[heap] + 0.5) * CELL
            boxes += _boxes(cell, centres, tops[heap], MOST - len(boxes))
    return tuple(boxes)


def _grid_cells(p_bin: Floats, low: Floats) -> tuple[Ints, Floats]:
    """Cells (k, 2) of the grid from `low` (2,) [m] that hold enough points; their heights [m].

    Only cells that hold points are listed: a grid over the room would not fit into memory.
    """
    index = np.floor((p_bin[:, :2] - low) / CELL).astype(np.int64)
    cells, place, counts = np.unique(index, axis=0, return_inverse=True, return_counts=True)
    tops = np.full(len(cells), -np.inf)
    np.maximum.at(tops, place.reshape(-1), p_bin[:, 2])
    is_kept = counts >= FEWEST
    return cells[is_kept], tops[is_kept]


def _heaps(cells: Ints) -> Ints:
    """Which heap each of the cells (k, 2) belongs to, (k,); it ends where no neighbour is."""
    if len(cells) == 0:
        return np.empty(0, np.int64)
    first, second = cKDTree(cells).query_pairs(1.5, p=np.inf, output_type="ndarray").T
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(cells), len(cells)))
    return connected_components(graph, directed=False)[1]


def _boxes(cell: Cell, centres: Floats, heights: Floats, most: int) -> list[Obstacle]:
    """A heap of grid cells (n, 2) with heights (n,) [m], in the bin's frame, as few boxes."""
    yaw, middle, size = _rectangle(centres)
    # The grid adds a rim of half a cell to whatever lies aslant in it.
    is_full = len(centres) * CELL**2 >= FILLED * (size[0] - CELL) * (size[1] - CELL)
    is_level = float(np.ptp(heights)) <= STEEPEST
    along = (centres - middle) @ np.array([np.cos(yaw), np.sin(yaw)])
    first = along <= float(np.median(along))
    is_small = size[0] <= NARROW or len(centres) <= 2 * FEWEST or first.all()
    if (is_full and is_level) or is_small or most <= 1:
        return [_box(cell, yaw, middle, size, float(heights.max()))]
    one = _boxes(cell, centres[first], heights[first], most - 1)
    return one + _boxes(cell, centres[~first], heights[~first], most - len(one))


def _rectangle(centres: Floats) -> tuple[float, Floats, Floats]:
    """The smallest rectangle around grid cells (n, 2): yaw of its longer side, middle, sizes."""
    half = CELL / 2
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


def _box(cell: Cell, yaw: float, middle: Floats, size: Floats, top: float) -> Obstacle:
    """From the floor of the bin, or from the top itself where that is lower, up to `top`."""
    bottom = min(0.0, top - CELL)
    centre = np.array([*middle, (top + bottom) / 2])
    T_bin_box = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, yaw), centre)
    return Obstacle(cell.bin.T_world_bin * T_bin_box, np.array([*size, top - bottom]))

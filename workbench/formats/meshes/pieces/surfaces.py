"""How far points lie outside of triangles, whichever way these are turned."""

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt, label
from scipy.spatial import KDTree

from workbench.formats.meshes.pieces.nearest import farthest, tree_of
from workbench.model.geometry import Bools, Floats, Ints

MOST_POINTS = 150_000
"""On the surface, about."""

CELL = 2.0
"""Side of a cell of space, in distances between points: so no way leads through the surface."""


class Surface:
    """Triangles (n, 3, 3) [m] that enclose something, or nearly.

    Space is divided into cells; those that cannot be reached from outside, through cells without
    a point of the surface, are inside; so is a hollow to which nothing leads.

    Points of the surface, by which places on it are found, are `spacing` [m] apart, or more where
    they would be more than `MOST_POINTS`.
    """

    def __init__(self, triangles: Floats, *, spacing: float):
        self.triangles = triangles
        a, b, c = np.moveaxis(triangles, 1, 0)
        normals = np.cross(b - a, c - a)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        self._normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 1e-12)
        spacing = max(spacing, float(np.sqrt(length.sum() / MOST_POINTS)))
        self._points, self._of = _spread(triangles, spacing)
        self._tree = KDTree(self._points)
        self._boxes = tree_of(triangles, self._normals)
        self._cell = CELL * spacing
        self._low = self._points.min(axis=0) - 1.5 * self._cell
        shape = np.ceil((self._points.max(axis=0) - self._low) / self._cell).astype(int) + 2
        is_taken = np.zeros(tuple(shape), bool)
        is_taken[tuple(self._cells(self._points).T)] = True
        regions: Ints = np.empty(is_taken.shape, np.int32)
        label(~is_taken, output=regions)
        self._is_reached = regions == regions[0, 0, 0]
        self._is_taken = is_taken
        # How far what is in a cell is from the nearest point in another one, at most.
        self._away = self._cell * (distance_transform_edt(~is_taken) + np.sqrt(3))

    def outer(self) -> Floats:
        """The triangles (n, 3, 3) [m] that something outside could touch."""
        near = np.asarray(binary_dilation(self._is_reached, np.ones((3, 3, 3), bool)), bool)
        is_outer = np.zeros(len(self.triangles), bool)
        is_outer[self._of[self._are(near, self._points, elsewhere=True)]] = True
        return self.triangles[is_outer]

    def farthest(
        self, points: Floats, enough: float = 0.0, too_far: float = np.inf
    ) -> tuple[float, int]:
        """How far the farthest of points (n, 3) lies outside at most [m], and which it is, nearly.

        Args:
            points: [m] within the box around the surface; of those about as far the first counts.
            enough: [m] what surely is no farther is not checked closer.
            too_far: [m] the search ends at a point that is farther.
        """
        is_at_surface = self._are(self._is_taken, points, elsewhere=False)
        counts = is_at_surface | self._are(self._is_reached, points, elsewhere=True)
        cells = self._cells(points).clip(0, np.array(self._away.shape) - 1)
        most = np.where(counts, self._away[tuple(cells.T)], 0.0)
        return farthest(self._boxes, points, most, is_at_surface, enough, too_far)

    def around(self, point: Floats, count: int) -> tuple[Floats, Floats]:
        """Points on the surface nearest to a point, (k, 3) [m], and its normals there (k, 3)."""
        near = np.asarray(self._tree.query(point, k=count)[1])
        near = near[near < len(self._points)]
        normals = self._normals[self._of[near]]
        is_right = normals.any(axis=1)
        return self._points[near][is_right], normals[is_right]

    def _are(self, what: Bools, points: Floats, *, elsewhere: bool) -> Bools:
        """What holds of the cells of points (n, 3), and `elsewhere` beyond all cells, (n,)."""
        cells = self._cells(points)
        is_known = ((cells >= 0) & (cells < what.shape)).all(axis=1)
        found = np.full(len(points), elsewhere)
        found[is_known] = what[tuple(cells[is_known].T)]
        return found

    def _cells(self, points: Floats) -> Ints:
        return np.floor((points - self._low) / self._cell).astype(np.int64)


def _spread(triangles: Floats, spacing: float) -> tuple[Floats, Ints]:
    """Points (k, 3) on triangles (n, 3, 3) no further apart than that [m], and whose (k,)."""
    edges = np.roll(triangles, -1, axis=1) - triangles
    sizes = np.linalg.norm(edges, axis=2)
    # The longest edge first: across it a sliver needs few rows.
    first = sizes.argmax(axis=1)
    rows = np.arange(len(triangles))
    a = triangles[rows, first]
    along, across = edges[rows, first], -edges[rows, (first + 2) % 3]
    base = sizes[rows, first]
    height = np.linalg.norm(np.cross(along, across), axis=1) / np.maximum(base, 1e-12)
    columns = np.ceil(base / spacing).astype(int) + 1
    levels = np.ceil(height / spacing).astype(int) + 1
    count = columns * levels
    of = np.repeat(rows, count)
    number = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
    u = (number % columns[of]) / np.maximum(columns[of] - 1, 1)
    v = (number // columns[of]) / np.maximum(levels[of] - 1, 1)
    # A last row would be one point, many times; the corner is there once as well.
    points = a[of] + v[:, None] * across[of] + (u * (1 - v))[:, None] * along[of]
    keep = (v < 1) | (number % columns[of] == 0)
    return points[keep], of[keep]

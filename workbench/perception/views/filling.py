"""Sparse clouds, filled in: between points that lie on one surface that surface is drawn.

Depth images need pixels that are finer than a part's features; a cloud that was thinned has fewer
points than that.  Each empty pixel near a point gets the plane through the points around it that
lie on the surface of the nearest one.  So a surface ends half-way between its last point and the
first one of the next, which is where it ends on average.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.perception.views.camera import are_within, picture_bounds, picture_of

FILLED_SPACINGS = 1.2
"""Spacings of the points up to which a pixel is filled from its nearest point."""

SURFACE_SPACINGS = 2.0
"""Spacings within which points may lie on the same surface."""

STEEPEST_SURFACE = 0.7
"""Depth over width up to which two points may lie on one surface."""

MOST_PIXELS_BETWEEN = 4.0
"""Pixels between neighbouring points at most: more would not make it finer."""

SAME_SURFACE_SHARE = 0.15
"""Depths that differ by less than this share of the points' distance lie on one surface."""

POINTS_A_SQUARE = 8.0
"""Points that the squares in which they are counted hold on average."""

MOST_PIXELS = 1_000_000


def densify(points: Floats, pitch: float) -> Floats:
    """The points, and those that are filled in where they are further apart than is wanted.

    Args:
        points: (n, 3) [m] in the camera's frame, before it.
        pitch: [m] wanted distance of neighbouring points.

    Returns:
        (m, 3) [m] the points themselves come first; all of them where they are dense enough.
    """
    spacing, low, high = spacing_of(points)
    distance = float(np.median(points[:, 2]))
    step = max(
        pitch / distance, spacing / MOST_PIXELS_BETWEEN, np.sqrt(np.prod(high - low) / MOST_PIXELS)
    )
    if not 0.0 < step < spacing:
        return points
    columns, rows = np.ceil((high - low) / step).astype(int) + 1
    gate = SAME_SURFACE_SHARE * spacing * distance
    filled = fill_in(points, low, float(step), spacing / step, gate, (int(rows), int(columns)))
    return np.concatenate([points, filled])


def spacing_of(points: Floats) -> tuple[float, Floats, Floats]:
    """How far apart points (n, 3) [m] are on the plane z = 1, where most of them lie.

    Returns:
        The distance of neighbours, and the corners (2,) of their picture; no unit.
    """
    image = picture_of(points)
    low, high = picture_bounds(image)
    image = image[are_within(image, low, high)]
    side = float(np.sqrt(np.prod(high - low) * POINTS_A_SQUARE / len(image)))
    if not side > 0.0:
        return 0.0, low, high
    at = ((image - low) / side).astype(np.int64)
    cell = at[:, 0] * (at[:, 1].max() + 1) + at[:, 1]
    held = np.bincount(cell)
    return side / float(np.sqrt(np.median(held[cell]))), low, high


@njit(cache=True)
def fill_in(
    points: Floats, low: Floats, step: float, spacing: float, gate: float, shape: tuple[int, int]
) -> Floats:  # pragma: no cover (compiled)
    """The points that lie between points of one surface, one for each empty pixel.

    Args:
        points: (n, 3) [m] in the camera's frame, before it.
        low: (2,) corner of the picture, on the plane z = 1.
        step: width of a pixel on that plane.
        spacing: [pixels] distance of neighbouring points.
        gate: [m] depths that differ by less lie on one surface.
        shape: rows and columns of the picture.

    Returns:
        (m, 3) [m] in the same frame, without the points given.
    """
    rows, columns = shape
    held = np.full((rows, columns), -1)
    for k in range(len(points)):
        u = int((points[k, 0] / points[k, 2] - low[0]) / step)
        v = int((points[k, 1] / points[k, 2] - low[1]) / step)
        is_in = 0 <= u < columns and 0 <= v < rows
        if is_in and (held[v, u] < 0 or points[k, 2] < points[held[v, u], 2]):
            held[v, u] = k
    filled = np.empty((rows * columns, 3))
    count = 0
    reach, around = FILLED_SPACINGS * spacing, int(np.ceil(SURFACE_SPACINGS * spacing))
    for v in range(rows):
        for u in range(columns):
            if held[v, u] >= 0:
                continue
            nearest, best = -1, reach * reach
            for j in range(max(v - around, 0), min(v + around + 1, rows)):
                for i in range(max(u - around, 0), min(u + around + 1, columns)):
                    away = float((j - v) ** 2 + (i - u) ** 2)
                    if held[j, i] >= 0 and away <= best:
                        nearest, best = held[j, i], away
            if nearest < 0:
                continue
            x, y = low[0] + (u + 0.5) * step, low[1] + (v + 0.5) * step
            z = _plane_at(points, held, nearest, (v, u), (x, y), around, step, gate)
            filled[count, 0], filled[count, 1], filled[count, 2] = x * z, y * z, z
            count += 1
    return filled[:count]


@njit(cache=True)
def _plane_at(
    points: Floats,
    held: np.ndarray,
    nearest: int,
    pixel: tuple[int, int],
    ray: tuple[float, float],
    around: int,
    step: float,
    gate: float,
) -> float:  # pragma: no cover (compiled)
    """Depth [m] along a ray of the plane through the nearest point's surface; 1/z is linear."""
    v, u = pixel
    z0 = points[nearest, 2]
    x0, y0 = points[nearest, 0] / z0, points[nearest, 1] / z0
    low, high = z0, z0
    n = sx = sy = sxx = sxy = syy = sd = sxd = syd = 0.0
    for j in range(max(v - around, 0), min(v + around + 1, held.shape[0])):
        for i in range(max(u - around, 0), min(u + around + 1, held.shape[1])):
            k = held[j, i]
            if k < 0:
                continue
            z = points[k, 2]
            x, y = points[k, 0] / z - ray[0], points[k, 1] / z - ray[1]
            wide = np.sqrt((points[k, 0] / z - x0) ** 2 + (points[k, 1] / z - y0) ** 2) * z0
            if abs(z - z0) > gate + STEEPEST_SURFACE * wide:
                continue
            low, high = min(low, z), max(high, z)
            weight = 1.0 / (1.0 + (x * x + y * y) / (step * step))
            d = 1.0 / z - 1.0 / z0
            n += weight
            sx += weight * x
            sy += weight * y
            sxx += weight * x * x
            sxy += weight * x * y
            syy += weight * y * y
            sd += weight * d
            sxd += weight * x * d
            syd += weight * y * d
    sxx -= sx * sx / n
    sxy -= sx * sy / n
    syy -= sy * sy / n
    sxd -= sx * sd / n
    syd -= sy * sd / n
    determinant = sxx * syy - sxy * sxy
    if determinant < 1e-3 * (sxx + syy) ** 2 or determinant == 0.0:
        return z0
    a = (sxd * syy - syd * sxy) / determinant
    b = (syd * sxx - sxd * sxy) / determinant
    found = 1.0 / (1.0 / z0 + (sd - a * sx - b * sy) / n)
    return min(max(found, low), high)

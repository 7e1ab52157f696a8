"""Depth images of points: what each pixel of a camera measured, and the normals there."""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats


@njit(cache=True)
def averaged(
    points: Floats, centres: Floats, focal: float, column: float, row: float, gate: float
) -> tuple[Floats, Floats]:  # pragma: no cover (compiled)
    """Rays and depths from the points of each pixel that are within `gate` of the nearest.

    Args:
        points: (n, 3) [m] in the camera's frame, before it.
        centres: (rows, columns, 3) rays through the pixels' centres, z = 1.
        focal: [pixels].
        column: where the optical axis passes.
        row: where the optical axis passes.
        gate: [m] what lies further behind the nearest point of its pixel is left out.

    Returns:
        The rays (rows, columns, 3) through the means of the points, z = 1, or the centres where
        there are none; and the depths (rows, columns) [m] along z, 0 where there are none.
    """
    rows, columns = centres.shape[:2]
    nearest = np.full((rows, columns), np.inf)
    for k in range(len(points)):
        u = int(np.rint(points[k, 0] / points[k, 2] * focal + column))
        v = int(np.rint(points[k, 1] / points[k, 2] * focal + row))
        if 0 <= u < columns and 0 <= v < rows:
            nearest[v, u] = min(nearest[v, u], points[k, 2])
    total = np.zeros((rows, columns, 4))
    for k in range(len(points)):
        x, y, z = points[k]
        u = int(np.rint(x / z * focal + column))
        v = int(np.rint(y / z * focal + row))
        if 0 <= u < columns and 0 <= v < rows and z <= nearest[v, u] + gate:
            total[v, u, 0] += x
            total[v, u, 1] += y
            total[v, u, 2] += z
            total[v, u, 3] += 1.0
    rays = centres.copy()
    depth = np.zeros((rows, columns))
    for v in range(rows):
        for u in range(columns):
            if total[v, u, 3] > 0:
                depth[v, u] = total[v, u, 2] / total[v, u, 3]
                rays[v, u, 0] = total[v, u, 0] / total[v, u, 2]
                rays[v, u, 1] = total[v, u, 1] / total[v, u, 2]
    return rays, depth


@njit(cache=True)
def normals_of(
    rays: Floats, depth: Floats, half: int, gate: float
) -> Floats:  # pragma: no cover (compiled)
    """Normals of planes fitted in windows of `half` pixels to each side.

    Over the image of a plane, 1/z is a linear function a x + b y + c of the ray (x, y, 1);
    (a, b, c) is the plane's normal: three unknowns, and no eigenvalue problem.

    Args:
        rays: (rows, columns, 3), z = 1.
        depth: (rows, columns) [m] along z, 0 where nothing was measured.
        half: [pixels].
        gate: [m] neighbours whose depths differ by more belong to something else.

    Returns:
        (rows, columns, 3), looking at the camera; zero where unknown.
    """
    rows, columns = depth.shape
    normals = np.zeros((rows, columns, 3))
    for v in range(rows):
        for u in range(columns):
            z0 = depth[v, u]
            if z0 == 0.0:
                continue
            x0, y0 = rays[v, u, 0], rays[v, u, 1]
            n = sx = sy = sxx = sxy = syy = sd = sxd = syd = 0.0
            for j in range(max(v - half, 0), min(v + half + 1, rows)):
                for i in range(max(u - half, 0), min(u + half + 1, columns)):
                    z = depth[j, i]
                    if z == 0.0 or abs(z - z0) > gate:
                        continue
                    x, y, d = rays[j, i, 0] - x0, rays[j, i, 1] - y0, 1.0 / z - 1.0 / z0
                    n += 1.0
                    sx += x
                    sy += y
                    sxx += x * x
                    sxy += x * y
                    syy += y * y
                    sd += d
                    sxd += x * d
                    syd += y * d
            if n < 6.0:
                continue
            sxx -= sx * sx / n
            sxy -= sx * sy / n
            syy -= sy * sy / n
            sxd -= sx * sd / n
            syd -= sy * sd / n
            determinant = sxx * syy - sxy * sxy
            if determinant < 1e-3 * (sxx + syy) ** 2:  # nearly on one line
                continue
            a = (sxd * syy - syd * sxy) / determinant
            b = (syd * sxx - sxd * sxy) / determinant
            c = 1.0 / z0 + (sd - a * sx - b * sy) / n - a * x0 - b * y0
            length = np.sqrt(a * a + b * b + c * c)
            normals[v, u, 0] = -a / length
            normals[v, u, 1] = -b / length
            normals[v, u, 2] = -c / length
    return normals

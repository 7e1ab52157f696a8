"""Depth pictures of a mesh at a pose, drawn triangle by triangle: what a camera would see of it.

With a few hundred triangles in a window of some thousand pixels this is ten times as fast as
casting a ray through each pixel.
"""

import numpy as np
from numba import njit, uint64

from workbench.model.geometry import Floats, Ints
from workbench.perception.views.motions import motion_of, moved

NARROW_TRIANGLE = 6
"""[pixels] Of triangles up to this width all pixels around are tried: that is less work than to
find out where each row begins and ends."""


@njit(cache=True)
def rendered(
    T: Floats,
    vertices: Floats,
    triangles: Ints,
    is_closed: bool,
    rays: Floats,
    focal: float,
    column: float,
    row: float,
) -> tuple[int, int, Floats, Ints, Floats]:  # pragma: no cover (compiled)
    """The window that holds the part, and what is in it.

    Args:
        T: (4, 4) pose of the mesh in the camera's frame.
        vertices: (n, 3) [m].
        triangles: (m, 3).
        is_closed: triangles that look away are left out.
        rays: (rows, columns, 3), z = 1; each passes through its own pixel, not always its middle.
        focal: [pixels].
        column: where the optical axis passes.
        row: where the optical axis passes.

    Returns:
        First row and column of the window; depths (h, w) [m] along the rays, infinite where
        nothing is hit, and which triangle is; the normals (m, 3) of the triangles that are drawn,
        facing the camera; those that nothing shows are not set.
    """
    rows, columns = rays.shape[:2]
    seen = np.empty((len(vertices), 5))  # x, y, z, and x, y in pixels
    low_u, high_u, low_v, high_v = np.inf, -np.inf, np.inf, -np.inf
    motion = motion_of(T)
    for k in range(len(vertices)):
        x, y, z = moved(motion, (vertices[k, 0], vertices[k, 1], vertices[k, 2]))
        if z <= 1e-9:  # reaches behind the camera
            return 0, 0, np.empty((0, 0)), np.empty((0, 0), np.int32), np.empty((0, 3))
        u, v = x / z * focal + column, y / z * focal + row
        seen[k, 0], seen[k, 1], seen[k, 2], seen[k, 3], seen[k, 4] = x, y, z, u, v
        low_u, high_u = min(low_u, u), max(high_u, u)
        low_v, high_v = min(low_v, v), max(high_v, v)
    first_u, first_v = max(int(low_u - 0.5), 0), max(int(low_v - 0.5), 0)
    wide = max(0, min(int(high_u + 1.5), columns) - first_u)
    high = max(0, min(int(high_v + 1.5), rows) - first_v)
    depth = np.full((high, wide), np.inf)
    hit = np.full((high, wide), -1, np.int32)
    planes = np.empty((len(triangles), 3))
    # One loop and unsigned indices: calls that take arrays, and indices that may be negative, cost
    # more than the arithmetic.
    for k in range(len(triangles)):
        a, b, c = uint64(triangles[k, 0]), uint64(triangles[k, 1]), uint64(triangles[k, 2])
        ax, ay, az = seen[a, 0], seen[a, 1], seen[a, 2]
        bx, by, bz = seen[b, 0], seen[b, 1], seen[b, 2]
        cx, cy, cz = seen[c, 0], seen[c, 1], seen[c, 2]
        n0 = (by - ay) * (cz - az) - (bz - az) * (cy - ay)
        n1 = (bz - az) * (cx - ax) - (bx - ax) * (cz - az)
        n2 = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        away = n0 * ax + n1 * ay + n2 * az
        if away == 0.0 or (is_closed and away > 0.0):
            continue
        au, av, bu, bv, cu, cv = (
            seen[a, 3],
            seen[a, 4],
            seen[b, 3],
            seen[b, 4],
            seen[c, 3],
            seen[c, 4],
        )
        first = max(int(np.rint(min(av, bv, cv))) - first_v, 0)
        last = min(int(np.rint(max(av, bv, cv))) + 1 - first_v, high)
        first_start = max(int(np.rint(min(au, bu, cu))) - first_u, 0)
        last_end = min(int(np.rint(max(au, bu, cu))) + 1 - first_u, wide)
        # Planes through the camera and each edge: a ray is inside when all say so.
        side = 1.0 if away < 0.0 else -1.0
        p0, p1, p2 = _cross(side, bx, by, bz, cx, cy, cz)
        q0, q1, q2 = _cross(side, cx, cy, cz, ax, ay, az)
        r0, r1, r2 = _cross(side, ax, ay, az, bx, by, bz)
        is_wide = last_end - first_start > NARROW_TRIANGLE
        ab, bc, ca = 0.0, 0.0, 0.0
        if is_wide:
            ab, bc, ca = _slope(au, av, bu, bv), _slope(bu, bv, cu, cv), _slope(cu, cv, au, av)
        is_drawn = False
        for v in range(first, last):
            start, end = first_start, last_end
            if is_wide:
                # What of the triangle lies within half a pixel of this row.
                at = float(v + first_v)
                left, right = _span(au, av, bu, bv, ab, at, np.inf, -np.inf)
                left, right = _span(bu, bv, cu, cv, bc, at, left, right)
                left, right = _span(cu, cv, au, av, ca, at, left, right)
                if left > right:
                    continue
                start = max(int(np.floor(left + 0.5)) - first_u, 0)
                end = min(int(np.floor(right + 0.5)) + 1 - first_u, wide)
            for u in range(start, end):
                j, i = uint64(v + first_v), uint64(u + first_u)
                x, y = rays[j, i, uint64(0)], rays[j, i, uint64(1)]
                if (
                    p0 * x + p1 * y + p2 > 0.0
                    or q0 * x + q1 * y + q2 > 0.0
                    or r0 * x + r1 * y + r2 > 0.0
                ):
                    continue
                z = away / (n0 * x + n1 * y + n2)
                if z < depth[uint64(v), uint64(u)]:
                    depth[uint64(v), uint64(u)] = z
                    hit[uint64(v), uint64(u)] = k
                    is_drawn = True
        if is_drawn:
            length = side * np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            planes[k, 0], planes[k, 1], planes[k, 2] = n0 / length, n1 / length, n2 / length
    return first_v, first_u, depth, hit, planes


@njit(cache=True)
def _cross(
    side: float, ax: float, ay: float, az: float, bx: float, by: float, bz: float
) -> tuple[float, float, float]:  # pragma: no cover (compiled)
    return side * (ay * bz - az * by), side * (az * bx - ax * bz), side * (ax * by - ay * bx)


@njit(cache=True)
def _slope(u0: float, v0: float, u1: float, v1: float) -> float:  # pragma: no cover (compiled)
    """Columns a row along an edge; zero for one that lies in a row."""
    return (u1 - u0) / (v1 - v0) if v1 != v0 else 0.0


@njit(cache=True)
def _span(
    u0: float, v0: float, u1: float, v1: float, slope: float, row: float, left: float, right: float
) -> tuple[float, float]:  # pragma: no cover (compiled)
    """Widen `left` and `right` by the part of an edge within half a pixel of a row."""
    low, high = max(row - 0.5, min(v0, v1)), min(row + 0.5, max(v0, v1))
    if low > high:
        return left, right
    if v0 == v1:
        return min(left, u0, u1), max(right, u0, u1)
    start, end = u0 + (low - v0) * slope, u0 + (high - v0) * slope
    return min(left, start, end), max(right, start, end)

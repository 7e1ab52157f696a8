"""Rays against the surface of a part, and the nearest point on it: compiled.

A part has some hundred triangles and is asked about in batches: rays go through all of them in
some microseconds.  Nearest points pass over groups of triangles that are too far away, since
meshes of scanners and catalogues have 100,000.  Both give the same answer on every processor
(decision 1).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints, Mesh

NO_TRIANGLE = -1
"""The triangle that a ray without a hit met."""

TRIANGLES_A_SPHERE = 24
"""Neighbouring triangles that one sphere stands for when the nearest point is searched for."""

ROUNDING = 1e-12
"""[m] By which distances from spheres may be rounded."""

ON_EDGE = 1e-9
"""Barycentric coordinates this far below zero are on the edge: no ray slips between two."""


@dataclass(frozen=True, slots=True)
class RayGrid:
    """Parallel rays: cell (i, k) stands at `u + i * step`, `v + k * step` [m]."""

    u: float
    v: float
    step: float
    shape: tuple[int, int]

    @property
    def centres(self) -> tuple[Floats, Floats]:
        """U and v of the cells, each of the grid's shape."""
        us = self.u + self.step * np.arange(self.shape[0])
        vs = self.v + self.step * np.arange(self.shape[1])
        return tuple(np.meshgrid(us, vs, indexing="ij"))  # type: ignore[return-value]


def normals_of(mesh: Mesh) -> tuple[Floats, Floats]:
    """Outward unit normals (m, 3) and areas (m,) [m2]; the normal of a flat triangle is 0."""
    a, b, c = mesh.points[mesh.triangles.T]
    across = np.cross(b - a, c - a)
    length = np.linalg.norm(across, axis=1)
    return across / np.maximum(length, 1e-30)[:, None], length / 2


def centre_of_mass(mesh: Mesh) -> Floats:
    """Of an evenly filled body (3,) [m]; of its surface when that encloses nothing."""
    a, b, c = mesh.points[mesh.triangles.T]
    middle = mesh.points.mean(axis=0)
    volumes = np.einsum("ij,ij->i", a - middle, np.cross(b - middle, c - middle)) / 6
    whole = float(volumes.sum())
    if whole > 1e-3 * float(np.prod(np.ptp(mesh.points, axis=0))):
        return middle + volumes @ ((a + b + c - 3 * middle) / 4) / whole
    _, areas = normals_of(mesh)
    return areas @ ((a + b + c) / 3) / areas.sum()


def samples_of(mesh: Mesh, count: int, rng: np.random.Generator) -> tuple[Floats, Ints]:
    """Points (count, 3) [m] spread evenly over a surface, and the triangle of each."""
    _, areas = normals_of(mesh)
    # Strata instead of independent draws: small faces are not missed by chance.
    shares = (np.arange(count) + rng.uniform(size=count)) / count
    ends = np.cumsum(areas)
    triangles = np.minimum(np.searchsorted(ends, shares * ends[-1]), len(areas) - 1)
    s, t = rng.uniform(size=(2, count))
    s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
    a, b, c = mesh.points[mesh.triangles[triangles].T]
    return a + s[:, None] * (b - a) + t[:, None] * (c - a), triangles


def first_hits(mesh: Mesh, origins: Floats, directions: Floats) -> tuple[Floats, Ints]:
    """Where rays first meet the surface.

    Args:
        mesh: the surface.
        origins: (n, 3) [m].
        directions: (n, 3), unit.

    Returns:
        Distances (n,) [m], infinite without a hit, and triangles (n,), `NO_TRIANGLE` without one.
    """
    return _first_hits(
        np.asarray(mesh.points),
        np.asarray(mesh.triangles),
        np.ascontiguousarray(origins),
        np.ascontiguousarray(directions),
    )


class MeshSurface:
    """The surface of a mesh, made ready once to be asked for its nearest points many times.

    Triangles without an area have no normal and are passed over: in a closed surface their
    neighbours have the same points.
    """

    def __init__(self, mesh: Mesh):
        from scipy.spatial import KDTree  # takes a while, and planning asks for no nearest points

        solid = np.flatnonzero(normals_of(mesh)[1] > 0)
        corners = mesh.points[mesh.triangles[solid]]
        order = KDTree(corners.mean(axis=1), leafsize=TRIANGLES_A_SPHERE).indices
        self._numbers = solid[order]
        self._corners = np.ascontiguousarray(corners[order])
        centres, radii = _spheres(self._corners)
        starts = np.arange(0, len(order), TRIANGLES_A_SPHERE)
        ends = np.append(starts[1:], len(order))
        groups = [
            _sphere_around(centres[i:k], radii[i:k]) for i, k in zip(starts, ends, strict=True)
        ]
        self._spheres = (
            centres,
            radii,
            np.array([p for p, _ in groups]),
            np.array([r for _, r in groups]),
        )

    def nearest(self, points: Floats) -> tuple[Floats, Floats, Ints]:
        """The nearest points (n, 3) to others (n, 3), distances (n,), all [m], and triangles (n,).

        Of triangles that are equally near the first of the mesh counts.
        """
        points = np.ascontiguousarray(points, np.float64)
        return _nearest(self._corners, self._numbers, *self._spheres, points)


def nearest_points(mesh: Mesh, points: Floats) -> tuple[Floats, Floats, Ints]:
    """For one question: points (n, 3) nearest to others (n, 3), distances (n,) [m], triangles."""
    return MeshSurface(mesh).nearest(points)


def _spheres(corners: Floats) -> tuple[Floats, Floats]:
    """Centres (m, 3) and radii (m,) [m] of spheres around triangles with corners (m, 3, 3)."""
    centres = corners.mean(axis=1)
    return centres, np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)


def _sphere_around(centres: Floats, radii: Floats) -> tuple[Floats, float]:
    """A sphere around spheres at centres (k, 3) with radii (k,), all [m]."""
    middle = (centres.min(axis=0) + centres.max(axis=0)) / 2
    return middle, float((np.linalg.norm(centres - middle, axis=1) + radii).max())


def tops(
    points: Floats, triangles: Ints, grid: RayGrid, limits: Floats, sense: float
) -> tuple[Floats, Ints]:
    """What something that comes down each ray of a grid, from its limit on, meets first.

    A limit inside of the part counts from where the ray leaves it further up, so that what is met
    may lie beyond it.

    Args:
        points: (n, 3) [m] of the surface, in a frame whose third axis the rays are parallel to.
        triangles: (m, 3).
        grid: of the rays, along the first two axes.
        limits: of the grid's shape [m], times `sense`; NaN where there is no ray.
        sense: 1.0 when rays come down the third axis, -1.0 when they come up it.

    Returns:
        Heights times `sense` [m], NaN where nothing is met, and the triangles met.
    """
    return _tops(points, triangles, grid.u, grid.v, grid.step, limits, sense)


@njit(cache=True)
def _tops(
    P: Floats, triangles: Ints, u: float, v: float, step: float, limits: Floats, sense: float
) -> tuple[Floats, Ints]:
    rows, columns = limits.shape
    below, above = np.full((rows, columns), -np.inf), np.full((rows, columns), np.inf)
    at_below = np.full((rows, columns), NO_TRIANGLE)
    at_above = np.full((rows, columns), NO_TRIANGLE)
    leaves = np.zeros((rows, columns), np.bool_)
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        au, av, bu, bv, cu, cv = P[a, 0], P[a, 1], P[b, 0], P[b, 1], P[c, 0], P[c, 1]
        twice = (bu - au) * (cv - av) - (cu - au) * (bv - av)
        if abs(twice) < 1e-18:
            continue  # seen from its edge
        i0 = max(0, int(np.ceil((min(au, bu, cu) - u) / step - 1e-6)))
        i1 = min(rows - 1, int(np.floor((max(au, bu, cu) - u) / step + 1e-6)))
        k0 = max(0, int(np.ceil((min(av, bv, cv) - v) / step - 1e-6)))
        k1 = min(columns - 1, int(np.floor((max(av, bv, cv) - v) / step + 1e-6)))
        faces = twice * sense > 0
        for i in range(i0, i1 + 1):
            x = u + i * step
            for k in range(k0, k1 + 1):
                if np.isnan(limits[i, k]):
                    continue
                y = v + k * step
                s = ((cu - bu) * (y - bv) - (x - bu) * (cv - bv)) / twice
                r = ((au - cu) * (y - cv) - (x - cu) * (av - cv)) / twice
                if s < -ON_EDGE or r < -ON_EDGE or s + r > 1 + ON_EDGE:
                    continue
                h = sense * (s * P[a, 2] + r * P[b, 2] + (1 - s - r) * P[c, 2])
                if h <= limits[i, k]:
                    if faces and h > below[i, k]:
                        below[i, k], at_below[i, k] = h, t
                elif h < above[i, k]:
                    above[i, k], at_above[i, k], leaves[i, k] = h, t, faces
    for i in range(rows):
        for k in range(columns):
            if leaves[i, k]:
                below[i, k], at_below[i, k] = above[i, k], at_above[i, k]
            if at_below[i, k] == NO_TRIANGLE:
                below[i, k] = np.nan
    return below, at_below


@njit(cache=True)
def _first_hits(
    P: Floats, triangles: Ints, origins: Floats, directions: Floats
) -> tuple[Floats, Ints]:
    """Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997)."""
    distances = np.full(len(origins), np.inf)
    met = np.full(len(origins), NO_TRIANGLE)
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ex, ey, ez = P[b, 0] - P[a, 0], P[b, 1] - P[a, 1], P[b, 2] - P[a, 2]
        fx, fy, fz = P[c, 0] - P[a, 0], P[c, 1] - P[a, 1], P[c, 2] - P[a, 2]
        for n in range(len(origins)):
            dx, dy, dz = directions[n, 0], directions[n, 1], directions[n, 2]
            px, py, pz = dy * fz - dz * fy, dz * fx - dx * fz, dx * fy - dy * fx
            det = ex * px + ey * py + ez * pz
            if abs(det) < 1e-20:
                continue
            x, y, z = origins[n, 0] - P[a, 0], origins[n, 1] - P[a, 1], origins[n, 2] - P[a, 2]
            s = (x * px + y * py + z * pz) / det
            if s < -ON_EDGE or s > 1 + ON_EDGE:
                continue
            qx, qy, qz = y * ez - z * ey, z * ex - x * ez, x * ey - y * ex
            r = (dx * qx + dy * qy + dz * qz) / det
            if r < -ON_EDGE or s + r > 1 + ON_EDGE:
                continue
            distance = (fx * qx + fy * qy + fz * qz) / det
            if 0.0 <= distance < distances[n]:
                distances[n], met[n] = distance, t
    return distances, met


@njit(cache=True)
def _nearest(
    corners: Floats,
    numbers: Ints,
    centres: Floats,
    radii: Floats,
    middles: Floats,
    reaches: Floats,
    points: Floats,
) -> tuple[Floats, Floats, Ints]:
    found, distances = np.empty((len(points), 3)), np.full(len(points), np.inf)
    triangles = np.full(len(points), NO_TRIANGLE)
    least = np.empty(len(middles))
    for n in range(len(points)):
        for g in range(len(middles)):
            least[g] = _apart(middles[g], points[n]) - reaches[g]
        first = int(np.argmin(least))
        _nearest_of(
            corners,
            numbers,
            centres,
            radii,
            first,
            points[n],
            found[n],
            distances[n : n + 1],
            triangles[n : n + 1],
        )
        for g in range(len(middles)):
            if g != first and least[g] <= distances[n] + ROUNDING:
                _nearest_of(
                    corners,
                    numbers,
                    centres,
                    radii,
                    g,
                    points[n],
                    found[n],
                    distances[n : n + 1],
                    triangles[n : n + 1],
                )
    return found, distances, triangles


@njit(cache=True)
def _nearest_of(
    corners: Floats,
    numbers: Ints,
    centres: Floats,
    radii: Floats,
    group: int,
    point: Floats,
    found: Floats,
    distance: Floats,
    triangle: Ints,
) -> None:
    """Take over what is nearer, or as near with a lower number, among one group of triangles."""
    q = np.empty(3)
    for t in range(group * TRIANGLES_A_SPHERE, min((group + 1) * TRIANGLES_A_SPHERE, len(corners))):
        if _apart(centres[t], point) > distance[0] + radii[t] + ROUNDING:
            continue
        _on_triangle(corners[t], point, q)
        d = _apart(q, point)
        if d < distance[0] or (d == distance[0] and numbers[t] < triangle[0]):
            distance[0], triangle[0] = d, numbers[t]
            for i in range(3):
                found[i] = q[i]


@njit(cache=True)
def _apart(p: Floats, q: Floats) -> float:
    return np.sqrt((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2)


@njit(cache=True)
def _on_triangle(corners: Floats, point: Floats, q: Floats) -> None:
    """Write the nearest point; regions after Ericson, "Real-Time Collision Detection", 5.1.5."""
    d1, d2, d3, d4, d5, d6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        a, b, c, p = corners[0, i], corners[1, i], corners[2, i], point[i]
        ab, ac = b - a, c - a
        d1 += ab * (p - a)
        d2 += ac * (p - a)
        d3 += ab * (p - b)
        d4 += ac * (p - b)
        d5 += ab * (p - c)
        d6 += ac * (p - c)
    vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
    if d1 <= 0 and d2 <= 0:
        s, r = 0.0, 0.0
    elif d3 >= 0 and d4 <= d3:
        s, r = 1.0, 0.0
    elif d6 >= 0 and d5 <= d6:
        s, r = 0.0, 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        s, r = d1 / (d1 - d3), 0.0
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        s, r = 0.0, d2 / (d2 - d6)
    elif va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        r = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s = 1.0 - r
    else:
        whole = va + vb + vc
        s, r = (vb / whole, vc / whole) if whole > 0 else (0.0, 0.0)
    for i in range(3):
        a = corners[0, i]
        q[i] = a + s * (corners[1, i] - a) + r * (corners[2, i] - a)

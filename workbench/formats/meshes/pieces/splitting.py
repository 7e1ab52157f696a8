"""A mesh split by planes until the hulls of what lies between them follow it closely.

Every triangle is cut where a plane goes through it, so that the hulls cover the whole surface: a
piece may only be too large, never too small.  Robots' links are made of blocks and tubes, which a
few planes part; that takes a hundredth of the time of a search for the fewest pieces.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from workbench.formats.meshes.pieces.cutting import bounded, hull_mesh
from workbench.formats.meshes.pieces.surfaces import Surface
from workbench.formats.meshes.reading import convex_hull
from workbench.model.geometry import Floats, Mesh

ON_HULL = 500
"""Points on a hull at which its distance from the mesh is measured while it is split."""
ON_PAIR = 200
"""The same, of two pieces that could be one."""
IN_CLOUD = 1_500
"""Points on a part of the surface, by which planes are compared."""
IN_ALL = 6_000
"""Points on all hulls at which it is measured in the end."""

SHARES = (0.15, 0.3, 0.5, 0.7, 0.85)
"""Of the extent along an axis: where a plane may go through, beside the deepest hollow."""

NEAR = 1e-6
"""[m] Corners that are no further from a plane lie in it."""

MOST_CORNERS = 300
"""Of a piece."""

OVER = 2
"""So many times as many pieces are split as are left when those that can be one are."""

HOLLOW = 0.9
"""Share of the tolerance that hollows may take; the rest is for leaving out corners."""

JOINED = 1e-5
"""[m] Corners this close are one: files give each triangle corners of its own."""

THINNEST = 0.2
"""What is cut off is thicker than this share of the tolerance."""

THICK = 5e-5
"""[m] Half the thickness of the hull of something flat."""

TOUCHING = 0.002
"""[m] What lies within another piece, or no further from it, is a cut between two pieces."""

AROUND = 40
"""Points of the surface about a hollow, whose faces may be cut along."""


@dataclass(frozen=True, slots=True, eq=False)
class _Plane:
    """Points with `normal` @ p = `offset` [m]."""

    normal: Floats
    offset: float


@dataclass(slots=True, eq=False)
class _Piece:
    """A part of the surface between planes: triangles (n, 3, 3) [m] and their hull."""

    soup: Floats
    planes: tuple[_Plane, ...]
    hull: ConvexHull = field(init=False)
    excess: float = field(init=False)
    hollow: Floats = field(init=False)
    """Where of the hull the mesh is furthest away (3,)."""

    def __post_init__(self) -> None:
        self.hull = _hull_of(self.soup.reshape(-1, 3))


def split(mesh: Mesh, tolerance: float, most: int) -> tuple[tuple[Mesh, ...], float] | None:
    """Convex pieces that cover a mesh, and by how much they are larger [m]; None when it is flat.

    Args:
        mesh: any triangles; they need not close.
        tolerance: [m] pieces are split until none is by more too large.
        most: pieces at most.
    """
    if convex_hull(mesh) is None:
        return None
    surface = Surface(np.asarray(mesh.points)[np.asarray(mesh.triangles)])
    hollow = HOLLOW * tolerance
    done: list[_Piece] = []
    open_ones = [_measured(_Piece(soup, ()), surface) for soup in _bodies(surface.outer(), most)]
    while open_ones:
        worst = max(open_ones, key=lambda piece: piece.excess)
        open_ones.remove(worst)
        is_last = worst.excess <= hollow or len(done) + len(open_ones) + 2 > OVER * most
        parts = None if is_last else _parted(worst, surface, tolerance)
        if parts is None:
            done.append(worst)
        else:
            open_ones += parts
    corners = _joined(done, surface, hollow, most)
    close = (1 - HOLLOW) * tolerance
    meshes = tuple(bounded(hull_mesh(points), most=MOST_CORNERS, close=close) for points in corners)
    return meshes, _excess(meshes, surface)


def _bodies(triangles: Floats, most: int) -> list[Floats]:
    """The triangles (n, 3, 3) [m] of each body, small ones together with the one about them.

    So that there is one body only where nothing else is.
    """
    corners = np.round(triangles.reshape(-1, 3) / JOINED).astype(np.int64)
    joined = np.unique(corners, axis=0, return_inverse=True)[1].reshape(-1, 3)
    count = int(joined.max()) + 1
    ends = np.concatenate([joined[:, :2], joined[:, 1:]])
    graph = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    of = connected_components(graph, directed=False)[1][joined[:, 0]]
    order = np.argsort(of, kind="stable")
    soups = np.split(triangles[order], np.flatnonzero(np.diff(of[order])) + 1)
    soups.sort(key=lambda soup: -float(np.ptp(soup.reshape(-1, 3), axis=0).prod()))
    large, small = soups[: max(1, most // 2)], soups[max(1, most // 2) :]
    middles = np.array(
        [(s.reshape(-1, 3).max(axis=0) + s.reshape(-1, 3).min(axis=0)) / 2 for s in large]
    )
    for soup in small:
        middle = soup.reshape(-1, 3).mean(axis=0)
        nearest = int(np.linalg.norm(middles - middle, axis=1).argmin())
        large[nearest] = np.concatenate([large[nearest], soup])
    return large


def _parted(piece: _Piece, surface: Surface, tolerance: float) -> list[_Piece] | None:
    """The two parts with the smallest hulls; None when no plane makes them smaller."""
    points = piece.soup.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    cloud = _cloud(piece.soup)
    best, least = None, np.inf
    for plane in _candidates(surface, piece.hollow, low, high):
        away = cloud @ plane.normal - plane.offset
        corners = points @ plane.normal - plane.offset
        if corners.max() < THINNEST * tolerance or corners.min() > -THINNEST * tolerance:
            continue
        # Where a triangle goes through the plane the parts have corners that the cloud lacks.
        size = sum(_size(cloud[side], tolerance) for side in (away > 0, away <= 0))
        if size < least:
            best, least = plane, size
    if best is None:
        return None
    below, above = _clipped(piece.soup, best)
    if not len(below) or not len(above):
        return None
    parts = [
        _Piece(below, (*piece.planes, best)),
        _Piece(above, (*piece.planes, _Plane(-best.normal, -best.offset))),
    ]
    return [_measured(part, surface) for part in parts]


def _candidates(surface: Surface, hollow: Floats, low: Floats, high: Floats) -> Iterator[_Plane]:
    """Planes across the axes, and along the faces that make the deepest hollow."""
    near, normals = surface.around(hollow, AROUND)
    shares = [low + share * (high - low) for share in SHARES]
    for axis in range(3):
        for point in (*shares, *near[:1]):
            yield _Plane(np.eye(3)[axis], float(point[axis]))
    told: set[tuple[float, ...]] = set()
    for point, normal in zip(near, normals, strict=True):
        normal = normal * np.sign(normal[np.abs(normal).argmax()])
        plane = _Plane(normal, float(point @ normal))
        key = (*np.round(normal, 1).tolist(), round(plane.offset, 3))
        if key not in told:
            told.add(key)
            yield plane


def _measured(piece: _Piece, surface: Surface) -> _Piece:
    """The piece with its excess: how far its hull lies from the mesh, outside of it."""
    piece.excess, piece.hollow = surface.farthest(_on(piece.hull, ON_HULL))
    return piece


def _joined(pieces: list[_Piece], surface: Surface, tolerance: float, most: int) -> list[Floats]:
    """Corners (n, 3) of the hulls, those in one whose common hull is close enough to the mesh.

    Where they are more than `most`, also those whose common hull is the least too large.
    """
    hulls = dict(enumerate(piece.hull for piece in pieces))
    gaps = {pair: _gap(*(hulls[k] for k in pair)) for pair in combinations(hulls, 2)}
    measured: dict[tuple[int, int], float] = {}
    while gaps:
        so_far = {pair: measured.get(pair, gap) for pair, gap in gaps.items()}
        pair = min(so_far, key=so_far.__getitem__)
        if pair not in measured:
            both = _together(*(hulls[k] for k in pair))
            measured[pair] = max(gaps[pair], surface.farthest(_on(both, ON_PAIR))[0])
            continue
        if measured[pair] > tolerance and len(hulls) <= most:
            break
        new, both = max(hulls) + 1, _together(hulls.pop(pair[0]), hulls.pop(pair[1]))
        gaps = {two: gap for two, gap in gaps.items() if not set(two) & set(pair)}
        gaps |= {(k, new): _gap(hull, both) for k, hull in hulls.items()}
        hulls[new] = both
    return [hull.points[hull.vertices] for hull in hulls.values()]


def _gap(one: ConvexHull, other: ConvexHull) -> float:
    """How far the common hull of two lies outside of both, at least [m]."""
    low = np.maximum(one.min_bound, other.min_bound)
    if (low > np.minimum(one.max_bound, other.max_bound) + NEAR).any():
        return np.inf
    both = _together(one, other)
    return max(0.0, float((both.volume - one.volume - other.volume) / both.area))


def _together(one: ConvexHull, other: ConvexHull) -> ConvexHull:
    return ConvexHull(np.vstack([hull.points[hull.vertices] for hull in (one, other)]))


def _excess(meshes: tuple[Mesh, ...], surface: Surface) -> float:
    """How far the outside of all pieces lies from the mesh [m]."""
    hulls = [ConvexHull(mesh.points) for mesh in meshes]
    largest = 0.0
    for number, hull in enumerate(hulls):
        points = _on(hull, IN_ALL // len(hulls) + 50)
        for k, other in enumerate(hulls):
            if k != number:
                points = points[_outside(other, points) > TOUCHING]
        largest = max(largest, surface.farthest(points)[0] if len(points) else 0.0)
    return largest


def _clipped(soup: Floats, plane: _Plane) -> tuple[Floats, Floats]:
    """Triangles (n, 3, 3) below and above a plane; what it goes through is cut."""
    away = soup @ plane.normal - plane.offset
    away[np.abs(away) < NEAR] = 0.0
    is_below, is_above = (away <= 0).all(axis=1), (away >= 0).all(axis=1)
    through = ~is_below & ~is_above
    cut, off = soup[through], away[through]
    # The corner that is alone on its side comes first; one in the plane counts to the two.
    sign = np.sign(off)
    alone = np.argmax(
        sign * np.sign(sign.sum(axis=1) + 0.5 * sign.max(axis=1))[:, None] < 0, axis=1
    )
    order = (alone[:, None] + np.arange(3)) % 3
    rows = np.arange(len(cut))[:, None]
    cut, off = cut[rows, order], off[rows, order]
    a, b, c = np.moveaxis(cut, 1, 0)
    p = a + (b - a) * (off[:, :1] / (off[:, :1] - off[:, 1:2]))
    q = a + (c - a) * (off[:, :1] / (off[:, :1] - off[:, 2:3]))
    tips = np.stack([a, p, q], axis=1)
    rests = np.concatenate([np.stack([p, b, c], axis=1), np.stack([p, c, q], axis=1)])
    tip_below = off[:, 0] < 0
    rest_below = np.concatenate([~tip_below, ~tip_below])
    below = [soup[is_below], tips[tip_below], rests[rest_below]]
    above = [soup[is_above & ~is_below], tips[~tip_below], rests[~rest_below]]
    return np.concatenate(below), np.concatenate(above)


def _cloud(soup: Floats) -> Floats:
    """Points on triangles (n, 3, 3), and their corners (m, 3)."""
    surface = _surface_of(soup)
    points = trimesh.sample.sample_surface(surface, IN_CLOUD, seed=0)[0]
    corners = soup.reshape(-1, 3)
    return np.vstack([np.asarray(points), corners[:: max(1, len(corners) // IN_CLOUD)]])


def _surface_of(soup: Floats) -> trimesh.Trimesh:
    return trimesh.Trimesh(
        soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3), process=False
    )


def _hull_of(points: Floats) -> ConvexHull:
    """The hull of points (n, 3); of flat ones that of a thin sheet."""
    middle = points.mean(axis=0)
    axes = np.linalg.eigh((points - middle).T @ (points - middle))[1].T
    for axis, size in zip(axes, np.ptp((points - middle) @ axes.T, axis=0), strict=True):
        if size < 2 * THICK:
            points = np.vstack([points + THICK * axis, points - THICK * axis])
    return ConvexHull(points)


def _size(points: Floats, around: float) -> float:
    """The volume of the hull of points (n, 3), grown by so much [m], nearly [m3]."""
    if len(points) < 5:
        return 0.0
    try:
        hull = ConvexHull(points)
    except QhullError:
        return 0.0
    return float(hull.volume + around * hull.area)


def _on(hull: ConvexHull, count: int) -> Floats:
    """Points on a hull (n, 3), spread over its faces, and the middles of the largest of them."""
    corners = hull.points[hull.simplices]
    surface = _surface_of(corners)
    points = trimesh.sample.sample_surface(surface, count, seed=0)[0]
    largest = np.argsort(-surface.area_faces)[:count]
    return np.vstack([np.asarray(points), corners[largest].mean(axis=1)])


def _outside(hull: ConvexHull, points: Floats) -> Floats:
    """How far points (n, 3) lie outside of a hull [m]; negative inside."""
    return (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)

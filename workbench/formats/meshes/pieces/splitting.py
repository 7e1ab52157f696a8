"""A mesh split by planes until the hulls of what lies between them follow it closely.

Every triangle is cut where a plane goes through it, so that the hulls cover the whole surface: a
piece may only be too large, never too small.  Planes go through the deepest hollow, where they part
a bore into wedges, or along the faces that make it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from workbench.formats.meshes.pieces.hulls import (
    MOST_CORNERS,
    area_of,
    hull_mesh,
    hull_of,
    limit_corners,
    outside,
    points_for,
    points_on,
)
from workbench.formats.meshes.pieces.joining import TOUCHING_WITHIN, join_hulls
from workbench.formats.meshes.pieces.soups import Plane, bodies, clip_soup, cloud
from workbench.formats.meshes.pieces.surfaces import Surface
from workbench.formats.meshes.reading import convex_hull
from workbench.model.geometry import Floats, Mesh

ON_HULL = 400
"""Points on a hull at which its distance from the mesh is measured while it is split."""
IN_CLOUD = 400
"""Points on a part of the surface, by which planes are compared."""
SPACING = 0.5
"""Of the tolerance: how far apart points on the surface are, by which distances are found."""

THROUGH = 8
"""Planes through the deepest hollow."""

MOST_FACES = 8
"""Faces about the deepest hollow along which a plane may go, at most."""
SURFACE_POINTS = 40
"""Points of the surface at which they are searched for."""

GAINS = 0.05
"""Where no plane lowers the volume by this share of the cube of the depth of the hollow, one goes
through it: of a bore only the second cut lowers the volume."""

SKIN = 0.1
"""Of the tolerance: a hull counts as grown by this, so that cuts are short."""

HOLLOW = 0.9
"""Share of the tolerance that hollows may take; the rest is for leaving out corners."""

THINNEST = 0.2
"""What is cut off is thicker than this share of the tolerance."""

SEEN, MOST_SEEN = 0.0005, 100_000
"""[m] The tolerance for which bodies that others have made are checked; at this many points."""

KNOWN = 0.1
"""Share of the tolerance to which the excess is known in the end."""


@dataclass(slots=True, eq=False)
class _Piece:
    """A part of the surface between planes: triangles (n, 3, 3) [m] and their hull.

    `excess` [m]: how far the hull lies outside of the mesh; it does so most at `hollow` (3,) [m],
    where `normal` (3,) is that of the hull, no unit.
    """

    soup: Floats
    surface: Surface
    tolerance: float
    hull: ConvexHull = field(init=False)
    excess: float = field(init=False)
    hollow: Floats = field(init=False)
    normal: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.hull = hull_of(np.unique(self.soup.reshape(-1, 3), axis=0))
        faces = self.hull.points[self.hull.simplices]
        # A few points show most hulls to be too large; only of the others it has to be known.
        for count in (ON_HULL, points_for(self.hull.area, self.tolerance)):
            points, of = points_on(faces, count)
            self.excess, at = self.surface.farthest(points)
            self.hollow, self.normal = points[at], self.hull.equations[of[at], :3]
            if self.excess > HOLLOW * self.tolerance:
                break


def split(
    mesh: Mesh, tolerance: float, most: int, over: float
) -> tuple[tuple[Mesh, ...], float] | None:
    """Convex pieces that cover a mesh, and by how much they are larger [m]; None when it is flat.

    Args:
        mesh: any triangles; they need not close.
        tolerance: [m] pieces are split until none is by more too large.
        most: pieces at most.
        over: pieces into which it is split, per piece that may be left once some are joined.
    """
    whole = convex_hull(mesh)
    if whole is None:
        return None
    surface = _surface_of(mesh, tolerance)
    pieces = (_with_few_corners(np.asarray(whole.points), tolerance),)
    excess = _excess(pieces, surface, tolerance)
    if excess <= tolerance or most < 2:
        return pieces, excess
    hulls = join_hulls(
        _split_hulls(surface, tolerance, most, over), surface, HOLLOW * tolerance, most
    )
    pieces = tuple(_with_few_corners(hull.points[hull.vertices], tolerance) for hull in hulls)
    return pieces, _excess(pieces, surface, tolerance)


def group_pieces(
    mesh: Mesh, pieces: tuple[Mesh, ...], tolerance: float, most: int
) -> tuple[Mesh, ...]:
    """Convex meshes that go around pieces of a mesh, so that few bodies are checked first.

    Args:
        mesh: any triangles; they need not close.
        pieces: convex, and together around it.
        tolerance: [m] pieces are put into one group as long as it is by no more too large.
        most: groups at most; where needed they are larger.

    Returns:
        Hulls with the pieces that they go around; a piece that is alone is none's.
    """
    surface = _surface_of(mesh, tolerance)
    hulls = join_hulls([ConvexHull(piece.points) for piece in pieces], surface, tolerance, most)
    found: list[Mesh] = []
    left = list(pieces)
    for hull in hulls:
        inside = [piece for piece in left if (outside(hull, piece.points) <= TOUCHING_WITHIN).all()]
        left = [piece for piece in left if not any(piece is other for other in inside)]
        if len(inside) == 1:
            found += inside
        elif inside:
            around = hull_mesh(hull.points[hull.vertices])
            found.append(Mesh(around.points, around.triangles, True, tuple(inside)))
    return (*found, *left)


def _surface_of(mesh: Mesh, tolerance: float) -> Surface:
    """What of a mesh can be touched: faces within bodies would seem to have an outside there."""
    triangles = np.asarray(mesh.points)[np.asarray(mesh.triangles)]
    outer = Surface(triangles, spacing=SPACING * tolerance).outer()
    return Surface(outer if len(outer) else triangles, spacing=SPACING * tolerance)


def _split_hulls(surface: Surface, tolerance: float, most: int, over: float) -> list[ConvexHull]:
    """Hulls that cover the surface, each close to it, or `over * most` of them."""
    open_ones = [_Piece(soup, surface, tolerance) for soup in bodies(surface.triangles, most)]
    done: list[_Piece] = []
    while open_ones:
        worst = max(open_ones, key=lambda piece: piece.excess)
        open_ones.remove(worst)
        is_last = worst.excess <= HOLLOW * tolerance or len(done) + len(open_ones) + 2 > over * most
        parts = None if is_last else _split(worst, surface, tolerance)
        if parts is None:
            done.append(worst)
        else:
            open_ones += parts
    return [piece.hull for piece in done]


def _with_few_corners(points: Floats, tolerance: float) -> Mesh:
    return limit_corners(hull_mesh(points), most=MOST_CORNERS, close=(1 - HOLLOW) * tolerance)


def excess_of(mesh: Mesh, faces: Floats) -> float:
    """How far faces (n, 3, 3) [m] lie outside of a mesh at most [m], seen at points on them."""
    surface = _surface_of(mesh, SEEN)
    return surface.farthest(points_on(np.asarray(faces), MOST_SEEN)[0], KNOWN * SEEN)[0]


def _excess(pieces: tuple[Mesh, ...], surface: Surface, tolerance: float) -> float:
    """How far the outside of all pieces lies from the mesh [m]."""
    largest = 0.0
    for piece in pieces:
        faces = piece.points[piece.triangles]
        points = points_on(faces, points_for(area_of(faces), tolerance))[0]
        largest = max(largest, surface.farthest(points, max(largest, KNOWN * tolerance))[0])
    return largest


def _split(piece: _Piece, surface: Surface, tolerance: float) -> tuple[_Piece, _Piece] | None:
    """The piece in two by the plane that serves best; None when no plane goes through it."""
    corners, points = piece.soup.reshape(-1, 3), cloud(piece.soup, IN_CLOUD)

    def best_of(planes: Iterator[Plane]) -> tuple[float, Plane | None]:
        """The plane whose two parts have the smallest hulls, and their volume [m3]."""
        best, least = None, np.inf
        for plane in planes:
            away = corners @ plane.normal - plane.offset
            if min(away.max(), -away.min()) < THINNEST * tolerance:
                continue
            # Where a triangle goes through the plane the parts have corners that the cloud lacks.
            is_above = points @ plane.normal > plane.offset
            size = sum(_size(points[side], SKIN * tolerance) for side in (is_above, ~is_above))
            if size < least:
                best, least = plane, size
        return least, best

    least, plane = best_of(_planes_through(piece))
    other_least, other = best_of(_planes_beside(piece, surface))
    gains = piece.hull.volume - other_least >= GAINS * piece.excess**3
    if other is not None and (plane is None or (gains and other_least < least)):
        plane = other
    if plane is None:
        return None
    below, above = clip_soup(piece.soup, plane)
    if not len(below) or not len(above):
        return None
    return _Piece(below, surface, tolerance), _Piece(above, surface, tolerance)


def _planes_through(piece: _Piece) -> Iterator[Plane]:
    """Planes through the deepest hollow, straight into it, turned by equal steps."""
    across = np.cross(piece.normal, np.eye(3)[np.abs(piece.normal).argmin()])
    across /= np.linalg.norm(across)
    for angle in np.arange(THROUGH) * np.pi / THROUGH:
        normal = np.cos(angle) * across + np.sin(angle) * np.cross(piece.normal, across)
        yield Plane(normal, float(piece.hollow @ normal))


def _planes_beside(piece: _Piece, surface: Surface) -> Iterator[Plane]:
    """Planes across the axes at the bottom of the deepest hollow, and along the faces there."""
    near, normals = surface.around(piece.hollow, SURFACE_POINTS)
    for axis in np.eye(3):
        for point in near[:1]:
            yield Plane(axis, float(point @ axis))
    known: set[tuple[float, ...]] = set()
    for point, normal in zip(near, normals, strict=True):
        normal = normal * np.sign(normal[np.abs(normal).argmax()])
        offset = float(point @ normal)
        key = (*np.round(normal, 1).tolist(), round(offset, 4))
        if key not in known and len(known) < MOST_FACES:
            known.add(key)
            yield Plane(normal, offset)


def _size(points: Floats, around: float) -> float:
    """The volume of the hull of points (n, 3), grown by so much [m], nearly [m3]."""
    if len(points) < 5:
        return 0.0
    try:
        hull = ConvexHull(points)
    except QhullError:
        return 0.0
    return float(hull.volume + around * hull.area)

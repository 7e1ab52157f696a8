"""What is wrong with the surface of a part, and mending what can be mended."""

from dataclasses import dataclass

import numpy as np

from workbench.formats.meshes.junctions import split_at_junctions, weld_corners
from workbench.formats.meshes.shells import (
    MERGED_WITHIN,
    MeshEdges,
    inward,
    label_components,
    shell_of,
    shells_of,
)
from workbench.formats.meshes.shells import volumes_of as volumes_of_shells
from workbench.model.geometry import Bools, Floats, Ints, Mesh

CRUMB = 1e-3
"""Of the whole surface: a piece apart from the rest that has less is no part of the part."""

LARGEST_HOLE = 0.25
"""Of the surface's size: what is farther across is missing, and not a hole to be closed."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceReport:
    """What can be said about the surface of a part.

    `size` (3,) [m]; `volume` [m3], 0 when it is open; `components` pieces that do not hang
    together; `open_edges` belong to one triangle; `bad_edges` to several, of which not as many run
    along it one way as the other: three, or two that look to opposite sides; `is_inside_out` when
    it is closed but looks inward.
    """

    size: Floats
    triangles: int
    volume: float
    components: int
    open_edges: int
    bad_edges: int
    is_inside_out: bool

    @property
    def is_watertight(self) -> bool:
        """Whether it parts inside from outside."""
        return not self.open_edges and not self.bad_edges

    @property
    def problems(self) -> tuple[str, ...]:
        """What has to be mended, in words."""
        said: list[str] = []
        if self.open_edges:
            said.append(f"{self.open_edges} edges are open")
        if self.bad_edges:
            said.append(f"{self.bad_edges} edges have triangles that do not fit together")
        if self.is_inside_out:
            said.append("it is inside out")
        return tuple(said)


def examine_surface(mesh: Mesh) -> SurfaceReport:
    """Look at a surface whose corners are joined (`joined_corners`)."""
    triangles = np.asarray(mesh.triangles)
    edges = MeshEdges(triangles, len(mesh.points))
    is_open, is_bad = edges.times == 1, (edges.times > 1) & (edges.runs != 0)
    is_closed = not is_open.any() and not is_bad.any()
    shells, outer = shells_of(mesh)
    volumes = volumes_of_shells(mesh, shells)
    is_own = outer == np.arange(len(outer))
    return SurfaceReport(
        size=np.ptp(mesh.points[np.unique(triangles)], axis=0),
        triangles=len(triangles),
        volume=abs(float(volumes.sum())) if is_closed else 0.0,
        components=int(is_own.sum()),
        open_edges=int(is_open.sum()),
        bad_edges=int(is_bad.sum()),
        is_inside_out=is_closed and bool((volumes[is_own] < 0).any()),
    )


def joined_corners(mesh: Mesh) -> tuple[Mesh, tuple[str, ...]]:
    """Corners at the same place as one; no triangle with two corners, none that is there twice.

    Where two bodies touch, each of them has the triangle, one the other way round: those stay.

    Returns:
        The mesh, and what was left out, in words.
    """
    said: list[str] = []
    first, number = _places(np.round(mesh.points / MERGED_WITHIN).astype(np.int64))
    triangles = number[mesh.triangles]
    points = np.asarray(mesh.points)[first]
    # Three corners on a line have no area either, but close the surface: those stay.
    keep = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
    if not keep.all():
        said.append(f"{int((~keep).sum())} triangles with two corners left out")
    triangles = triangles[keep]
    # The same triangle begins with its lowest corner, whichever the file has first.
    start = triangles.argmin(axis=1)[:, None]
    once = _places(np.take_along_axis(triangles, (start + np.arange(3)) % 3, axis=1))[0]
    if len(once) < len(triangles):
        said.append(f"{len(triangles) - len(once)} triangles left out that were there twice")
        triangles = triangles[np.sort(once)]
    return _compact(points, triangles), tuple(said)


def _places(rows: Ints) -> tuple[Ints, Ints]:
    """The first of each different row (n, 3), in their order, and which of these every row is."""
    keys = rows
    if len(rows):
        # One number a row where it has room: sorting rows takes ten times as long.
        low = rows.min(axis=0)
        x, y, z = (int(side) + 1 for side in rows.max(axis=0) - low)
        if x * y * z < 2**62:
            keys = ((rows - low) * [y * z, z, 1]).sum(axis=1)
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first, number.ravel()


def outside_out(mesh: Mesh) -> tuple[Mesh, tuple[str, ...]]:
    """A closed surface with every shell that looks inward turned over, hollows left as they are.

    Returns:
        The mesh, and what was done, in words.
    """
    turned = inward(mesh)
    if not turned.any():
        return mesh, ()
    triangles = np.array(mesh.triangles)
    triangles[turned] = triangles[turned][:, ::-1]
    count = len(np.unique(shell_of(mesh)[turned]))
    words = "1 body that was inside out turned" if count == 1 else f"{count} bodies turned"
    return Mesh(mesh.points, triangles), (words,)


def repair_surface(mesh: Mesh) -> tuple[Mesh, tuple[str, ...]]:
    """Mend a surface: crumbs and sheets left out, slits and small holes closed, outside out.

    Returns:
        The mesh, which may still have problems (`examine_surface`), and what was done, in words.
    """
    said: list[str] = []
    mesh, doubled = _single_sided(mesh)
    if doubled:
        said.append(f"{doubled} triangles left out that were there twice, seen from both sides")
    mesh, crumbs = _without_crumbs(mesh)
    if crumbs:
        said.append(f"{crumbs} crumbs beside the part left out")
    mesh, joined = weld_corners(mesh)
    if joined:
        said.append(f"{joined} corners along gaps joined")
    mesh, split = split_at_junctions(mesh)
    if split:
        said.append(f"slits closed at {split} corners")
    points, triangles = np.asarray(mesh.points), np.array(mesh.triangles)
    turned = _find_turned(triangles)
    if turned.any():
        said.append(f"{int(turned.sum())} triangles turned to fit their neighbours")
        triangles[turned] = triangles[turned][:, ::-1]
    added = _lids(points, triangles)
    if len(added):
        said.append(f"holes closed with {len(added)} triangles")
        triangles = np.concatenate([triangles, added])
    mesh, sheets = _without_sheets(Mesh(points, triangles))
    if sheets:
        said.append(f"sheets of {sheets} triangles that enclose nothing left out")
    mesh, flipped = outside_out(mesh)
    return mesh, (*said, *flipped)


BOTH_SIDES = 0.5
"""Share of the triangles: if more are there from both sides, that is how the file was written."""

SHEETS = 0.2
"""Of the whole surface: so much may hang in it without enclosing anything."""


def _single_sided(mesh: Mesh) -> tuple[Mesh, int]:
    """Without the second of triangles that are there from both sides, where most of them are."""
    triangles = np.asarray(mesh.triangles)
    first = _places(np.sort(triangles, axis=1))[0]
    doubled = len(triangles) - len(first)
    if doubled < BOTH_SIDES * len(triangles) / 2:
        return mesh, 0
    return Mesh(mesh.points, triangles[np.sort(first)]), doubled


def _without_sheets(mesh: Mesh) -> tuple[Mesh, int]:
    """Without pieces that have open edges, if what remains is closed and nearly all of it."""
    triangles = np.asarray(mesh.triangles)
    edges = MeshEdges(triangles, len(mesh.points))
    two = np.argsort(edges.number, kind="stable")
    two = two[edges.times[edges.number[two]] == 2]
    pieces = label_components(edges.owner[two[::2]], edges.owner[two[1::2]], len(triangles))
    is_sheet = np.isin(pieces, np.unique(pieces[edges.owner[edges.open_sides]]))
    areas = _areas(mesh)
    if not is_sheet.any() or areas[is_sheet].sum() > SHEETS * areas.sum():
        return mesh, 0
    rest = _compact(np.asarray(mesh.points), triangles[~is_sheet])
    closed = examine_surface(rest)
    return (rest, int(is_sheet.sum())) if closed.is_watertight else (mesh, 0)


def _find_turned(triangles: Ints) -> Bools:
    """Which triangles (m,) look the other way than most of those that they hang together with.

    Every triangle stands twice in a graph, as it is and turned; neighbours that fit are joined in
    it, so that it falls apart into the ways in which all of a piece can fit.
    """
    count = len(triangles)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(np.arange(count), 3)
    keys = np.sort(edges, axis=1)
    _, number, times = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(number.ravel(), kind="stable")
    order = order[times[number.ravel()[order]] == 2]
    first, second = order[::2], order[1::2]
    differ = (edges[first, 0] == edges[second, 0]).astype(np.int64)
    rows = np.concatenate([owner[first], owner[first] + count])
    columns = np.concatenate([owner[second] + count * differ, owner[second] + count * (1 - differ)])
    way = label_components(rows, columns, 2 * count)
    as_it_is, turned = way[:count], way[count:]
    fitting = np.bincount(as_it_is, minlength=int(way.max()) + 1)
    more = fitting[turned] - fitting[as_it_is]
    return (more > 0) | ((more == 0) & (turned < as_it_is))


def _compact(points: Floats, triangles: Ints) -> Mesh:
    """Without corners that no triangle has."""
    used, number = np.unique(triangles, return_inverse=True)
    return Mesh(points[used], number.reshape(-1, 3))


def _areas(mesh: Mesh) -> Floats:
    a, b, c = mesh.points[mesh.triangles.T]
    return np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _without_crumbs(mesh: Mesh) -> tuple[Mesh, int]:
    pieces = shell_of(mesh)
    areas = np.bincount(pieces, _areas(mesh))
    is_crumb = areas < CRUMB * areas.sum()
    kept = np.asarray(mesh.triangles)[~is_crumb[pieces]]
    return _compact(np.asarray(mesh.points), kept), int(is_crumb.sum())


def _lids(points: Floats, triangles: Ints) -> Ints:
    """Triangles (k, 3) that close simple loops of open edges, fans around one corner."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    keys = np.sort(edges, axis=1)
    _, number, times = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    rim = edges[times[number.ravel()] == 1]
    after: dict[int, int] = {}
    forked: set[int] = set()
    for tail, head in rim.tolist():
        forked |= {head} if head in after else set()
        after[head] = tail  # a lid runs the other way than the triangle beside it
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    added: list[list[int]] = []
    while after:
        start = next(iter(after))
        loop = [start]
        while (following := after.pop(loop[-1], None)) is not None and following != start:
            loop.append(following)
        is_loop = following == start and len(loop) >= 3 and not forked & set(loop)
        if is_loop and float(np.linalg.norm(np.ptp(points[loop], axis=0))) < LARGEST_HOLE * size:
            added += [[loop[0], loop[k], loop[k + 1]] for k in range(1, len(loop) - 1)]
    return np.array(added, dtype=np.int64).reshape(-1, 3)

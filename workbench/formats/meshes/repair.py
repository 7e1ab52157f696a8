"""What is wrong with the surface of a part, and mending what can be mended."""

from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Bools, Floats, Ints, Mesh

SAME = 1e-6
"""[m] Corners this close are one: files write each triangle with corners of its own."""

CRUMB = 1e-3
"""Of the whole surface: a piece apart from the rest that has less is no part of the part."""

LARGEST_HOLE = 0.25
"""Of the surface's size: what is farther across is missing, and not a hole to be closed."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
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


def examined(mesh: Mesh) -> Surface:
    """Look at a surface whose corners are joined (`joined_corners`)."""
    triangles = np.asarray(mesh.triangles)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    low, high = edges.min(axis=1), edges.max(axis=1)
    _, number, times = np.unique(
        low.astype(np.int64) * len(mesh.points) + high, return_inverse=True, return_counts=True
    )
    # A triangle runs along each edge the other way than its neighbour.
    runs = np.bincount(number.ravel(), np.where(edges[:, 0] < edges[:, 1], 1, -1), len(times))
    is_open, is_bad = times == 1, (times > 1) & (runs != 0)
    a, b, c = mesh.points[triangles.T]
    middle = mesh.points.mean(axis=0)
    volume = float(np.einsum("ij,ij->i", a - middle, np.cross(b - middle, c - middle)).sum() / 6)
    is_closed = not is_open.any() and not is_bad.any()
    return Surface(
        size=np.ptp(mesh.points[np.unique(triangles)], axis=0),
        triangles=len(triangles),
        volume=abs(volume) if is_closed else 0.0,
        components=int(_component_of(mesh).max()) + 1,
        open_edges=int(is_open.sum()),
        bad_edges=int(is_bad.sum()),
        is_inside_out=is_closed and volume < 0,
    )


def joined_corners(mesh: Mesh) -> tuple[Mesh, tuple[str, ...]]:
    """Corners at the same place as one; no triangle with two corners, none that is there twice.

    Returns:
        The mesh, and what was left out, in words.
    """
    said: list[str] = []
    rounded = np.round(mesh.points / SAME).astype(np.int64)
    _, first, number = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    triangles = number.ravel()[mesh.triangles]
    points = np.asarray(mesh.points)[first]
    # Three corners on a line have no area either, but close the surface: those stay.
    keep = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
    if not keep.all():
        said.append(f"{int((~keep).sum())} triangles with two corners left out")
    triangles = triangles[keep]
    _, once = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    if len(once) < len(triangles):
        said.append(f"{len(triangles) - len(once)} triangles left out that were there twice")
        triangles = triangles[np.sort(once)]
    return _compact(points, triangles), tuple(said)


def repaired(mesh: Mesh) -> tuple[Mesh, tuple[str, ...]]:
    """Mend a surface: crumbs left out, neighbours turned alike, small holes closed, outside out.

    Returns:
        The mesh, which may still have problems (`examined`), and what was done, in words.
    """
    said: list[str] = []
    mesh, crumbs = _without_crumbs(mesh)
    if crumbs:
        said.append(f"{crumbs} crumbs beside the part left out")
    points, triangles = np.asarray(mesh.points), np.array(mesh.triangles)
    turned = _turned(triangles)
    if turned.any():
        said.append(f"{int(turned.sum())} triangles turned to fit their neighbours")
        triangles[turned] = triangles[turned][:, ::-1]
    added = _lids(points, triangles)
    if len(added):
        said.append(f"holes closed with {len(added)} triangles")
        triangles = np.concatenate([triangles, added])
    mended = Mesh(points, triangles)
    flipped = _outside_out(mended)
    if flipped is not mended:
        said.append("pieces turned inside out")
    return flipped, tuple(said)


def _turned(triangles: Ints) -> Bools:
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
    one, other = order[::2], order[1::2]
    differ = (edges[one, 0] == edges[other, 0]).astype(np.int64)
    rows = np.concatenate([owner[one], owner[one] + count])
    columns = np.concatenate([owner[other] + count * differ, owner[other] + count * (1 - differ)])
    way = _connected(rows, columns, 2 * count)
    as_it_is, turned = way[:count], way[count:]
    fitting = np.bincount(as_it_is, minlength=int(way.max()) + 1)
    more = fitting[turned] - fitting[as_it_is]
    return (more > 0) | ((more == 0) & (turned < as_it_is))


def _compact(points: Floats, triangles: Ints) -> Mesh:
    """Without corners that no triangle has."""
    used, number = np.unique(triangles, return_inverse=True)
    return Mesh(points[used], number.reshape(-1, 3))


def _connected(rows: Ints, columns: Ints, count: int) -> Ints:
    """Which of `count` nodes hang together by edges (m,) from `rows` to `columns`: labels (n,)."""
    from scipy.sparse import coo_matrix  # takes a while, and meshes that were kept need none
    from scipy.sparse.csgraph import connected_components

    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), (count, count))
    return connected_components(graph, directed=False)[1]


def _component_of(mesh: Mesh) -> Ints:
    """The number of the connected piece of each triangle (m,), counted from 0."""
    triangles = np.asarray(mesh.triangles)
    count = len(mesh.points)
    pairs = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    labels = _connected(pairs[:, 0], pairs[:, 1], count)[triangles[:, 0]]
    return np.unique(labels, return_inverse=True)[1].ravel()


def _without_crumbs(mesh: Mesh) -> tuple[Mesh, int]:
    a, b, c = mesh.points[mesh.triangles.T]
    pieces = _component_of(mesh)
    areas = np.bincount(pieces, np.linalg.norm(np.cross(b - a, c - a), axis=1))
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
    for one, other in rim.tolist():
        forked |= {other} if other in after else set()
        after[other] = one  # a lid runs the other way than the triangle beside it
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


def _outside_out(mesh: Mesh) -> Mesh:
    """With every piece that looks inward turned over, unless it is a hollow in another one."""
    triangles = np.array(mesh.triangles)
    pieces = _component_of(mesh)
    a, b, c = mesh.points[triangles.T]
    middle = mesh.points.mean(axis=0)
    volumes = np.einsum("ij,ij->i", a - middle, np.cross(b - middle, c - middle)) / 6
    of_piece = np.bincount(pieces, volumes)
    boxes = [mesh.points[np.unique(triangles[pieces == k])] for k in range(len(of_piece))]
    low = np.array([points.min(axis=0) for points in boxes])
    high = np.array([points.max(axis=0) for points in boxes])
    for k in range(len(of_piece)):
        is_within = (low < low[k] - SAME).all(axis=1) & (high > high[k] + SAME).all(axis=1)
        if of_piece[k] < 0 and not is_within.any():
            triangles[pieces == k] = triangles[pieces == k][:, ::-1]
    same = np.array_equal(triangles, mesh.triangles)
    return mesh if same else Mesh(mesh.points, triangles)

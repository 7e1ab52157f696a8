"""Which triangles of a surface hang together, and which closed shells bound one solid."""

import numpy as np

from workbench.model.geometry import Bools, Floats, Ints, Mesh

MERGED_WITHIN = 1e-6
"""[m] Corners this close are one: files write each triangle with corners of its own."""


class MeshEdges:
    """The edges of triangles (m, 3), each side of a triangle once.

    `sides` (3m, 2) are corners as the triangles run, `owner` (3m,) the triangle, `number` (3m,) the
    edge that a side lies on; `times` (e,) how many sides an edge has, `runs` (e,) how many more of
    them run one way than the other; no unit.
    """

    def __init__(self, triangles: Ints, points: int):
        self.sides = np.concatenate(
            [triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]
        )
        self.owner = np.tile(np.arange(len(triangles)), 3)
        low, high = self.sides.min(axis=1), self.sides.max(axis=1)
        _, number, self.times = np.unique(
            low.astype(np.int64) * points + high, return_inverse=True, return_counts=True
        )
        self.number = number.ravel()
        ways = np.where(self.sides[:, 0] < self.sides[:, 1], 1, -1)
        self.runs = np.bincount(self.number, ways, len(self.times))

    @property
    def open_sides(self) -> Ints:
        """The numbers of the sides (k,) that no other triangle has, no unit."""
        return np.flatnonzero(self.times[self.number] == 1)


def label_components(rows: Ints, columns: Ints, count: int) -> Ints:
    """Labels (n,), no unit, of nodes that hang together by edges (m,) from `rows` to `columns`."""
    from scipy.sparse import coo_matrix  # takes a while, and meshes that were kept need none
    from scipy.sparse.csgraph import connected_components

    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), (count, count))
    return connected_components(graph, directed=False)[1]


def shell_of(mesh: Mesh) -> Ints:
    """The number of the shell of each triangle (m,), counted from 0, no unit.

    Where several bodies touch along an edge, each triangle goes on in the one that bounds the same
    body.
    """
    triangles = np.asarray(mesh.triangles)
    edges = MeshEdges(triangles, len(mesh.points))
    order = np.argsort(edges.number, kind="stable")
    times = edges.times[edges.number[order]]
    two = order[times == 2]
    rows: list[Ints] = [edges.owner[two[::2]]]
    columns: list[Ints] = [edges.owner[two[1::2]]]
    starts = np.concatenate([[0], np.cumsum(edges.times)[:-1]])
    for edge in np.flatnonzero(edges.times > 2):
        at = order[starts[edge] : starts[edge] + edges.times[edge]]
        pairs = _around(mesh, edges, at) if edges.runs[edge] == 0 else _row(edges.owner[at])
        rows.append(pairs[:, 0])
        columns.append(pairs[:, 1])
    labels = label_components(np.concatenate(rows), np.concatenate(columns), len(triangles))
    return np.unique(labels, return_inverse=True)[1].ravel()


def _row(owners: Ints) -> Ints:
    return np.column_stack([owners[:-1], owners[1:]])


def _around(mesh: Mesh, edges: MeshEdges, at: Ints) -> Ints:
    """Pairs (k, 2) of triangles around an edge between which there is material."""
    ends = edges.sides[at].min(axis=0).min(), edges.sides[at].max()
    start, end = mesh.points[ends[0]], mesh.points[ends[1]]
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-30)
    owners = edges.owner[at]
    corners = np.asarray(mesh.triangles)[owners]
    third = corners.sum(axis=1) - edges.sides[at].sum(axis=1)
    out = mesh.points[third] - start
    across = np.linalg.svd(along[None])[2][1]
    angles = np.arctan2(out @ np.cross(along, across), out @ across)
    # A triangle that runs along the edge has material behind it, as the angle grows, or before it.
    begins = edges.sides[at][:, 0] != ends[0]
    order = sorted(range(len(at)), key=lambda k: (round(float(angles[k]), 6), begins[k]))
    pairs: list[tuple[int, int]] = []
    waiting: list[int] = []
    for k in (*order, *order):
        if begins[k]:
            waiting.append(k)
        elif waiting:
            pairs.append((owners[waiting.pop()], owners[k]))
    return np.array(pairs, np.int64).reshape(-1, 2)


def volumes_of(mesh: Mesh, shells: Ints) -> Floats:
    """The volumes (k,) [m3] of closed shells (m,), no unit; below zero where one looks inward."""
    a, b, c = mesh.points[mesh.triangles.T]
    middle = mesh.points.mean(axis=0)
    volumes = np.einsum("ij,ij->i", a - middle, np.cross(b - middle, c - middle)) / 6
    return np.bincount(shells, volumes).astype(np.float64)


def _boxes(mesh: Mesh, shells: Ints) -> tuple[Floats, Floats]:
    """The lowest and highest corners (k, 3) [m] of each shell."""
    corners = mesh.points[mesh.triangles]
    order = np.argsort(shells, kind="stable")
    starts = np.flatnonzero(np.diff(shells[order], prepend=-1))
    low = np.minimum.reduceat(corners.min(axis=1)[order], starts)
    return low, np.maximum.reduceat(corners.max(axis=1)[order], starts)


def shells_of(mesh: Mesh) -> tuple[Ints, Ints]:
    """Numbers, no unit: each triangle's shell (m,), and for each shell (k,) that of its solid.

    A shell that looks inward bounds the hollow of the smallest shell around it.
    """
    shells = shell_of(mesh)
    volumes = volumes_of(mesh, shells)
    low, high = _boxes(mesh, shells)
    outer = np.arange(len(volumes))
    for k in np.flatnonzero(volumes < 0):
        around = (low < low[k] - MERGED_WITHIN).all(axis=1) & (high > high[k] + MERGED_WITHIN).all(
            axis=1
        )
        holders = np.flatnonzero(around & (volumes > 0))
        if len(holders):
            outer[k] = holders[np.argmin(volumes[holders])]
    return shells, outer


def inward(mesh: Mesh) -> Bools:
    """Which triangles (m,) belong to shells that look inward, no unit; hollows left out."""
    shells, outer = shells_of(mesh)
    volumes = volumes_of(mesh, shells)
    is_inward = (volumes < 0) & (outer == np.arange(len(outer)))
    return is_inward[shells]

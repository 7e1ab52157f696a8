"""Gaps that have no area: corners that nearly meet, and corners in the middle of an edge."""

from itertools import pairwise

import numpy as np

from workbench.formats.meshes.shells import MeshEdges, label_components
from workbench.model.geometry import Floats, Ints, Mesh

JOINED_WITHIN = 1e-4
"""Of the surface's size: corners along open edges that are this close are one."""

ON_EDGE = 2e-5
"""Of the surface's size: a corner that is this near to an open edge lies on it."""

LEAST_DISTANCE = 2e-6
"""[m] At least this near."""

MOST_ROUNDS = 8
"""A triangle may have corners on more than one of its sides."""


def _size(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.points, axis=0)))


def weld_corners(mesh: Mesh) -> tuple[Mesh, int]:
    """Corners of open edges that nearly meet joined; and how many are gone."""
    from scipy.spatial import KDTree

    edges = MeshEdges(np.asarray(mesh.triangles), len(mesh.points))
    sides = edges.sides[edges.open_sides]
    if len(sides) == 0:
        return mesh, 0
    rim = np.unique(sides)
    lengths = np.linalg.norm(mesh.points[sides[:, 0]] - mesh.points[sides[:, 1]], axis=1)
    # An edge is never joined to a point: that would tear the surface elsewhere.
    near = min(max(JOINED_WITHIN * _size(mesh), LEAST_DISTANCE), 0.4 * float(lengths.min()))
    pairs = KDTree(mesh.points[rim]).query_pairs(near, output_type="ndarray")
    if len(pairs) == 0:
        return mesh, 0
    labels = label_components(pairs[:, 0], pairs[:, 1], len(rim))
    first = np.unique(labels, return_index=True)[1][labels]
    number = np.arange(len(mesh.points))
    number[rim] = rim[first]
    triangles = number[mesh.triangles]
    keep = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
    return Mesh(mesh.points, triangles[keep]), int((first != np.arange(len(rim))).sum())


def split_at_junctions(mesh: Mesh) -> tuple[Mesh, int]:
    """Triangles divided where a corner lies in the middle of an open edge; and at how many."""
    from scipy.spatial import KDTree

    points, triangles = np.asarray(mesh.points), np.array(mesh.triangles)
    near, count = max(ON_EDGE * _size(mesh), LEAST_DISTANCE), 0
    for _ in range(MOST_ROUNDS):
        edges = MeshEdges(triangles, len(points))
        sides = edges.open_sides
        rim = np.unique(edges.sides[sides])
        if len(rim) == 0:
            break
        tree = KDTree(points[rim])
        divided: dict[int, list[list[int]]] = {}
        for side in sides.tolist():
            a, b = edges.sides[side].tolist()
            owner = int(edges.owner[side])
            on = _on_edge(points, rim, tree, a, b, near)
            # A corner of the triangle itself may lie on its other side: it has no area.
            if owner not in divided and len(on):
                third = int(triangles[owner].sum()) - a - b
                row = [a, *(k for k in on if k != third), b]
                divided[owner] = [[i, j, third] for i, j in pairwise(row)]
                count += len(row) - 2
        divided = {owner: each for owner, each in divided.items() if len(each) > 1}
        if not divided:
            break
        kept = np.delete(triangles, list(divided), axis=0)
        triangles = np.vstack([kept, *(np.array(each) for each in divided.values())])
    return Mesh(points, triangles), count


def _on_edge(points: Floats, rim: Ints, tree: object, a: int, b: int, near: float) -> list[int]:
    """The corners among `rim` that lie on the way from a to b, in this order."""
    start, along = points[a], points[b] - points[a]
    length = float(np.linalg.norm(along))
    if length <= near:
        return []
    found = tree.query_ball_point(start + along / 2, length / 2)  # type: ignore[attr-defined]
    others = rim[found]
    others = others[(others != a) & (others != b)]
    share = (points[others] - start) @ along / length**2
    off = np.linalg.norm(points[others] - start - share[:, None] * along, axis=1)
    is_on = (off <= near) & (share * length > near) & ((1 - share) * length > near)
    return others[is_on][np.argsort(share[is_on])].tolist()

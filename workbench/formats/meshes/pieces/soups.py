"""Triangles without order: cut by planes, sampled, sorted into bodies."""

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from workbench.model.geometry import Floats

COPLANAR_WITHIN = 1e-6
"""[m] Corners that are no further from a plane lie in it."""

JOINED = 1e-5
"""[m] Corners this close are one: files give each triangle corners of its own."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Points with `normal` @ p = `offset` [m]; `normal` (3,) has no unit."""

    normal: Floats
    offset: float


def bodies(triangles: Floats, most: int) -> list[Floats]:
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


def clip_soup(soup: Floats, plane: Plane) -> tuple[Floats, Floats]:
    """Triangles (n, 3, 3) [m] below and above a plane; what it goes through is cut."""
    away = soup @ plane.normal - plane.offset
    away[np.abs(away) < COPLANAR_WITHIN] = 0.0
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


def cloud(soup: Floats, count: int) -> Floats:
    """Points (m, 3) [m] on triangles (n, 3, 3) [m], this many, and about this many corners."""
    surface = trimesh.Trimesh(
        soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3), process=False
    )
    points = trimesh.sample.sample_surface(surface, count, seed=0)[0]
    corners = np.unique(soup.reshape(-1, 3), axis=0)
    return np.vstack([np.asarray(points), corners[:: len(corners) // count + 1]])

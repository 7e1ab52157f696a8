"""Convex pieces made from discs and plates: how the geometry of the robots here is written.

Each robot's `make_meshes.py` lists its pieces.  Lengths in millimetres, each piece in the frame
of its link.
"""

from collections.abc import Mapping
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

Points = NDArray[np.float64]
Range = float | tuple[float, ...]

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
SIDES = 16
"""Of the polygon that stands for a disc, and that the disc lies inside of."""


def disc(centre: tuple[float, ...], axis: tuple[float, ...], radius: float) -> Points:
    """Corners of the polygon around a disc, shape (SIDES, 3)."""
    n = np.array(axis) / np.linalg.norm(axis)
    u = np.cross(n, Y if abs(n[0]) > 0.8 else X)
    u /= np.linalg.norm(u)
    angles = (np.arange(SIDES) + 0.5) * 2 * np.pi / SIDES
    ring = np.outer(np.cos(angles), u) + np.outer(np.sin(angles), np.cross(n, u))
    return np.array(centre) + radius / np.cos(np.pi / SIDES) * ring


def plate(x: Range, y: Range, z: Range) -> Points:
    """Corners of a rectangle: two of the ranges have two ends, one has a single value."""
    ranges = (r if isinstance(r, tuple) else (r,) for r in (x, y, z))
    return np.array(list(product(*ranges)), dtype=float)


def mirrored(piece: tuple[Points, ...]) -> tuple[Points, ...]:
    """The piece on the other side of the plane y = 0."""
    return tuple(points * (1, -1, 1) for points in piece)


def write(path: Path, piece: tuple[Points, ...]) -> int:
    """Write the hull of a piece in metres, to a tenth of a millimetre; the number of corners."""
    hull = ConvexHull(np.unique(np.round(np.vstack(piece) / 1000, 4), axis=0))
    corners = hull.points[hull.vertices]
    number = {old: new for new, old in enumerate(hull.vertices.tolist(), start=1)}
    lines = [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in corners]
    for face, outward in zip(hull.simplices.tolist(), hull.equations[:, :3], strict=True):
        a, b, c = hull.points[face]
        i, j, k = face if np.dot(np.cross(b - a, c - a), outward) > 0 else face[::-1]
        lines.append(f"f {number[i]} {number[j]} {number[k]}")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return len(corners)


def write_all(folder: Path, pieces: Mapping[str, tuple[Points, ...]]) -> None:
    """Write every piece into a folder and say how many corners it has."""
    folder.mkdir(exist_ok=True)
    for name, piece in pieces.items():
        print(f"{name}: {write(folder / f'{name}.convex.obj', piece)} corners")

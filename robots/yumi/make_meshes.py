"""Makes the convex pieces in meshes/: the links of the arms, the body and the palm.

Each piece is the convex hull of a few discs and plates, measured so that it holds the real link
with one or two millimetres to spare.  Lengths in millimetres, each piece in the frame of its
link (of the tool flange for the palm).

Run from the repository's root: `python robots/yumi/make_meshes.py`.
"""

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


WING = (
    plate(-322, (113, 155), (0, 93)),
    plate(-299, (113, 200), (-2, 85)),
    plate(-290, (113, 170), 98),
    plate(-200, (105, 186), (-7, 88)),
    plate(-150, (108, 150), 88),
    plate(-45, (108, 150), 72),
    plate(0, (89, 190), (-10, 50)),
    plate(46, (91, 180), (-3, 21)),
    plate(125, (98, 182), (-10, 40)),
    plate(60, (132, 152), -14),
    plate(135, (102, 176), (0, 35)),
)

PIECES = {
    "body_1": (  # the foot
        plate((-310, 0), (-156, 156), -101),
        plate((-300, 1), (-200, 200), 1),
        plate(-356, (-98, 98), (-75, 1)),
        plate((-300, 1), (-188, 188), -57),
    ),
    "body_2": (  # the slope in front of the column
        plate((-357, 3), (-105, 105), 0),
        plate((-357, 2), (-100, 100), 30),
        plate((-361, -120), (-105, 105), 104),
        plate(-325, (-116, 116), (0, 104)),
    ),
    "body_3": (  # the column
        plate(-361, (-93, 93), (100, 290)),
        plate(-329, (-112, 112), (100, 290)),
        plate(-165, (-107, 107), (100, 290)),
        plate(-150, (-98, 98), (100, 290)),
        plate(-135, (-75, 75), (100, 290)),
        plate(-123, (-30, 30), (100, 290)),
    ),
    "body_4": (  # the shoulders
        disc((53.5, -72.5, 415), (0.814, -0.342, 0.47), 61),
        disc((53.5, 72.5, 415), (0.814, 0.342, 0.47), 61),
        plate(-361, (-104, 104), (286, 405)),
        plate(-325, (-124, 124), (310, 400)),
        plate(-325, (-112, 112), 286),
        plate(-340, (-80, 80), 440),
        plate((-308, 0), (-98, 98), 458),
        plate((-260, 20), (-50, 50), 471),
        plate(-160, (-103, 103), 287),
        plate(-120, (-60, 60), 287),
        plate(60, (-40, 40), 331),
        plate(0, (-78, 78), 319),
        plate(12, (-30, 30), 310),
        plate(38, (-30, 30), 320),
        plate(-72, (-40, 40), 294),
        plate(-25, (-30, 30), 303),
        plate(-298, (-45, 45), 465),
        plate(-322, (-45, 45), 454),
        plate((-282, -200), (-114, 114), 437),
        plate(30, (-100, 100), 338),
        plate(-50, (-100, 100), 312),
        plate(-80, (-98, 98), 303),
        plate(-200, (-128, 128), 385),
        plate(0, (-130, 130), (350, 400)),
    ),
    "body_5": WING,
    "body_6": mirrored(WING),
    "link_1_1": (
        disc((0, 0, 0), Z, 63),
        disc((-8, 7.5, 32), (0.4, 0.14, 0.9), 36),
        disc((3, -10, 43), (0.04, 0.12, 0.99), 55.5),
    ),
    "link_1_2": (
        disc((27.5, -12.5, 93.5), (-0.02, 1, -0.05), 56),
        disc((31, -56.5, 95.5), (-0.24, 0.97, 0.07), 52),
        disc((31, -78.5, 102.5), (0, 1, -0.04), 39),
        disc((-36.5, -6.5, 44.5), (0.24, -0.11, 0.96), 12.5),
        disc((1.5, -32.5, 48), (0.21, 0.07, 0.97), 41),
    ),
    "link_2_1": (
        disc((-1.5, 0.5, 10.5), Z, 49),
        disc((-2, 3, -53), (-0.05, -0.26, 0.96), 52),
        disc((-5, 3, -77.5), Z, 45),
        disc((-34.5, 61, -17), (-0.05, 1, 0.06), 35),
    ),
    "link_2_2": (
        disc((-30.5, 59, -6), (0.04, 1, 0), 41.5),
        disc((-35.5, 81, -2.5), (0.52, 0.85, 0.06), 46),
        disc((-30, 151, 1), (0, 1, 0.06), 56.5),
        disc((-30, 172.5, 0), Y, 50),
    ),
    "link_7_1": (
        disc((-5, -1, 3.5), (0.08, 0.03, 1), 50.5),
        disc((3.5, 1, 8), (-0.23, -0.05, 0.97), 46.5),
        disc((-6.5, -7, 30), (-0.05, -0.04, 1), 50),
    ),
    "link_7_2": (
        disc((-37, -5.5, 73.5), (-0.08, 0.99, 0.1), 55.5),
        disc((-39.5, -53, 77.5), (-0.06, 1, 0), 49),
        disc((-41.5, -78.5, 80), Y, 28),
        disc((13, -16.5, 37), (0.16, 0.06, 0.99), 32.5),
        disc((-5.5, -38.5, 25), (-0.12, 0.17, 0.98), 18),
        disc((-19, -50, 60.5), (-0.02, 1, 0.08), 37),
    ),
    "link_3_1": (
        disc((-1.5, -1, 11), Z, 37),
        disc((2.5, 2, -20.5), (-0.07, 0, 1), 54),
        disc((0, -2.5, -78), (0, 0.04, 1), 39.5),
        disc((48.5, 50, -16.5), (0.31, 0.94, 0.13), 28),
        disc((5, -0.5, -50), (-0.08, 0.27, 0.96), 48),
    ),
    "link_3_2": (
        disc((30.5, 48.5, -16), (0.11, 0.99, 0), 42.5),
        disc((40.5, 59.5, 8.5), (0.07, 0.98, -0.17), 32.5),
        disc((39, 143, 0.5), (-0.11, 0.99, 0.09), 48.5),
        disc((40, 164.5, 1.5), Y, 40.5),
    ),
    "link_4_1": (
        disc((0.5, 0.5, 0.5), Z, 41.5),
        disc((-1.5, -0.5, 17), (-0.04, 0.08, 1), 42),
        disc((0, -35.5, 42.5), (0, 0.18, 0.98), 32.5),
        disc((-22, -40.5, 33), (0.38, 0.21, 0.9), 14.5),
    ),
    "link_4_2": (
        disc((-28, -31.5, 99), (0.02, 1, -0.09), 33),
        disc((-24.5, -50.5, 99), (-0.16, 0.98, -0.07), 33.5),
        disc((-27.5, -69.5, 101.5), (0.03, 1, -0.04), 22.5),
        disc((17, -42, 38.5), (-0.53, 0.82, -0.21), 22.5),
        disc((-2, -37, 49), (0.28, 0.85, -0.44), 35.5),
    ),
    "link_5_1": (
        disc((-2, -0.5, 28), (-0.11, 0.02, 0.99), 27),
        disc((13.5, -14, 11.5), (-0.02, 0.03, 1), 53),
        disc((13, -15.5, -20.5), (0.05, 0.13, 0.99), 52.5),
        disc((0, 2, -66.5), (0.02, -0.03, 1), 18.5),
        disc((43.5, 25.5, -0.5), (-0.03, 1, 0.05), 25),
    ),
    "link_6_1": (
        disc((0, 0, -11.5), Z, 25),
        disc((0, 0, -0.5), Z, 32),
        disc((0, 0, 7), Z, 32),
    ),
    "palm": (
        disc((-1, 0, 0), Z, 34),
        disc((1, 0, 0), Z, 34),
        disc((-9, 0, 35.5), Z, 37.5),
        disc((9, 0, 35.5), Z, 37.5),
        disc((-9.5, 0, 49.5), Z, 36),
        disc((9.5, 0, 49.5), Z, 36),
        disc((-16.5, 0, 93), Z, 15),
        disc((16.5, 0, 93), Z, 15),
    ),
}


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


if __name__ == "__main__":
    folder = Path(__file__).with_name("meshes")
    for name, piece in PIECES.items():
        print(f"{name}: {write(folder / f'{name}.convex.obj', piece)} corners")

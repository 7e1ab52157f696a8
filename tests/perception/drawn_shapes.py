"""Parts that nobody prepared for the localizer, drawn by Trimesh: round, flat, thin, wound.

```
python tests/perception/drawn_shapes.py FOLDER
```

writes STL files in millimetres, for `workbench part import`.
"""

import sys
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from trimesh import Trimesh
from trimesh.boolean import difference, union
from trimesh.creation import box, cylinder, icosphere
from trimesh.remesh import subdivide_to_size

PARTS = Path(__file__).parents[2] / "parts"

FINE = ("keyed_cylinder", "bracket", "bolt")
"""Shipped parts that are drawn with as many triangles as a CAD system makes of them."""

TRIANGLES = 10_000


def moved(mesh: Trimesh, by: ArrayLike) -> Trimesh:
    """The mesh [m], somewhere else."""
    mesh.apply_translation(by)
    return mesh


def rod() -> Trimesh:
    """Any turn, and end over end."""
    return cylinder(0.01, 0.06, sections=48)


def hex_nut() -> Trimesh:
    """Six turns, and upside down; its bore is round."""
    return difference([cylinder(0.02, 0.016, sections=6), cylinder(0.01, 0.05, sections=48)])


def cross() -> Trimesh:
    """Four turns, and upside down."""
    return union([box((0.06, 0.014, 0.014)), box((0.014, 0.06, 0.014))])


def elbow() -> Trimesh:
    """Two legs alike, about an axis that does not pass the file's origin."""
    legs = (
        moved(box((0.06, 0.014, 0.02)), (0.05, 0.027, 0.01)),
        moved(box((0.014, 0.06, 0.02)), (0.027, 0.05, 0.01)),
    )
    return union(legs)


def cup() -> Trimesh:
    """A wall of 1.5 mm, open at one end."""
    inside = moved(cylinder(0.0205, 0.04, sections=64), (0, 0, 0.0015))
    return difference([cylinder(0.022, 0.04, sections=64), inside])


def sheet() -> Trimesh:
    """Sheet metal of 1.5 mm, bent twice, with a hole."""
    bent = union(
        [
            moved(box((0.04, 0.03, 0.0015)), (-0.02, 0, 0)),
            moved(box((0.0015, 0.03, 0.02)), (0, 0, 0.00925)),
            moved(box((0.03, 0.03, 0.0015)), (0.01425, 0, 0.0185)),
        ]
    )
    return difference([bent, moved(cylinder(0.006, 0.02, sections=32), (-0.022, 0, 0))])


def spring() -> Trimesh:
    """Five turns of a wire of 4 mm."""
    turned, around = np.linspace(0, 10 * np.pi, 161), np.arange(12) * np.pi / 6
    along = np.c_[-12 * np.sin(turned), 12 * np.cos(turned), np.full(161, 4 / np.pi)]
    along /= np.linalg.norm(along, axis=1)[:, None]
    out = np.c_[np.cos(turned), np.sin(turned), np.zeros(161)]
    beside = np.cross(along, out)
    middles = 0.012 * out + np.c_[np.zeros((161, 2)), 0.004 * turned / np.pi]
    rings = middles[:, None] + 0.002 * (
        np.cos(around)[:, None] * out[:, None] + np.sin(around)[:, None] * beside[:, None]
    )
    points = np.vstack([rings.reshape(-1, 3), middles[[0, -1]]])
    a = np.arange(160)[:, None] * 12 + np.arange(12)
    b = np.arange(160)[:, None] * 12 + np.roll(np.arange(12), -1)
    first, last = len(points) - 2, len(points) - 1
    ends = [(first, k, (k + 1) % 12) for k in range(12)]
    ends += [(last, 1920 + (k + 1) % 12, 1920 + k) for k in range(12)]
    sides = np.vstack([np.stack([a, a + 12, b], -1), np.stack([b, a + 12, b + 12], -1)])
    wound = Trimesh(points, np.vstack([sides.reshape(-1, 3), ends]))
    wound.fix_normals()
    return wound


def ball() -> Trimesh:
    """Any turn about any axis; 5,120 triangles."""
    return icosphere(subdivisions=4, radius=0.018)


def ell() -> Trimesh:
    """A long leg and a short one."""
    return union([box((0.06, 0.016, 0.016)), moved(box((0.016, 0.016, 0.04)), (-0.022, 0, 0.02))])


def tee() -> Trimesh:
    """A foot that stands beside the middle."""
    return union([box((0.06, 0.014, 0.016)), moved(box((0.014, 0.04, 0.016)), (0.006, 0.02, 0))])


DRAWN = (rod, hex_nut, cross, elbow, cup, sheet, spring, ball, ell, tee)


def finely(name: str) -> Trimesh:
    """A shipped part with at least `TRIANGLES`, of the same shape [m]."""
    drawn = whole = trimesh.load_mesh(PARTS / name / f"{name}.stl")
    longest = 8.0
    while len(drawn.faces) < TRIANGLES:
        drawn = Trimesh(*subdivide_to_size(whole.vertices, whole.faces, max_edge=longest))
        longest *= 0.9
    return drawn.apply_scale(0.001)


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    shapes = {make.__name__: make() for make in DRAWN} | {f"{n}_fine": finely(n) for n in FINE}
    for name, drawn in shapes.items():
        drawn.apply_scale(1000.0).export(folder / f"{name}.stl")
        print(f"{name}: {len(drawn.faces)} triangles")

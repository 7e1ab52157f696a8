"""How well nearly symmetric parts state what they do not show.

```
PYTHONPATH=.:tests/perception python tests/perception/near_symmetry_figures.py SEED PILES SCANNER...
```

prints a row for each part and scanner: springs, nuts, screws, cups and gears in piles of six.
"""

import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from drawn_shapes import cup, hex_nut, spring
from trimesh import Trimesh
from trimesh.boolean import union
from trimesh.creation import cylinder

from workbench.app.runtime.work import find_parts
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Mesh, Solid
from workbench.model.part import GraspLibrary, Part
from workbench.model.scan import ALL_KINDS
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.progress import never, silent
from workbench.studies.localization import BUILDS, compare

COUNT, SURE = 6, 0.8
"""Parts in a pile, and the probability above which a wrong pose counts as surely wrong."""

PITCH, RADIUS, DEPTH, LENGTH = 0.003, 0.008, 0.0018, 0.036
"""[m] Of the thread."""

X = np.array([1.0, 0.0, 0.0])


def screw() -> Trimesh:
    """A coarse thread and a hexagon head, which do not repeat together."""
    around, heights = np.linspace(0, 2 * np.pi, 48, endpoint=False), np.linspace(0, LENGTH, 161)
    rings: list[np.ndarray] = []
    for z in heights:
        phase = (z / PITCH - around / (2 * np.pi)) % 1
        r = RADIUS - DEPTH * np.interp(phase, [0, 0.3, 0.5, 0.8, 1], [0, 0, 1, 1, 0])
        rings.append(np.c_[r * np.cos(around), r * np.sin(around), np.full(48, z)])
    points = np.vstack([*rings, [[0, 0, 0], [0, 0, LENGTH]]])
    i, j = (each.ravel() for each in np.meshgrid(np.arange(160), np.arange(48), indexing="ij"))
    a, b = i * 48 + j, i * 48 + (j + 1) % 48
    k = np.arange(48)
    first = np.c_[np.full(48, len(points) - 2), (k + 1) % 48, k]
    last = np.c_[np.full(48, len(points) - 1), 160 * 48 + k, 160 * 48 + (k + 1) % 48]
    sides = np.vstack([np.c_[a, b, b + 48], np.c_[a, b + 48, a + 48]])
    shaft = Trimesh(points, np.vstack([sides, first, last]))
    shaft.fix_normals()
    head = cylinder(0.013, 0.01, sections=6)
    head.apply_translation((0, 0, -0.0049))
    return union([shaft, head])


SHAPES = {
    "spring": (spring, Symmetry(axis=X, fold=2)),
    "hex_nut": (hex_nut, Symmetry(fold=6, also=(SymmetryAxis(X, 2),))),
    "screw": (screw, Symmetry()),
    "cup": (cup, Symmetry(fold=0)),
}


def part_of(name: str) -> Part:
    """A part of that shape, whose hull falls."""
    make, symmetry = SHAPES[name]
    mesh = make()
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    hull = mesh.convex_hull
    body = Solid("hull", Mesh(hull.vertices, hull.faces, is_convex=True), pin.SE3.Identity())
    return Part(name, Mesh(mesh.vertices, mesh.faces), (body,), 0.03, symmetry, GraspLibrary())


def main(seed: int, piles: int, builds: Sequence[str]) -> None:
    """Print the rows."""
    for name in SHAPES:
        part = part_of(name)
        for build in builds:
            row(part, build, seed, piles)


def row(part: Part, build: str, seed: int, piles: int) -> None:
    """Print one row."""
    cell = replace(read_cell("yumi"), parts=(part,))
    deviation, noise = BUILDS[build].deviation, BUILDS[build].noise
    assert deviation is not None
    cell = replace(cell, scanner=replace(cell.scanner, depth_noise=deviation))
    stated: list[tuple[float, bool, bool]] = []
    for number in range(seed, seed + piles):
        truth = pile_of(cell, ALL_KINDS, COUNT, seed=number)
        scan = synthesize(cell, truth, seed=number, noise=noise)
        parts = find_parts(cell, {"scan": scan, "seed": number}, silent, never).detections
        found, _ = compare(cell.parts, truth, parts)
        stated += [(pose.probability or 0.0, pose.is_right, pose.roll_known) for pose in found]
    chances = [chance for chance, _, _ in stated]
    wrong = [chance for chance, is_right, _ in stated if not is_right]
    print(
        f"{part.name} {build}: {len(stated)} found, {len(wrong)} wrong, "
        f"{sum(chance > SURE for chance in wrong)} of these above {SURE}; "
        f"stated {np.mean(chances) if chances else 0:.2f}, "
        f"right {1 - len(wrong) / max(len(stated), 1):.2f}; "
        f"roll unknown {sum(not known for *_, known in stated)}",
        flush=True,
    )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:])

"""How often a part is reported where none lies: empty bins, rubbish, and the wrong CAD file.

```
PYTHONPATH=.:tests/perception python tests/perception/nothing_there_figures.py SEED SCANS
```

prints a row for each of the three, over as many scans; scanners and parts take turns.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import cycle, islice

import numpy as np
import pinocchio as pin
from trimesh import Trimesh
from trimesh.creation import box, cylinder

from workbench.app.runtime.work import find_parts
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.geometry import Mesh, Solid
from workbench.model.part import GraspLibrary, Part
from workbench.model.scan import ALL_KINDS
from workbench.model.symmetry import Symmetry
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.progress import never, silent
from workbench.studies.localization import BUILDS

COUNT, SURE = 8, 0.5
"""Things in a bin, and the probability above which a report counts."""

SEARCHED = ("keyed_cylinder", "bracket", "bolt")
LYING = ("keyed_cylinder", "bracket", "bolt", "puck")

SCANNERS = ("fine", "structured_light", "stereo", "time_of_flight")


def shard(name: str, rng: np.random.Generator) -> Part:
    """A broken piece, a block or a bar of random size."""
    size = rng.uniform(0.015, 0.07, 3)
    kind = rng.integers(3)
    if kind == 0:
        mesh = Trimesh(rng.normal(size=(12, 3)) * size / 3, np.empty((0, 3), int)).convex_hull
    elif kind == 1:
        mesh = box(size)
    else:
        mesh = cylinder(size[0] / 3, size[1])
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    body = Mesh(mesh.vertices, mesh.faces, is_convex=True)
    solid = Solid("hull", body, pin.SE3.Identity())
    return Part(name, Mesh(mesh.vertices, mesh.faces), (solid,), 0.03, Symmetry(), GraspLibrary())


def cases(cell: Cell, kind: str, seed: int) -> Iterator[tuple[Cell, str, int]]:
    """What lies there, which part is searched, and how many things lie."""
    if kind == "empty bin":
        for searched in cycle(SEARCHED):
            yield cell, searched, 0
    elif kind == "rubbish":
        rng = np.random.default_rng(seed)
        for searched in cycle(SEARCHED):
            shards = tuple(shard(f"shard_{k}", rng) for k in range(COUNT))
            yield replace(cell, parts=shards), searched, COUNT
    else:
        pairs = [(lying, other) for other in SEARCHED for lying in LYING if lying != other]
        for lying, other in cycle(pairs):
            yield replace(cell, parts=(read_part(lying),)), other, COUNT


def main(seed: int, scans: int) -> None:
    """Print the rows."""
    cell = read_cell("yumi")
    for kind in ("empty bin", "rubbish", "wrong CAD file"):
        reports: list[tuple[float, str]] = []
        for number, (lying, searched, count) in enumerate(
            islice(cases(cell, kind, seed), scans), seed
        ):
            # Each scanner sees each case in turn.
            name = SCANNERS[(number + (number - seed) // len(SCANNERS)) % len(SCANNERS)]
            build = BUILDS[name]
            deviation = build.deviation or cell.scanner.depth_noise
            there = replace(lying, scanner=replace(cell.scanner, depth_noise=deviation))
            fallen = pile_of(there, ALL_KINDS, count, seed=number)
            scan = synthesize(there, fallen, seed=number, noise=build.noise)
            wanted = replace(there, parts=(read_part(searched),))
            found = find_parts(wanted, {"scan": scan, "seed": number}, silent, never).detections
            lies = lying.parts[0].name if kind == "wrong CAD file" else kind
            reports += [
                (part.probability or 0.0, f"{searched} in {lies}, {name}, {number}")
                for part in found
            ]
        sure = [(chance, where) for chance, where in reports if chance > SURE]
        print(
            f"{kind}: {len(reports)} reports in {scans} scans, {len(sure)} above {SURE}, "
            f"in {len({where for _, where in sure})} scans"
        )
        for chance, where in sorted(sure, reverse=True):
            print(f"  {chance:.2f} {where}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))

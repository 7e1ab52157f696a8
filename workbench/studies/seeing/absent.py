"""How often a part is reported where none lies: wrong CAD file, empty bin, rubbish in the bin."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import cycle, islice, permutations, product
from typing import Any, Literal

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
from workbench.planning.planners.clock import processor_time
from workbench.plugins.progress import never, silent
from workbench.studies.cases import percentiles
from workbench.studies.localization import BUILDS

Situation = Literal["wrong part", "empty bin", "rubbish"]
SITUATIONS: tuple[Situation, ...] = ("wrong part", "empty bin", "rubbish")

COUNT = 8
"""Things in a bin that is not empty."""

ALARM_PROBABILITY = 0.5
"""Probability above which a report is a false alarm."""


@dataclass(frozen=True, slots=True)
class AbsentTask:
    """One scan: the parts by their names, `lying` none where other things or nothing lies."""

    cell: str
    situation: Situation
    lying: str
    searched: str
    build: str
    seed: int


@dataclass(frozen=True, slots=True)
class AbsentSearch:
    """What a search reports although the part does not lie there, by probabilities."""

    task: AbsentTask
    probabilities: tuple[float, ...]
    processor_seconds: float

    @property
    def false_alarms(self) -> int:
        """How many reports have a probability above `ALARM_PROBABILITY`."""
        return sum(probability > ALARM_PROBABILITY for probability in self.probabilities)


def absent_tasks(
    cell: str, parts: Sequence[str], builds: Sequence[str], *, scans: int, seed: int
) -> list[AbsentTask]:
    """As many scans of each situation; parts and scanners take turns in an order by the seed.

    Args:
        cell: name or path of the cell.
        parts: two or more; each is searched for, and lies where another one is searched for.
        builds: scanners, by name.
        scans: of each situation.
        seed: of the first scan; the others follow.
    """
    rng = np.random.default_rng(seed)
    tasks: list[AbsentTask] = []
    for situation in SITUATIONS:
        pairs = [*permutations(parts, 2)] if situation == "wrong part" else [("", p) for p in parts]
        cases = [(lying, searched, build) for (lying, searched), build in product(pairs, builds)]
        order = cycle(rng.permutation(len(cases)))
        for number, k in enumerate(islice(order, scans)):
            lying, searched, build = cases[k]
            tasks.append(AbsentTask(cell, situation, lying, searched, build, seed + number))
    return tasks


def search_absent(task: AbsentTask) -> AbsentSearch:
    """Let things fall that are not the part, scan them, and search for the part."""
    build = BUILDS[task.build]
    cell, wanted = read_cell(task.cell), _searched(task.cell, task.searched)
    if build.deviation is not None:
        scanner = replace(cell.scanner, depth_noise=build.deviation)
        cell, wanted = replace(cell, scanner=scanner), replace(wanted, scanner=scanner)
    if task.situation == "rubbish":
        rng = np.random.default_rng(task.seed)
        cell = replace(cell, parts=tuple(shard(f"shard_{k}", rng) for k in range(COUNT)))
    elif task.lying:
        cell = replace(cell, parts=(read_part(task.lying),))
    count = 0 if task.situation == "empty bin" else COUNT
    fallen = pile_of(cell, ALL_KINDS, count, seed=task.seed)
    scan = synthesize(cell, fallen, seed=task.seed, noise=build.noise)
    began = processor_time()
    found = find_parts(wanted, {"scan": scan, "seed": task.seed}, silent, never).detections
    seconds = processor_time() - began
    return AbsentSearch(task, tuple(part.probability or 0.0 for part in found), seconds)


@lru_cache(maxsize=12)
def _searched(cell: str, part: str) -> Cell:
    """The cell with that part alone."""
    return replace(read_cell(cell), parts=(read_part(part),))


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


def absent_rows(searches: Sequence[AbsentSearch]) -> list[dict[str, Any]]:
    """A row for each situation: scans, reports, false alarms, and which scans have some."""
    groups: Mapping[str, list[AbsentSearch]] = {
        situation: [each for each in searches if each.task.situation == situation]
        for situation in SITUATIONS
    }
    return [
        {
            "situation": situation,
            "scans": len(group),
            "reports": sum(len(each.probabilities) for each in group),
            "false_alarms": sum(each.false_alarms for each in group),
            "scans_with_false_alarms": sum(each.false_alarms > 0 for each in group),
            "processor_seconds": percentiles(
                [each.processor_seconds for each in group], median=50, worst=100
            ),
        }
        for situation, group in groups.items()
    ]

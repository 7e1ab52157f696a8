"""Several kinds of parts in one scan: what two kinds are thought to explain is one of them."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import count

import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled
from workbench.model.scan import Detection, LocalizationResult, Objection, RejectedHypothesis, Scan
from workbench.perception.localization.choice import reaches_into
from workbench.perception.localization.competition import compete
from workbench.perception.localization.hypotheses import EFFORTS
from workbench.perception.localization.judging import Sought, taken_by_others
from workbench.perception.localization.localize import (
    MOST_REJECTED,
    Searched,
    mapped,
    proposals,
    together,
)
from workbench.perception.parts.part_surface import PartSurface
from workbench.perception.scene.scene_model import scene_model
from workbench.plugins.progress import Cancelled, Report


def all_kinds(
    scan: Scan,
    cell: Cell,
    *,
    seed: int,
    detail: float,
    report: Report,
    cancelled: Cancelled,
) -> LocalizationResult:
    """All parts of all kinds that a cell picks; see `plugins.localizer.Localizer.find`."""
    steps = count()

    def step(note: str) -> None:
        if cancelled():
            raise JobCancelled("the search for parts was cancelled")
        report(1.0 - 0.88 ** (next(steps) / len(cell.parts)), note)

    scene = scene_model(scan, cell)
    brought: list[Sought | PartSurface] = []
    for part in cell.parts:
        step(f"prepare {part.name} and map the scan")
        brought.append(mapped(scan, part, cell, detail=detail, scene=scene))
    found = [one for one in brought if isinstance(one, Sought)]
    for number in range(len(EFFORTS)):
        # At first nothing is taken, and each kind looks everywhere.
        taken = taken_by_others(found)
        proposed = [
            proposals(one, number, pixels, seed=seed, step=step)
            for one, pixels in zip(found, taken, strict=True)
        ]
        compete(found, proposed, step)
    return merged(together(scan, brought))


def merged(brought: Sequence[Searched]) -> LocalizationResult:
    """The searches for several kinds as one.

    A bolt fits on the side of a cylinder: each kind by itself would be found there.  Where a
    detection reaches into one of another kind, that stands for which more surface speaks.

    Returns:
        All detections that stand, best score first, and the best of all that was rejected.
    """
    claims = [
        (gain, k, one)
        for k, each in enumerate(brought)
        for gain, one in zip(each.gains, each.findings.detections, strict=True)
    ]
    claims.sort(key=lambda claim: -claim[0])
    standing: list[tuple[int, Detection]] = []
    lost: list[tuple[Detection, Detection]] = []
    for _, k, one in claims:
        rival = next((r for j, r in standing if j != k and _overlap(brought, j, r, k, one)), None)
        if rival is None:
            standing.append((k, one))
        else:
            lost.append((one, rival))
    found = sorted((one for _, one in standing), key=lambda one: -one.score)
    place = {id(one): number for number, one in enumerate(found)}
    place |= {id(one): place[id(rival)] for one, rival in lost}
    rejected = [
        replace(one, rival=None if one.rival is None else place[id(each.detections[one.rival])])
        for each in (one.findings for one in brought)
        for one in each.rejected
    ]
    rejected += [
        RejectedHypothesis(
            one.part, one.T_world_part, one.score, Objection.REACHES_INTO, place[id(one)]
        )
        for one, _ in lost
    ]
    rejected.sort(key=lambda one: -one.score)
    scales = tuple(scale for one in brought for scale in one.findings.scales)
    return LocalizationResult(tuple(found), tuple(rejected[:MOST_REJECTED]), scales)


def _overlap(
    brought: Sequence[Searched], j: int, first: Detection, k: int, second: Detection
) -> bool:
    """Whether a part of kind `j` and one of kind `k` would share room."""

    def is_in(one: PartSurface, T_one: pin.SE3, host: PartSurface, T_host: pin.SE3) -> bool:
        return reaches_into(one, host, T_host.actInv(T_one).homogeneous)

    one, other = brought[j].surface, brought[k].surface
    T_one, T_other = first.T_world_part, second.T_world_part
    return is_in(one, T_one, other, T_other) or is_in(other, T_other, one, T_one)

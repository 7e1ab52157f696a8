"""The thesis' last table: two parts at random in the bin, and the distance that decides.

Every pile is planned twice, with the arms one after the other and with both at once.  From that
follows what any threshold would have given: parts that lie at least so far apart are taken by
both arms at once, others one after the other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.plan import PlanResult, Strategy
from workbench.model.prediction import Forecast, Predictions
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import drop_parts


@dataclass(frozen=True, slots=True)
class Way:
    """What came of one strategy: whether it is proven, what it took and how long it runs [s]."""

    is_proven: bool
    planning: float
    cycle: float | None


@dataclass(frozen=True, slots=True)
class Case:
    """One pile of two parts.

    `distance` [m] between them; `is_reachable`: each arm can take a part of its own, so that
    any strategy with both arms is possible at all.
    """

    seed: int
    distance: float
    is_reachable: bool
    alternated: Way
    coordinated: Way


def planned_case(task: tuple[str, int]) -> Case:
    """Drop two parts by a seed and plan both ways.

    Args:
        task: name or path of the cell, and the seed.
    """
    name, seed = task
    cell = _warm(name)
    detections = _pile(cell, seed)
    alternated = plan_pick(cell, detections, "study", strategy="alternated", seed=seed)
    coordinated = plan_pick(cell, detections, "study", strategy="coordinated", seed=seed)
    first, second = (detection.T_world_part.translation for detection in detections)
    return Case(
        seed,
        float(np.linalg.norm(first - second)),
        _two_can(alternated),
        _way(alternated, Strategy.ALTERNATED),
        _way(coordinated, Strategy.COORDINATED),
    )


def _pile(cell: Cell, seed: int) -> tuple[Detection, ...]:
    return drop_parts(cell.parts[:1] * 2, cell.bin, seed=seed)


@lru_cache(maxsize=2)
def _warm(name: str) -> Cell:
    """The cell, after a plan of each kind: compiled code is loaded before a clock runs."""
    cell = read_cell(name)
    for strategy in ("alternated", "coordinated"):
        plan_pick(cell, _pile(cell, 0), "warm", strategy=strategy)
    return cell


def _two_can(result: PlanResult) -> bool:
    """Whether two arms can each take another part, one working after the other or not."""
    able = {(one.arm, one.detection) for one in result.candidates if one.verdict.is_ok}
    return any(a != b and i != j for a, i in able for b, j in able)


def _way(result: PlanResult, strategy: Strategy) -> Way:
    plan, proof = result.plan, result.proof
    is_proven = plan is not None and plan.strategy == strategy and proof is not None and proof.holds
    cycle = plan.cycle_seconds if plan is not None and is_proven else None
    return Way(is_proven, sum(result.seconds.values()), cycle)


def summary(cases: Sequence[Case], thresholds: Sequence[float]) -> list[dict[str, Any]]:
    """One row a threshold [m]; only piles that two arms can work on count.

    `parts_per_hour` counts the planning as if it were not hidden behind the motion before.
    """
    able = [case for case in cases if case.is_reachable]
    return [_row(able, len(cases), threshold) for threshold in thresholds]


def predictions(cell: Cell, rows: Sequence[Mapping[str, Any]]) -> Predictions:
    """The rows of a `summary` as they are kept for the page."""
    forecasts = [
        Forecast(
            row["threshold"],
            row["coordinated_share"],
            row["success"],
            row["planning_median"],
            row["cycle_mean"],
            row["parts_per_hour"],
        )
        for row in rows
    ]
    return Predictions(cell.digest, rows[0]["reachable"] if rows else 0, tuple(forecasts))


def _row(cases: Sequence[Case], piles: int, threshold: float) -> dict[str, Any]:
    both = [case.coordinated for case in cases if case.distance >= threshold]
    one = [case.alternated for case in cases if case.distance < threshold]
    taken = both + one
    seconds = [way.planning + way.cycle for way in taken if way.cycle is not None]
    return {
        "threshold": threshold,
        "piles": piles,
        "reachable": len(cases),
        "coordinated_share": len(both) / len(cases) if cases else None,
        "coordinated_success": _success(both),
        "coordinated_planning": _times(both),
        "alternated_success": _success(one),
        "alternated_planning": _times(one),
        "success": _success(taken),
        "planning_median": float(np.median([way.planning for way in taken])) if taken else None,
        "cycle_mean": float(np.mean([w.cycle for w in taken if w.cycle is not None]))
        if seconds
        else None,
        "parts_per_hour": 2 * 3600 * len(seconds) / sum(seconds) if seconds else None,
    }


def _success(ways: Sequence[Way]) -> float | None:
    return sum(way.is_proven for way in ways) / len(ways) if ways else None


def _times(ways: Sequence[Way]) -> dict[str, float] | None:
    if not ways:
        return None
    seconds = np.array([way.planning for way in ways])
    median, p95 = np.percentile(seconds, [50, 95])
    return {"mean": float(seconds.mean()), "median": float(median), "p95": float(p95)}

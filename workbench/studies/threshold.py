"""The thesis' last table: two parts at random in the bin, and the distance that decides.

Every pile is planned with the arms one after the other, with both at once; and by `auto` where both
are allowed, which takes the quicker.  From that follows what any threshold would have given: both
are allowed for parts that lie at least this far apart, for others only one after the other.
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
from workbench.studies.cases import percentiles
from workbench.studies.pairs import Taken, taken_of


@dataclass(frozen=True, slots=True)
class Way:
    """What came of one strategy: whether it is proven, what it took and how long it runs [s].

    `bound` [s] is what no plan for these parts can be quicker than.
    """

    is_proven: bool
    planning: float
    cycle: float | None
    bound: float | None = None


@dataclass(frozen=True, slots=True)
class Case:
    """One pile of two parts.

    `distance` [m] between them; `is_reachable`: each arm can take a part of its own, so that
    any strategy with both arms is possible at all.  `allowed` is what comes of `auto` where the
    distance allows both, and `taken` how many of the parts that takes.
    """

    seed: int
    distance: float
    is_reachable: bool
    alternated: Way
    coordinated: Way
    allowed: Way
    taken: Taken


def planned_case(task: tuple[str, int]) -> Case:
    """Drop two parts by a seed and plan all ways.

    Args:
        task: name or path of the cell, and the seed.
    """
    name, seed = task
    cell = _warm(name)
    detections = _pile(cell, seed)
    alternated = plan_pick(cell, detections, "study", strategy="alternated", seed=seed)
    coordinated = plan_pick(cell, detections, "study", strategy="coordinated", seed=seed)
    allowed = plan_pick(cell, detections, "study", threshold=0.0, seed=seed)
    first, second = (detection.T_world_part.translation for detection in detections)
    return Case(
        seed,
        float(np.linalg.norm(first - second)),
        _two_can(alternated),
        _way(alternated, Strategy.ALTERNATED),
        _way(coordinated, Strategy.COORDINATED),
        _way(allowed, Strategy.ALTERNATED, Strategy.COORDINATED),
        taken_of(cell, detections, allowed, seed),
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
    able = {
        (candidate.arm, candidate.detection)
        for candidate in result.candidates
        if candidate.verdict.is_ok
    }
    return any(a != b and i != j for a, i in able for b, j in able)


def _way(result: PlanResult, *strategies: Strategy) -> Way:
    plan, proof, planning = result.plan, result.proof, sum(result.seconds.values())
    if plan is None or plan.strategy not in strategies or proof is None or not proof.holds:
        return Way(False, planning, None)
    return Way(True, planning, plan.cycle_seconds, result.bound)


def summary(cases: Sequence[Case], thresholds: Sequence[float]) -> list[dict[str, Any]]:
    """One row a threshold [m]; only piles that two arms can work on count.

    `allowed_share` of them lie this far apart that both arms are allowed at once: `allowed_success`
    and `allowed_planning` are what `auto` makes of those, which plans both at once and in turn and
    takes the quicker; `coordinated_...` are both at once alone, `alternated_...` the other piles.
    `parts_per_hour` counts all planning, also that which came to nothing, as if it were not hidden
    behind the motion before; `of_bound` is the median of cycle times as shares of their bounds.
    """
    able = [case for case in cases if case.is_reachable]
    return [_row(able, len(cases), threshold) for threshold in thresholds]


def predictions(cell: Cell, rows: Sequence[Mapping[str, Any]]) -> Predictions:
    """The rows of a `summary` as they are kept for the page."""
    forecasts = [
        Forecast(
            row["threshold"],
            row["allowed_share"],
            row["success"],
            row["planning_median"],
            row["cycle_mean"],
            row["parts_per_hour"],
        )
        for row in rows
    ]
    return Predictions(cell.digest, rows[0]["reachable"] if rows else 0, tuple(forecasts))


def _row(cases: Sequence[Case], piles: int, threshold: float) -> dict[str, Any]:
    far = [case for case in cases if case.distance >= threshold]
    allowed, both = [case.allowed for case in far], [case.coordinated for case in far]
    near = [case.alternated for case in cases if case.distance < threshold]
    taken = allowed + near
    shares = [w.cycle / w.bound for w in taken if w.cycle is not None and w.bound]
    cycles = [way.cycle for way in taken if way.cycle is not None]
    seconds = sum(way.planning for way in taken) + sum(cycles)
    return {
        "threshold": threshold,
        "piles": piles,
        "reachable": len(cases),
        "allowed_share": len(far) / len(cases) if cases else None,
        "allowed_success": _success(allowed),
        "allowed_planning": _times(allowed),
        "coordinated_success": _success(both),
        "coordinated_planning": _times(both),
        "alternated_success": _success(near),
        "alternated_planning": _times(near),
        "success": _success(taken),
        "planning_median": float(np.median([way.planning for way in taken])) if taken else None,
        "cycle_mean": float(np.mean(cycles)) if cycles else None,
        "of_bound": float(np.median(shares)) if shares else None,
        "parts_per_hour": 2 * 3600 * len(cycles) / seconds if seconds else None,
    }


def _success(ways: Sequence[Way]) -> float | None:
    return sum(way.is_proven for way in ways) / len(ways) if ways else None


def _times(ways: Sequence[Way]) -> dict[str, float] | None:
    seconds = [way.planning for way in ways]
    found = percentiles(seconds, median=50, p95=95)
    return None if found is None else {"mean": float(np.mean(seconds)), **found}

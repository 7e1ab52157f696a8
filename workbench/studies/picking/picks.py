"""How long a pick takes, stage by stage, and how often it works: seeded piles, known poses.

Localization is left out on purpose: its own study states how good it is.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.regrasp import plan_regrasp
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Candidate, Reason
from workbench.model.cell import Cell, PlanOverrides
from workbench.model.messages.message import plain
from workbench.model.messages.verdicts import StationNote
from workbench.model.plan import PlanResult
from workbench.model.scan import Detection, Scene
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.planners.clock import working_time
from workbench.plugins.progress import Report, silent
from workbench.studies.cases import percentiles

REGRASPED, HANDED_OVER = "ok over a station (regrasp)", "ok over a station (hand over)"
"""Of parts that the same arm takes anew from a station, and that the other one does."""

STAGES = ("propose", "resolve", "route", "prove")


def measure(
    cell_name: str,
    *,
    scenes: int,
    parts: int = 2,
    seed: int = 0,
    strategy: str = "auto",
    planner: str | None = None,
    report: Report = silent,
) -> dict[str, Any]:
    """Plan every pile once; times [s] per stage, what came of it, and of each part of the piles.

    One plan is made before the clock starts, so that compiled code is loaded.

    Args:
        cell_name: name or path of a cell.
        scenes: how many piles.
        parts: how many parts in each.
        seed: of the first pile; the others follow.
        strategy: see `model.derived.by_recipe.check_strategy`.
        planner: of the free legs; the cell's when None.
        report: progress.
    """
    cell = read_cell(cell_name)
    part = cell.parts[0]
    seeds = range(seed, seed + scenes)
    piles = [drop_parts((part,) * parts, cell.bin, seed=s) for s in seeds]
    overrides = PlanOverrides(planner=planner)
    plan_pick(cell, piles[0], "warm", strategy=strategy, overrides=overrides, seed=0)
    seconds: dict[str, list[float]] = {stage: [] for stage in STAGES}
    cycles: list[float] = []
    fates: Counter[str] = Counter()
    for number, (pile_seed, pile) in enumerate(zip(seeds, piles, strict=True)):
        report(number / scenes, f"pile {pile_seed}")
        began = working_time()
        result = plan_pick(
            cell, pile, "study", strategy=strategy, overrides=overrides, seed=pile_seed
        )
        whole = working_time() - began
        found = list(fates_of(result.candidates, len(pile)))
        if cell.stations:
            found = list(_with_stations(cell, pile, result, found, pile_seed, overrides))
        fates.update(found)
        for stage, value in result.seconds.items():
            seconds[stage].append(value)
        if result.plan is None or result.proof is None:
            outcome = f"no plan: {result.verdict.reason}"
        else:
            proven = "proven" if result.proof.holds else "not proven"
            outcome = f"{result.plan.strategy}, {len(result.plan.arms)} part(s), {proven}"
            cycles.append(result.plan.cycle_seconds)
        seconds.setdefault(outcome, []).append(whole)
    return {"seconds": seconds, "cycle_seconds": cycles, "parts": dict(fates.most_common())}


def fates_of(candidates: Sequence[Candidate], parts: int) -> Iterator[str]:
    """For each part of a pile: that a grasp of it works, up to the place; or why none does.

    That is what refuses the grasp that got furthest.
    """
    for number in range(parts):
        mine = [candidate.verdict for candidate in candidates if candidate.detection == number]
        if any(verdict.is_ok for verdict in mine):
            yield str(Reason.OK)
        elif mine:
            yield str(max(mine, key=lambda verdict: verdict.progress).reason)


def _with_stations(
    cell: Cell,
    pile: tuple[Detection, ...],
    result: PlanResult,
    fates: Sequence[str],
    seed: int,
    overrides: PlanOverrides,
) -> Iterator[str]:
    """The fates of a pile's parts, each of which may go over a station if it has no place else.

    It is asked of each part by itself, as if it was the next to be taken.
    """
    scene = Scene("study", pile)
    for number, fate in enumerate(fates):
        if fate != Reason.NO_PLACE:
            yield fate
            continue
        others = {other: plain("not asked") for other in range(len(pile)) if other != number}
        alone = replace(result, plan=None, proof=None, row=())
        over = plan_regrasp(cell, scene, alone, avoided=others, seed=seed, overrides=overrides)
        if len({arm.arm for plan in over.plans for arm in plan.arms}) > 1:
            yield HANDED_OVER
        elif over.row:
            yield REGRASPED
        else:
            note = over.verdict.note
            said = None if note is None else note.part(StationNote.NOT_OVER)
            yield fate if said is None else f"{fate}: {said.args['why']}"


def rows(measured: dict[str, Any]) -> list[dict[str, Any]]:
    """Median and tail of each stage, and of the whole by what came out [s]."""
    return [
        {"stage": stage, **found, "count": len(values)}
        for stage, values in measured["seconds"].items()
        if (found := percentiles(values, median=50, p90=90, largest=100)) is not None
    ]

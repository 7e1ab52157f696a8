"""How long a pick takes, stage by stage, and how often it works: seeded piles, known poses.

`python -m workbench.studies.picks --scenes 40` prints the table.  Localization is left out on
purpose: its own study tells how good it is.
"""

import json
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import tyro
from rich.console import Console
from rich.progress import track
from rich.table import Table

from workbench.app.pick import plan_pick
from workbench.formats.cells import read_cell
from workbench.model.cell import PlannerName
from workbench.model.scan import Detection
from workbench.perception.piles import drop_parts

STAGES = ("propose", "resolve", "route", "prove")


@dataclass(frozen=True)
class Arguments:
    """Plan seeded piles and print how long each stage took.

    cell: name or path of a cell.
    scenes: how many piles.
    parts: how many parts in each.
    seed: of the first pile; the others follow.
    strategy: auto, alternated, coordinated, right or left.
    planner: of the free legs; the cell's when not given.
    json: print one JSON object instead of the table.
    """

    cell: str = "yumi"
    scenes: int = 40
    parts: int = 2
    seed: int = 0
    strategy: str = "auto"
    planner: PlannerName | None = None
    json: bool = False


def measure(arguments: Arguments) -> dict[str, Any]:
    """Plan every pile once; times [s] per stage, and what came of it.

    One plan is made before the clock starts, so that compiled code is loaded.
    """
    cell = read_cell(arguments.cell)
    part = cell.parts[0]
    seeds = range(arguments.seed, arguments.seed + arguments.scenes)
    piles = [
        tuple(Detection(part.name, T) for T in drop_parts(part, cell.bin, arguments.parts, seed=s))
        for s in track(seeds, "dropping parts", console=Console(stderr=True), transient=True)
    ]
    plan_pick(cell, piles[0], "warm", strategy=arguments.strategy, seed=0)
    seconds: dict[str, list[float]] = {stage: [] for stage in STAGES}
    cycles: list[float] = []
    for seed, pile in zip(seeds, piles, strict=True):
        began = time.perf_counter()
        result = plan_pick(
            cell,
            pile,
            "study",
            strategy=arguments.strategy,
            planner=arguments.planner,
            seed=seed,
        )
        whole = time.perf_counter() - began
        for stage, value in result.seconds.items():
            seconds[stage].append(value)
        if result.plan is None or result.proof is None:
            outcome = f"no plan: {result.verdict.reason}"
        else:
            proven = "proven" if result.proof.holds else "not proven"
            outcome = f"{result.plan.strategy}, {len(result.plan.arms)} part(s), {proven}"
            cycles.append(result.plan.cycle_seconds)
        seconds.setdefault(outcome, []).append(whole)
    return {"seconds": seconds, "cycle_seconds": cycles}


def table(measured: dict[str, Any]) -> Table:
    """Medians and tails in milliseconds."""
    shown = Table(title="Planning, milliseconds: the stages, and all of them by what came out")
    for column in ("stage", "median", "90 %", "largest", "count"):
        shown.add_column(column, justify="left" if column == "stage" else "right")
    for stage, values in measured["seconds"].items():
        if values:
            median, tail, largest = np.percentile(np.array(values) * 1000, [50, 90, 100])
            shown.add_row(stage, f"{median:.1f}", f"{tail:.1f}", f"{largest:.1f}", str(len(values)))
    return shown


def main() -> None:
    """Entry point."""
    arguments = tyro.cli(Arguments)
    measured = measure(arguments)
    if arguments.json:
        json.dump(measured, sys.stdout)
        sys.stdout.write("\n")
        return
    console = Console()
    console.print(table(measured))
    if measured["cycle_seconds"]:
        console.print(f"predicted cycle: {np.median(measured['cycle_seconds']):.1f} s median")


if __name__ == "__main__":
    main()

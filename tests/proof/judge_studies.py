"""Good plans stay good: those of the studies are proven, and judged by another make.

```
PYTHONPATH=.:tests/planning python tests/proof/judge_studies.py threshold --piles 100
PYTHONPATH=.:tests/planning python tests/proof/judge_studies.py emptying --piles 5 --parts 30
```

The piles are those of `workbench study threshold` and `workbench study emptying` by the same seeds.
Ends with 1 where a plan is refused by either.
"""

import argparse
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from judge import Judge
from judge_files import Files, read

from workbench.app.emptying.empty import empty_pile
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.plan import Plan
from workbench.model.prediction import PileTask
from workbench.perception.simulation.piles import drop_parts
from workbench.proof.claims.prove import prove

ROOT = Path(__file__).resolve().parents[2]
FULL_BINS = ("yumi", "tx2_90")
STRATEGIES = ({"strategy": "alternated"}, {"strategy": "coordinated"}, {"threshold": 0.0})
"""How the threshold study plans each pile."""


def of_threshold(cell: Cell, seed: int) -> Iterator[Plan]:
    """The plans for two parts at random; those with no plan at all bring none."""
    pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=seed)
    for wish in STRATEGIES:
        plan = plan_pick(cell, pile, "study", **wish, seed=seed).plan
        if plan is not None:
            yield plan


def of_emptying(cell: Cell, name: str, count: int, seed: int) -> Iterator[Plan]:
    """Every plan that is carried out until nothing can be taken any more, and its parts' scene."""
    task, plans = PileTask(name, "", count, seed), []
    pile = drop_parts(cell.parts[:1] * count, cell.bin, seed=seed)
    empty_pile(cell, task, pile, film=lambda shot: plans.append(shot.plan))
    return iter(plans)


def refused(judge: Judge, cell: Cell, files: Files, plan: Plan) -> str:
    """Who refuses a plan, and why; empty where nobody does."""
    proof = prove(cell, plan.scene, plan)
    if not proof.holds:
        return f"the proof: {proof.violations[0]}"
    refusal = judge.refusal(files, plan.scene, plan)
    if refusal is None:
        return ""
    return f"the judge: {refusal.why}, {refusal.distance * 1e3:.2f} mm on {refusal.legs}"


def cell_and_files(name: str, file: str = "cell.toml") -> tuple[Cell, Files]:
    """A shipped cell, as it is read and as the judge reads it."""
    folder = ROOT / "robots" / name
    return read_cell(folder / file), read(folder, ROOT / "parts", file)


def main() -> int:
    """Judge all plans of a study, and print how many there were."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("study", choices=("threshold", "emptying"))
    parser.add_argument("--piles", type=int, default=5)
    parser.add_argument("--parts", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0, help="of the first pile")
    typed, bad = parser.parse_args(), 0
    names = ("yumi",) if typed.study == "threshold" else FULL_BINS
    for name in names:
        file = "cell.toml" if typed.study == "threshold" else "full_bin.toml"
        cell, files = cell_and_files(name, file)
        plans_of = of_threshold
        if typed.study == "emptying":
            plans_of = partial(of_emptying, name=f"{name}/full_bin.toml", count=typed.parts)
        count = 0
        for seed in range(typed.seed, typed.seed + typed.piles):
            judge = Judge()
            for plan in plans_of(cell, seed=seed):
                count += 1
                if why := refused(judge, cell, files, plan):
                    bad += 1
                    print(f"{name}, pile {seed}, plan {count}: {why}", flush=True)
            piles = seed - typed.seed + 1
            print(f"{name}: {count} plans of {piles} piles, {bad} refused", flush=True)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())

"""Bent plans: what the proof objects to, and whether a judge refuses one that the proof accepts."""

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np

from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.plan import Plan
from workbench.model.scan import Scene
from workbench.proof.claims.prove import prove

TOO_NEAR = 0.0006
"""[m] The proof lets a distance fall short of its margin by its resolution at most."""

Bent = tuple[Cell, Scene, Plan]


def objections(cell: Cell, plan: Plan, scene: Scene | None = None) -> str:
    """The proof's objections to a plan, a line each."""
    return "\n".join(map(str, prove(cell, scene or plan.scene, plan).violations))


def between(path: Floats, step: float = np.deg2rad(1.0)) -> Iterator[Floats]:
    """Configurations (n,) along a path (m, n), no joint farther apart than `step` [rad]."""
    for before, after in pairwise(path):
        count = max(int(np.ceil(np.abs(after - before).max() / step)), 1)
        for share in np.linspace(0.0, 1.0, count + 1):
            yield before + share * (after - before)


def judge_plans(
    count: int, bend: Callable[[int], Bent], refusals: Callable[[Cell, Scene, Plan], Iterator[str]]
) -> tuple[int, int]:
    """How many of `count` bent plans the proof accepts, and the judge refuses; no plan is both."""
    judged = [(prove(*bent).holds, next(refusals(*bent), "")) for bent in map(bend, range(count))]
    assert [(seed, why) for seed, (holds, why) in enumerate(judged) if holds and why] == []
    return sum(holds for holds, _ in judged), sum(bool(why) for _, why in judged)

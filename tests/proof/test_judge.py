"""No bent plan holds that a judge refuses who shares nothing with the proof.

`PYTHONPATH=tests/planning python tests/proof/test_judge.py CELL COUNT SEED` bends more and counts.
"""

import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from bends import bent
from judge import Judge, Scene

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.perception.simulation.piles import drop_parts

ROOT = Path(__file__).resolve().parents[2]

PILES = {"tx2_90": ("puck", 6, "auto"), "yumi": ("keyed_cylinder", 2, "alternated")}


def judged(name, seeds, bends):
    """Good plans and bent ones: what was bent, whether it holds, and what the judge says."""
    cell, judge = read_cell(name), Judge(ROOT / "robots" / name, ROOT / "parts")
    kind, count, strategy = PILES[name]
    for seed in seeds:
        pile = drop_parts([cell.part(kind)] * count, cell.bin, seed=seed)
        plan = plan_pick(cell, pile, "scan", strategy=strategy, seed=seed).plan
        if plan is None:
            continue
        yield "nothing", prove(cell, plan), judge.refusal(plan)
        for number in range(bends):
            what, other = bent(cell, plan, np.random.default_rng([seed, number]))
            yield what, prove(cell, other), judge.refusal(other)


@pytest.mark.parametrize(("name", "seeds", "bends"), [("tx2_90", (40, 41), 16), ("yumi", (40,), 3)])
def test_nothing_holds_that_the_judge_refuses(name, seeds, bends):
    results = list(judged(name, seeds, bends))
    for what, proof, refusal in results:
        assert not (proof.holds and refusal is not None), (what, refusal)
        assert what != "nothing" or proof.holds
    assert not all(proof.holds for _, proof, _ in results)
    assert len(results) < 20 or any(refusal is not None for _, _, refusal in results)


def test_the_judge_knows_where_the_hands_of_the_cell_are(cell, result):
    """Without that it would judge another robot."""
    judge = Judge(ROOT / "robots" / "yumi", ROOT / "parts")
    scene = Scene(judge, result.plan)
    for one in result.plan.arms:
        scene.q[one.arm] = np.asarray(one.leg("approach").q[-1])
        T_world_part = scene.tcp(one.arm) @ one.T_tcp_part.homogeneous
        known = result.plan.detections[one.detection].T_world_part.homogeneous
        np.testing.assert_allclose(T_world_part, known, atol=1e-3)


def main(name: str, count: int, seed: int) -> None:
    """Bend plans and count: what holds, what the judge refuses, and where they differ."""
    table: Counter[tuple[str, str]] = Counter()
    for what, proof, refusal in judged(name, range(seed, seed + max(count // 20, 1)), 20):
        near = any(finding.problem.startswith("closer") for finding in proof.findings)
        verdict = "holds" if proof.holds else "too near" if near else "against a rule"
        table[what, f"{verdict}, {'clear' if refusal is None else 'touches'}"] += 1
        if proof.holds and refusal is not None:
            print("HOLDS, AND THE JUDGE REFUSES:", what, refusal, flush=True)
    for (what, verdict), number in sorted(table.items()):
        print(f"{what:10} {verdict:24} {number}")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))

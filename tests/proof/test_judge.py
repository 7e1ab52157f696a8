"""No bent plan holds that a judge refuses who shares nothing with the proof.

`PYTHONPATH=.:tests/planning python tests/proof/test_judge.py CELL COUNT SEED FOLDER` bends more and
counts; cells that are not shipped are made in the folder.
"""

import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from bends import bent
from bent_cells import cases
from judge import Judge
from judged_motion import ALIKE

from workbench.proof.prove import prove

A_PLAN = 25
"""So many bends of each plan."""


def judged(case, seed, bends):
    """A good plan and bent ones: what was bent, its proof, what the judge says, and the case."""
    judge = Judge()
    for number in range(-1, bends):
        what, other = "nothing", case
        if number >= 0:
            what, other = bent(case, np.random.default_rng([seed, number]))
        proof = prove(other.cell, other.scene, other.plan)
        yield what, proof, judged_by(judge, other), other


def judged_by(judge, case):
    return judge.refusal(case.files, case.scene, case.plan)


@pytest.mark.parametrize(
    ("name", "seed", "bends"), [("tx2_90", 40, 20), ("yumi", 40, 10), ("pallet", 41, 15)]
)
def test_nothing_holds_that_the_judge_refuses(name, seed, bends, tmp_path):
    (case,) = cases(name, [seed], tmp_path)
    results = list(judged(case, seed, bends))
    for what, proof, refusal, _ in results:
        assert not (proof.holds and refusal is not None), (what, refusal)
        assert what != "nothing" or proof.holds
    assert any(refusal is not None for _, _, refusal, _ in results)
    assert any(proof.holds for what, proof, _, _ in results if what != "nothing")


def main(name: str, count: int, seed: int, made: Path) -> None:
    """Bend plans and count: what holds, what the judge refuses, and where they differ.

    What the proof alone refuses is judged again, without leave to miss a distance by a little.
    """
    table: Counter[tuple[str, str]] = Counter()
    begin, number = time.process_time(), 0
    while number < count:
        for case in cases(name, [seed], made):
            for what, proof, refusal, other in judged(case, seed, A_PLAN):
                says = "clear" if refusal is None else "refused"
                if refusal is None and not proof.holds:
                    close = judged_by(Judge(ALIKE), other)
                    says = "clear" if close is None else "nearly"
                verdict = f"{'held' if proof.holds else 'refused'}, {says}"
                table[what, verdict] += 1
                if proof.holds != (refusal is None):
                    print(verdict, what, seed, refusal or proof.findings[0], flush=True)
            number += A_PLAN
        seed += 1
    for what in sorted({what for what, _ in table}):
        print(f"{what:16}", {v: n for (w, v), n in table.items() if w == what})
    total: Counter[str] = Counter()
    for (what, verdict), each in table.items():
        total[verdict] += each * (what != "nothing")
    print(name, dict(total), f"{time.process_time() - begin:.0f} s, seeds to {seed - 1}")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]))

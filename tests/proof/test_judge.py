"""No bent plan holds that a judge refuses who shares nothing with the proof.

`bend_many.py` bends more of them and counts.
"""

import numpy as np
import pytest
from bend_many import judged, judged_by
from bends import KINDS
from bent_cells import SHARE, URDFS, cases
from judge import Judge

from workbench.proof.prove import prove


@pytest.mark.parametrize(
    ("name", "seed", "bends"),
    [
        ("yumi", 40, 10),
        ("pallet", 41, 15),
        ("nests", 40, 10),
        ("panda", 45, 8),
        ("dual_fr3", 44, 6),
        ("baxter", 41, 4),
    ],
)
def test_nothing_holds_that_the_judge_refuses(name, seed, bends, tmp_path):
    if name in URDFS and not (SHARE / URDFS[name][0]).is_file():
        pytest.skip(f"the description of {name} is not installed")
    (case,) = cases(name, [seed], tmp_path)
    results = [(what, proof, refusal) for what, proof, refusal, _ in judged(case, seed, bends)]
    for what, proof, refusal in results:
        assert not (proof.holds and refusal is not None), (what, refusal)
        assert what != "nothing" or proof.holds
    assert any(refusal is not None for _, _, refusal in results)
    assert any(proof.holds for what, proof, _ in results if what != "nothing")


def test_no_kind_of_bend_holds_that_the_judge_refuses(tmp_path):
    (case,) = cases("tx2_90", [40], tmp_path)
    judge, verdicts = Judge(), []
    for number, kind in enumerate(KINDS):
        other = kind(case, np.random.default_rng([40, number]))
        holds = prove(other.cell, other.scene, other.plan).holds
        refusal = judged_by(judge, other)
        assert not (holds and refusal is not None), (kind.__name__, refusal)
        verdicts.append((holds, refusal is None))
    assert {(True, True), (False, False)} <= set(verdicts)

"""No bent plan holds that a judge refuses who shares nothing with the proof.

`bend_many.py` bends more of them and counts.
"""

from dataclasses import replace

import numpy as np
import pytest
from bend_many import judged, judged_by
from bends import KINDS
from bent_cells import SHARE, URDFS, cases
from judge import Judge
from judge_studies import cell_and_files
from judged_symmetry import turns

from workbench.app.picking.pipeline import plan_pick
from workbench.perception.simulation.piles import drop_parts
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


def test_the_judge_reads_grasps_that_a_symmetry_makes():
    """A cup on a round blank, some twelfths of a turn further round, perhaps upside down."""
    cell, files = cell_and_files("tx2_90", "full_bin.toml")
    pile = drop_parts(cell.parts[:1], cell.bin, seed=1)
    plan = plan_pick(cell, pile, "scan", seed=1).plan
    (one,) = plan.arms
    authored, _, turn = one.grasp.partition("@")
    assert authored and int(turn.partition("+")[0]) % 30 == 0
    for name, said in ((one.grasp, None), (authored, "otherwise"), (f"{authored}@90", "otherwise")):
        other = replace(plan, arms=(replace(one, grasp=name),))
        refusal = Judge().refusal(files, plan.scene, other)
        assert (refusal is None) == (said is None) == prove(cell, plan.scene, other).holds
        assert said is None or said in refusal.why
    other = replace(plan, arms=(replace(one, grasp=f"{authored}-9@30"),))
    assert Judge().refusal(files, plan.scene, other).why == "no such grasp"


@pytest.mark.parametrize(
    ("symmetry", "count"),
    [
        ({"fold": 1}, 1),
        ({"fold": 6}, 6),
        ({"fold": 4, "also": [{"axis": [1, 0, 0], "fold": 2}]}, 8),
        ({"fold": 4, "also": [{"axis": [1, 1, 1], "fold": 3}]}, 24),
        ({"fold": 0, "point_mm": [0, 0, 30], "also": [{"axis": [1, 0, 0], "fold": 2}]}, 720),
    ],
)
def test_the_judge_knows_all_turns_of_a_symmetry(symmetry, count):
    found = turns({"symmetry": symmetry}, 1.0)
    assert len(found) == count
    flat = found.reshape(count, 16)
    apart = np.abs(flat[:, None] - flat[None]).max(axis=2) + np.eye(count)
    assert apart.min() > 1e-3
    point = np.array([*symmetry.get("point_mm", (0, 0, 0)), 1000.0]) / 1000
    assert np.abs(found @ point - point).max() < 1e-12

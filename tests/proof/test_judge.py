"""No bent plan holds that a judge refuses who shares nothing with the proof.

`bend_many.py` bends more of them and counts.
"""

from dataclasses import replace

import numpy as np
import pytest
from bend_many import judged, judged_by
from bends import KINDS
from bent_cells import SHARE, URDFS, cases
from changed_cells import other_bin
from judge import Judge
from judge_studies import cell_and_files
from judge_symmetry import turns

from workbench.app.picking.pipeline import plan_pick
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import drop_parts
from workbench.proof.claims.places.layers import kept_box
from workbench.proof.claims.prove import prove


@pytest.mark.parametrize(
    ("name", "seed", "bends"),
    [
        ("yumi", 40, 10),
        ("pallet", 41, 15),
        ("nests", 40, 10),
        ("layers", 44, 14),
        ("two_bins", 40, 6),
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


def test_nothing_holds_that_goes_through_another_bin(tmp_path):
    (case,) = cases("two_bins", [41], tmp_path)
    judge, verdicts = Judge(), []
    assert judged_by(judge, case) is None
    for number in range(30):
        other = other_bin(case, np.random.default_rng([41, number]))
        holds = prove(other.cell, other.scene, other.plan).holds
        refusal = judged_by(judge, other)
        assert not (holds and refusal is not None), (number, refusal)
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


def test_the_judge_knows_pallets_in_layers(tmp_path):
    """A plan for layer 2, and the pallet otherwise than it was when that was made."""
    (case,) = cases("layers", [44], tmp_path)
    boxes = case.plan.obstacles
    assert len(boxes) == 4 and judged_by(Judge(), case) is None
    (arm,) = case.cell.arms

    def kept(number: int):
        T = arm.part_places[number].T_world_part
        return kept_box(case.cell, boxes, Detection("puck", T), T)

    for other, why in (
        (boxes[1:], "the layer beneath is not full"),
        ((*boxes, kept(4)), "a part is there"),
    ):
        plan = replace(case.plan, obstacles=other)
        bent = replace(case, plan=plan, scene=replace(case.scene, obstacles=other))
        assert judged_by(Judge(), bent).why == why
        assert not prove(bent.cell, bent.scene, bent.plan).holds
    said = replace(case, scene=replace(case.scene, obstacles=boxes[1:]))
    assert judged_by(Judge(), said).why == "has a part on a pallet that is not there"
    (low,) = cases("layers", [40], tmp_path)
    above = (kept(6),)
    plan = replace(low.plan, obstacles=above)
    bent = replace(low, plan=plan, scene=replace(low.scene, obstacles=above))
    assert judged_by(Judge(), low) is None
    assert judged_by(Judge(), bent).why == "a part is above"

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from bending import with_leg
from prepared_bench import make_results

from workbench.app.review.likeness import MOVED, Likeness, resemblance
from workbench.model.geometry import pose_from_rpy
from workbench.model.prediction import EmptiedPile, Emptying, PileTask
from workbench.model.scan import Detection, Scan


@pytest.fixture(scope="module")
def results():
    return make_results()


@pytest.fixture
def scan():
    points = np.random.default_rng(1).normal(size=(4000, 3))
    pixels = np.arange(4000)
    return Scan(points, pin.SE3.Identity(), "drawn", pixels=pixels, resolution=(80, 50))


def moved(scan, by, count):
    points = np.array(scan.points)
    points[:count, 2] += by
    return replace(scan, points=points)


def without(scan, count):
    return replace(scan, points=scan.points[count:], pixels=scan.pixels[count:])


def test_the_same_scan_is_equal(results, scan):
    assert resemblance(results.cell, scan, replace(scan, at=5.0)).says == "equal"


def test_a_scan_that_was_rounded_otherwise_is_the_same_and_says_by_how_much(results, scan):
    found = resemblance(results.cell, scan, moved(scan, 4e-6, 17))
    assert found.likeness is Likeness.WITHIN
    assert found.says == "the same within 0.004 mm; 17 of 4,000 points differ"


def test_a_ray_that_meets_what_is_behind_an_edge_is_named(results, scan):
    found = resemblance(results.cell, scan, moved(without(scan, 2), 0.02, 1))
    assert found.likeness is Likeness.WITHIN
    assert "3 of 4,000 points differ, 3 of them lie elsewhere" in found.says


@pytest.mark.parametrize(
    "change",
    [
        lambda scan: moved(scan, 2 * MOVED, 5),
        lambda scan: without(scan, 5),
        lambda scan: replace(scan, T_world_scanner=pose_from_rpy((0, 0, 1e-6), (0, 0, 0))),
        lambda scan: replace(scan, resolution=(50, 80)),
        lambda scan: replace(scan, pixels=None, resolution=None),
    ],
)
def test_another_scan_is_another(results, scan, change):
    assert resemblance(results.cell, scan, change(scan)).likeness is Likeness.OTHER


def test_clouds_without_pixels_are_compared_in_their_order(results, scan):
    cloud = replace(scan, pixels=None, resolution=None)
    near = resemblance(results.cell, cloud, moved(cloud, 1e-9, 4000))
    assert near.likeness is Likeness.WITHIN
    fewer = replace(cloud, points=cloud.points[1:])
    assert "3,999 points instead of 4,000" in resemblance(results.cell, cloud, fewer).says


def elsewhere(detection: Detection, distance=0.0, turn=0.0, **fields) -> Detection:
    T = detection.T_world_part * pose_from_rpy((distance, 0.0, 0.0), (0.0, turn, 0.0))
    return replace(detection, T_world_part=T, **fields)


@pytest.mark.parametrize(
    ("change", "likeness", "says"),
    [
        (lambda one: elsewhere(one, 1e-9), Likeness.WITHIN, "the same within 0.001 mm and"),
        (lambda one: elsewhere(one, turn=1e-5), Likeness.WITHIN, "0.001 degrees"),
        (lambda one: elsewhere(one, 3e-4), Likeness.OTHER, "part 1 lies 0.3 mm and"),
        (lambda one: elsewhere(one, turn=0.01), Likeness.OTHER, "0.57 degrees elsewhere"),
        (lambda one: elsewhere(one, score=0.8), Likeness.OTHER, "a score of 0.800 instead of"),
        (lambda one: elsewhere(one, roll_known=False), Likeness.OTHER, "roll unknown now"),
        (lambda one: replace(one, part="bolt"), Likeness.OTHER, "part 1 lies 141 mm and"),
    ],
)
def test_parts_are_compared_one_by_one(results, change, likeness, says):
    first, *rest = results.detections
    found = resemblance(results.cell, results.detections, (change(first), *rest))
    assert found.likeness is likeness and says in found.says


def test_parts_that_come_in_another_order_are_the_same(results):
    found = resemblance(results.cell, results.detections, results.detections[::-1])
    assert found.likeness is Likeness.WITHIN


def test_a_part_of_another_kind_is_another_result(results):
    (first, _) = results.detections
    found = resemblance(results.cell, (first,), (replace(first, part="bolt"),))
    assert found.says == "another result: part 1, a keyed_cylinder, is another one"


def test_a_part_less_is_another_result(results):
    found = resemblance(results.cell, results.detections, results.detections[:1])
    assert found.says == "another result: 1 parts instead of 2"


def with_plan(planned, plan):
    return replace(planned, plan=plan)


def test_how_long_a_planning_took_does_not_count(results):
    planned = results.planned
    slower = replace(planned, seconds={}, plan=replace(planned.plan, seconds={"route": 9.0}))
    assert resemblance(results.cell, planned, slower).says == "equal"


def test_a_plan_rounded_to_the_next_step_is_the_same_when_the_recorded_one_is_proven(results):
    plan = results.planned.plan
    arm = plan.arms[0]
    leg = arm.leg("reach")
    q = np.array(leg.q)
    q[1] += np.deg2rad(0.01)
    again = with_plan(results.planned, with_leg(plan, arm.arm, "reach", q=q))
    found = resemblance(results.cell, results.planned, again)
    assert found.likeness is Likeness.WITHIN
    assert found.says == (
        "the same within 0.01 degrees in every joint; the recorded plan is proven here too"
    )
    q[1] += np.deg2rad(1.0)
    again = with_plan(results.planned, with_leg(plan, arm.arm, "reach", q=q))
    found = resemblance(results.cell, results.planned, again)
    assert found.likeness is Likeness.OTHER
    assert f"another way for the {arm.arm} arm, reach" in found.says


def test_a_recorded_plan_that_is_not_proven_here_is_never_the_same(results):
    plan = results.planned.plan
    arm = plan.arms[0]
    q = np.array(arm.leg("reach").q)
    q[1:-1] += np.deg2rad(40.0)
    bent = with_plan(results.planned, with_leg(plan, arm.arm, "reach", q=q))
    found = resemblance(results.cell, bent, results.planned)
    assert found.likeness is Likeness.OTHER and "is NOT proven here too" in found.says


def test_what_became_of_candidates_and_of_the_plan_is_compared(results):
    planned = results.planned
    none = replace(planned, plan=None, proof=None)
    assert resemblance(results.cell, planned, none).says == "another result: no plan now"
    assert resemblance(results.cell, none, planned).says == "another result: a plan now"
    fewer = replace(planned, candidates=planned.candidates[1:])
    assert "candidates instead of" in resemblance(results.cell, planned, fewer).says
    first, *rest = planned.candidates
    verdict = next(one.verdict for one in rest if one.verdict.reason is not first.verdict.reason)
    changed = replace(first, verdict=verdict)
    other = replace(planned, candidates=(changed, *rest))
    assert (
        "1 of 60 candidates with another verdict" in resemblance(results.cell, planned, other).says
    )


def test_piles_emptied_again_are_equal_whatever_the_clock_says(results):
    pile = EmptiedPile(PileTask("peg_cell", "peg", 3, 5), 3, 2, (0, 0, 0), 0, 0, 2, 4, 7.5, (),
                       (0.2,), (("propose", 0.2),), 0.0)  # fmt: skip
    kept = Emptying(results.cell.digest, (pile,))
    slower = replace(pile, planning=(0.9,), stages=(("propose", 0.9),), finding=1.0)
    assert resemblance(results.cell, kept, replace(kept, piles=(slower,))).says == "equal"
    other = resemblance(results.cell, kept, replace(kept, piles=(replace(pile, taken=1),)))
    assert other.likeness is Likeness.OTHER
    assert "seed 5: 1 of 3 parts taken instead of 2" in other.says
    fewer = resemblance(results.cell, kept, replace(kept, piles=()))
    assert fewer.likeness is Likeness.OTHER and "0 piles instead of 1" in fewer.says

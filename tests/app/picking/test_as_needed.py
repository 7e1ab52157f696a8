"""Where no plan comes out, all lifts and fingers less open are tried, if the cell permits it."""

from dataclasses import replace

import pytest
from make_plans import cell_of, kept

from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick

SEED = 111
"""Of a scene in which the fingers, as open as the grasps say, meet the wall."""


@pytest.fixture(scope="module")
def cell():
    return cell_of("two parts")


@pytest.fixture(scope="module")
def pile():
    return next(pile for name, seed, pile, _ in kept() if (name, seed) == ("two parts", SEED))


def test_fingers_arrive_less_open_and_the_plan_is_proven(cell, pile):
    result = plan_pick(cell, pile, "scan", seed=SEED)
    assert result.plan is not None and result.proof is not None and result.proof.holds
    grasps = {grasp.name: grasp for part in cell.parts for grasp in part.grasps}
    assert any(arm.leg("reach").opening < grasps[arm.grasp].opening for arm in result.plan.arms)
    judged = judge(cell, pile, seed=SEED)
    assert [each.verdict.is_ok for each in judged] == [
        each.verdict.is_ok for each in result.candidates
    ]


def test_a_cell_that_wants_none_of_it_gets_no_plan(cell, pile):
    quick = replace(cell, policy=replace(cell.policy, as_needed=False))
    assert plan_pick(quick, pile, "scan", seed=SEED).plan is None
    assert not any(each.verdict.is_ok for each in judge(quick, pile, seed=SEED))

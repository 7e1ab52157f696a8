"""One arm of any name, and three arms of which two work while the third stands in the way."""

from dataclasses import replace

import numpy as np
import pytest
from shipped import without_search
from three_arms import NAMES, write_cell

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.model.derived.by_recipe import strategies_of
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import Guarantee
from workbench.model.scan import Detection
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import is_solution
from workbench.planning.picking.dual_arm import pairs_of
from workbench.planning.picking.order import cost_of
from workbench.planning.picking.resolve import resolve


def pucks(*places):
    """Pucks that lie on the bin's floor there [m]."""
    return tuple(Detection("puck", pose_from_rpy((x, y, 0.0075))) for x, y in places)


SOUTH = pucks((-0.1, -0.08), (0.1, -0.08))
"""Parts that the two arms in the south are nearest to."""


@pytest.fixture(scope="module")
def around(tmp_path_factory):
    return read_cell(write_cell(tmp_path_factory.mktemp("three") / "cell"))


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    return read_cell(write_cell(tmp_path_factory.mktemp("one") / "cell", ("manipulator",)))


@pytest.fixture(scope="module")
def blocked(around):
    """The cell with the home of the arm in the north over the bin, its cup between the parts."""
    arm = around.arm("north")
    chain = World(around, ()).chains["north"]
    T = pose_from_rpy((0.0, -0.08, 0.08), (np.pi, 0.0, 0.0))
    answers, residuals = chain.solve(T, np.array([arm.home]))
    assert is_solution(residuals).all()
    home = around.controller.motion.rounded(answers[0])
    quick = replace(around.policy, as_needed=False)
    arms = (replace(arm, home=home), *around.arms[1:])
    return without_search(replace(around, arms=arms, policy=quick))


@pytest.mark.parametrize("strategy", ["auto", "manipulator"])
def test_the_only_arm_can_be_called_manipulator(one, strategy):
    result = plan_pick(one, pucks((0.0, 0.05), (0.1, -0.05)), "scan", strategy=strategy, seed=0)
    assert (result.plan.strategy, result.plan.strategy.arm) == ("manipulator", "manipulator")
    assert [arm.arm for arm in result.plan.arms] == ["manipulator"]
    assert result.proof.holds
    assert strategies_of(one) == ("auto", "manipulator")


def test_an_arm_that_the_cell_does_not_have_is_no_strategy(one):
    expected = "strategy 'right' is not one of auto, manipulator in cell around"
    with pytest.raises(InputError, match=expected):
        plan_pick(one, pucks((0.0, 0.0)), "scan", strategy="right", seed=0)


@pytest.mark.parametrize("strategy", ["alternated", "coordinated"])
def test_two_arms_of_three_work(around, strategy):
    result = plan_pick(around, SOUTH, "scan", strategy=strategy, seed=0)
    assert result.plan.strategy == strategy
    assert {arm.arm for arm in result.plan.arms} == {"south-west", "south_east"}
    assert result.proof.holds


def test_of_three_arms_each_can_work_alone(around):
    assert strategies_of(around) == ("auto", "alternated", "coordinated", *NAMES, "both")
    for name in NAMES:
        result = plan_pick(around, SOUTH, "scan", strategy=name, seed=0)
        assert [arm.arm for arm in result.plan.arms] == [name]
        assert result.proof.holds


def test_of_all_pairs_of_arms_the_cheapest_is_taken(around):
    parts = pucks((0.0, 0.1), (-0.1, -0.08))
    result = plan_pick(around, parts, "scan", strategy="alternated", seed=0)
    world = World(around, parts)
    picks = [resolve(world, one, seed=0) for one in result.candidates if one.verdict.is_ok]
    pairs = pairs_of(world, picks, cost_of(world, around.policy.order))
    arms = {tuple(pick.candidate.arm for pick in pair) for pair in pairs}
    assert {frozenset(pair) for pair in arms} == {frozenset(NAMES) - {name} for name in NAMES}
    cheapest = min(pairs, key=lambda pair: pair[0].seconds + pair[1].seconds)
    taken = [(arm.arm, arm.detection) for arm in result.plan.arms]
    assert taken == [(pick.candidate.arm, pick.candidate.detection) for pick in cheapest]


def test_parts_that_one_arm_may_not_take_are_taken_by_the_other_two(around):
    part = around.parts[0]
    entries = (replace(g, arms=("north", "south_east")) for g in part.library.entries)
    library = replace(part.library, entries=tuple(entries))
    without = replace(around, parts=(replace(part, library=library),))
    result = plan_pick(without, SOUTH, "scan", strategy="alternated", seed=0)
    assert {arm.arm for arm in result.plan.arms} == {"north", "south_east"}
    assert result.proof.holds


def is_of_north(pair):
    """Whether one of two things that meet belongs to the arm in the north."""
    return pair is not None and any("north" in name or "link_0" in name for name in pair)


def test_the_planner_takes_nothing_where_another_arm_stands_in_the_way(blocked):
    result = plan_pick(blocked, SOUTH, "scan", strategy="south-west", seed=0)
    assert result.plan is None
    refused = [one.verdict for one in result.candidates if one.arm == "south-west"]
    assert any(is_of_north(verdict.pair) for verdict in refused)


@pytest.mark.parametrize("strategy", ["south_east", "alternated", "coordinated"])
def test_the_proof_finds_an_arm_that_stands_in_the_way(around, blocked, strategy):
    plan = plan_pick(around, SOUTH, "scan", strategy=strategy, seed=0).plan
    assert (plan.guarantee is Guarantee.ONE_AT_A_TIME) == (strategy == "south_east")
    # As if the planner had not seen where the third arm stands.
    proof = prove(blocked, replace(plan, cell_digest=blocked.digest))
    assert not proof.holds
    met = [one for one in proof.violations if is_of_north(one.pair)]
    assert met
    assert all(one.arm != "north" for one in proof.violations)
    assert not any(one.problem.text is ProofText.MARGIN_BESIDE for one in met)

"""Orders by name: what comes first, and that a plan follows."""

from dataclasses import replace

import numpy as np
import pytest
from shipped import shipped

from workbench.app.picking.pipeline import plan_pick
from workbench.model.candidate import Pick
from workbench.model.cell import ORDER_NAMES, PlanOverrides
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.planning.collision.world import World
from workbench.planning.picking.assign import plan_first_feasible
from workbench.planning.picking.dual_arm import pairs_of
from workbench.planning.picking.order import cost_of
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve

CELL = shipped("yumi")
FLOOR = CELL.bin.T_world_bin.translation
# x, y in the bin, how high, the score, and how it is turned.
LYING = (
    (-0.05, -0.09, 0.0, 0.7, 0.2),
    (0.0, 0.0, 0.004, 0.8, 0.2),
    (0.05, 0.09, 0.002, 0.9, 0.2),
)


def lying(x: float, y: float, z: float, score: float, yaw: float) -> Detection:
    T = pose_from_rpy(FLOOR + (x, y, 0.0191 + z), (np.pi / 2, 0, yaw))
    return Detection("keyed_cylinder", T, score)


DETECTIONS = tuple(lying(*one) for one in LYING)


@pytest.fixture(scope="module")
def world() -> World:
    return World(CELL, DETECTIONS)


@pytest.fixture(scope="module")
def picks(world) -> list[Pick]:
    found = [resolve(world, one, seed=0) for one in propose(world)]
    return [pick for pick in found if isinstance(pick, Pick)]


def first_part(world, picks, order) -> int:
    return min(picks, key=cost_of(world, order)).candidate.detection


@pytest.mark.parametrize(("order", "part"), [("highest", 1), ("score", 2), ("walls", 1)])
def test_an_order_puts_its_part_first(world, picks, order, part):
    assert {pick.candidate.detection for pick in picks} == {0, 1, 2}
    assert first_part(world, picks, order) == part


def test_the_thesis_gives_each_arm_its_side_and_the_farther_part_first(world, picks):
    (master, slave), *_ = pairs_of(world, picks, cost_of(world, "thesis"))
    sides = {"right": -1, "left": 1}
    for pick in (master, slave):
        y = LYING[pick.candidate.detection][1]
        assert y * sides[pick.candidate.arm] >= 0
    away = [np.hypot(*LYING[pick.candidate.detection][:2]) for pick in (master, slave)]
    assert away[0] >= away[1]


def test_parts_that_only_rub_off_wait_until_nothing_else_can_be_taken(world, picks):
    first = min(picks, key=cost_of(world, "travel")).candidate.detection

    def taken(rubbing: set[int]) -> set[int]:
        marked = [
            replace(one, gain=0.0 if one.candidate.detection in rubbing else 0.003) for one in picks
        ]
        plans, verdict = plan_first_feasible(
            world, marked, "auto", 0.0, "test", seed=0, cancelled=lambda: False
        )
        assert plans, verdict
        return {arm.detection for arm in plans[0].arms}

    assert len(taken(set())) == 2
    assert first not in taken({first})
    assert taken({0, 1}) == {2}, "one alone rather than one that rubs beside it"
    assert len(taken({0, 1, 2})) == 2, "they are not refused"


@pytest.mark.extensive
@pytest.mark.parametrize("order", ORDER_NAMES)
def test_every_order_leads_to_a_proven_plan(order):
    # With both arms at once, parts that the arms would meet over are left for later.
    result = plan_pick(
        CELL,
        DETECTIONS,
        "test",
        strategy="alternated",
        overrides=PlanOverrides(order=order),
        seed=0,
    )
    assert result.plan is not None and result.proof.holds
    assert len(result.plan.arms) == 2
    if order in ("highest", "walls"):
        assert 1 in {arm.detection for arm in result.plan.arms}

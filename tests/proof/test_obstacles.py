"""Obstacles that only the scan shows: planned around, in the plan's file, and in its proof."""

from dataclasses import replace

import numpy as np
import pytest
from shipped import shipped

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.candidate import Reason
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.world import World

CELL = shipped("yumi")
FLOOR = CELL.bin.T_world_bin.translation
PART = Detection("keyed_cylinder", pose_from_rpy(FLOOR + (0.0, -0.05, 0.0191), (np.pi / 2, 0, 0.3)))


def upright(x: float, y: float, height: float, side: float = 0.04) -> Obstacle:
    at = FLOOR + (x, y, height / 2)
    return Obstacle(pose_from_rpy(at), np.array([side, side, height]))


@pytest.fixture(scope="module")
def free():
    return plan_pick(CELL, (PART,), "test", strategy="right", seed=0)


@pytest.fixture(scope="module")
def tower(free):
    """Something high beside the part, in the way of the plan made without it."""
    tower = upright(-0.06, -0.13, 0.25, 0.06)
    in_the_way = replace(free.plan, obstacles=(tower,))
    assert not prove(CELL, in_the_way).holds
    return tower


def test_what_is_seen_is_kept_clear_of(free, tower):
    with_tower = plan_pick(CELL, (PART,), "test", strategy="right", seed=0, obstacles=(tower,))
    assert with_tower.plan is not None and with_tower.proof.holds
    assert with_tower.plan.obstacles == (tower,)
    assert with_tower.plan.digest != free.plan.digest


def test_a_plan_through_an_obstacle_fails_its_proof(free):
    leg = free.plan.arms[0].leg("return")
    world = World(CELL, (PART,))
    middle = world.chains["right"].pose(np.asarray(leg.q[len(leg.q) // 2])).translation
    ball = Obstacle(pose_from_rpy(middle), np.full(3, 0.05))
    proof = prove(CELL, replace(free.plan, obstacles=(ball,)))
    assert not proof.holds
    assert any("seen-1" in (violation.pair or ()) for violation in proof.violations)


def test_a_part_under_an_obstacle_cannot_be_taken():
    lid = Obstacle(pose_from_rpy(FLOOR + (0.0, -0.05, 0.05)), np.array([0.14, 0.14, 0.03]))
    result = plan_pick(CELL, (PART,), "test", seed=0, obstacles=(lid,))
    assert result.plan is None
    hit = [one.verdict for one in result.candidates if "seen-1" in (one.verdict.pair or ())]
    assert hit and all(verdict.reason is not Reason.OK for verdict in hit)


def test_obstacles_survive_the_file_of_a_plan(tmp_path, tower):
    result = plan_pick(CELL, (PART,), "test", strategy="right", seed=0, obstacles=(tower,))
    write_plan(tmp_path / "plan.json", result.plan, result.proof)
    again, stated = read_plan(tmp_path / "plan.json")
    assert again.digest == stated == result.plan.digest
    assert prove(CELL, again).holds

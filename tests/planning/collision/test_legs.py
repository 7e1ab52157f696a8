"""What holds for each leg and grip of an arm."""

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from bending import with_grasps

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.candidate import Pick
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp
from workbench.planning.collision.legs import FREE_STEP, SLIDE_STEP, TILT_STEP, grips, stretches
from workbench.planning.collision.world import World
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve


def turns_of(tool, **free):
    """Turns about z, tilts about y [rad] and moves along x [m] of the grips of a hand."""
    grasp = Grasp("g", pin.SE3.Identity(), opening=0.02, grip=0.01, **free)
    poses = grips(tool, grasp)
    return [
        (math.atan2(T.rotation[1, 0], T.rotation[1, 1]), math.asin(T.rotation[0, 2]), x)
        for T, x in ((T, float(T.translation[0])) for T in poses)
    ]


def test_two_fingers_can_change_places_and_a_sucker_cannot(cell):
    arm = cell.arms[0]
    assert [abs(turn) for turn, _, _ in turns_of(arm.tool)] == pytest.approx([0.0, math.pi])
    sucker = replace(arm.tool, fingers=())
    assert turns_of(sucker) == [(0.0, 0.0, 0.0)]


@pytest.mark.parametrize("free", [0.1, math.radians(30), math.radians(100), math.pi])
def test_free_rotation_is_covered_in_steps_both_ways(cell, free):
    sucker = replace(cell.arms[0].tool, fingers=())
    turns = [turn for turn, _, _ in turns_of(sucker, free_rotation=free)]
    assert turns[0] == 0.0
    assert max(turns) == pytest.approx(free)
    assert np.diff(sorted(turns)).max() <= FREE_STEP + 1e-9


def test_tilt_and_slide_are_covered_in_steps_the_authored_pose_first(cell):
    sucker = replace(cell.arms[0].tool, fingers=())
    found = turns_of(sucker, tilt=0.4, slide=0.015)
    assert found[0] == (0.0, 0.0, 0.0)
    tilts, slides = (sorted({round(one[k], 9) for one in found}) for k in (1, 2))
    assert (tilts[0], tilts[-1]) == pytest.approx((-0.4, 0.4))
    assert (slides[0], slides[-1]) == pytest.approx((-0.015, 0.015))
    assert np.diff(tilts).max() <= TILT_STEP
    assert np.diff(slides).max() <= SLIDE_STEP
    assert len(found) == len(tilts) * len(slides)


def where(phase) -> dict[str, int]:
    return {arm: number for arm, (number, _, _) in phase.placed.items()}


def test_the_stretches_a_plan_tell_where_each_part_is(result):
    first, second = result.plan.arms
    seen = {
        (arm.arm, leg.name): stretch.phase
        for stretch in stretches(result.plan)
        for arm, leg in stretch.runs
    }
    assert len(seen) == 12
    assert seen[first.arm, "approach"].targets == {first.arm: first.detection}
    assert not seen[first.arm, "approach"].held
    assert seen[first.arm, "return"].held[first.arm][0] == first.detection
    assert not seen[first.arm, "place"].placed
    assert where(seen[first.arm, "home"]) == {first.arm: first.detection}
    assert where(seen[second.arm, "reach"]) == {first.arm: first.detection}
    both = {one.arm: one.detection for one in (first, second)}
    assert where(seen[second.arm, "home"]) == both


def test_a_turned_hand_still_comes_and_leaves_as_authored(cell, detections):
    """Fingers may change places; a slanting approach then must not slant the other way."""
    slant = np.array([0.3, 0.0, math.sqrt(1 - 0.09)])
    slanting = with_grasps(
        cell, lambda g: replace(g, approach=slant, retreat=-slant, approach_length=0.04)
    )
    world = World(slanting, detections)
    turned = 0
    for candidate in propose(world):
        if not candidate.verdict.is_ok:
            continue
        pick = resolve(world, candidate, seed=0)
        if not isinstance(pick, Pick):
            continue
        chain = world.chains[candidate.arm]
        start, grasp, end = (
            chain.pose(q) for q in (pick.approach[0], pick.approach[-1], pick.extract[-1])
        )
        way = candidate.T_world_tcp.rotation @ slant
        np.testing.assert_allclose(grasp.translation - start.translation, 0.04 * way, atol=5e-4)
        np.testing.assert_allclose(end.translation - grasp.translation, -0.1 * way, atol=5e-4)
        turned += (candidate.T_world_tcp.rotation[:, 0] @ grasp.rotation[:, 0]) < 0
    assert turned > 0, "no candidate was taken with the fingers changed"


def test_a_grasp_that_may_turn_is_tried_turned(cell, detections):
    """Authored with the fingers along the cylinder, where nothing is narrow enough."""
    quarter = pose_from_rpy((0, 0, 0), (0, 0, math.pi / 2))

    def admitted(free: float) -> list:
        along = with_grasps(
            cell,
            lambda g: replace(g, T_part_tcp=g.T_part_tcp * quarter, free_rotation=free),
        )
        return [c for c in propose(World(along, detections)) if c.verdict.is_ok]

    assert not admitted(0.0)
    plain = [c for c in propose(World(cell, detections)) if c.verdict.is_ok]
    assert len(admitted(math.pi / 2)) == len(plain)


def test_a_plan_with_a_turned_hand_is_proven(cell, detections):
    quarter = pose_from_rpy((0, 0, 0), (0, 0, math.pi / 2))
    along = with_grasps(
        cell, lambda g: replace(g, T_part_tcp=g.T_part_tcp * quarter, free_rotation=math.pi / 2)
    )
    result = plan_pick(along, detections, "scan", seed=0)
    assert result.proof is not None
    assert result.proof.holds, result.proof.violations
    narrower = with_grasps(along, lambda g: replace(g, free_rotation=0.1))
    bent = prove(narrower, replace(result.plan, cell_digest=narrower.digest))
    assert any("not in the hand" in str(violation.problem) for violation in bent.violations)

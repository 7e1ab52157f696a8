"""A plan is right for every turn of a part whose roll nobody knows, or it is not proven."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from bending import with_grasps

from workbench.app.picking.pipeline import plan_pick
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.proof.claims.prove import prove
from workbench.proof.claims.scene import turned_pieces, turned_rooms
from workbench.proof.engine.shapes import hull


def problems(cell, plan, scene=None) -> str:
    return "; ".join(map(str, prove(cell, scene or plan.scene, plan).violations))


def unknown(plan):
    """The same plan, whose parts may be rolled."""
    rolled = tuple(replace(one, roll_known=False) for one in plan.detections)
    return replace(plan, detections=rolled)


def test_a_plan_may_be_no_surer_of_a_roll_than_the_scan(cell, result):
    plan = result.plan
    scene = unknown(plan).scene
    said = problems(cell, plan, scene)
    assert "states a roll of part-1 that the scan does not show" in said
    axis = np.array([[0.001, 0.0, 0.0], [0.0, 0.0, 1.0]])
    aside = tuple(replace(one, roll_axis=axis) for one in scene.detections)
    other = Scene(scene.scan_digest, aside)
    assert "a roll of part-1 that the scan does not show" in problems(cell, unknown(plan), other)
    assert "a roll of" not in problems(cell, unknown(plan), plan.scene)


@pytest.fixture(scope="module")
def over_key(cell):
    return with_grasps(
        cell, lambda g: replace(g, T_part_tcp=pose_from_rpy((0, 0, 0.03)) * g.T_part_tcp)
    )


def test_hands_that_hold_a_part_at_some_turns_alone_are_no_hands_for_it(over_key, detections):
    plan = plan_pick(over_key, detections, "scan", seed=0).plan
    assert plan is not None and problems(over_key, plan) == ""
    assert "does not hold the part if it is turned by" in problems(over_key, unknown(plan))


def test_places_that_need_the_roll_are_asked_again(cell, result):
    careful = replace(cell, arms=tuple(replace(arm, needs_roll=True) for arm in cell.arms))
    plan = replace(unknown(result.plan), cell_digest=careful.digest)
    assert "its places need the roll of the part" in problems(careful, plan)
    assert "its places need" not in problems(
        careful, replace(plan, detections=result.plan.detections)
    )


def test_a_piece_is_in_its_room_at_every_turn(cell, result):
    part, found = cell.parts[0], unknown(result.plan).detections[0]
    for (room, T_world_room), places in zip(
        turned_rooms(part, found), turned_pieces(part, found), strict=True
    ):
        for shape, T_world_piece in places:
            corners = np.array(list(product((-1, 1), repeat=3))) * hull(shape).box
            disc = hull(shape).disc * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
            points = (corners[:, None] + np.pad(disc, ((0, 0), (0, 1)))).reshape(-1, 3)
            seen = (T_world_room.inverse() * T_world_piece).act
            inside = np.array([seen(point) for point in points])
            assert np.abs(inside[:, 2]).max() <= room.length / 2 + 1e-9
            assert np.linalg.norm(inside[:, :2], axis=1).max() <= room.radius + 1e-9


def test_a_key_that_may_be_under_something_is_not_lifted(cell):
    """A small plate beside the body, 2 mm from it: the key may be below that, or not."""
    upright = replace(cell, policy=replace(cell.policy, lift_lean=0.0))
    T_bin = cell.bin.T_world_bin
    T = T_bin * pose_from_rpy((0, 0, 0.0195), (0, np.pi / 2, 0))
    found = (Detection("keyed_cylinder", T),)
    at = T_bin * pose_from_rpy((0.018, 0.018, 0.0195 + 0.003 + 0.01))
    plate = Obstacle(at, np.array([0.012, 0.002, 0.02]))
    plan = plan_pick(upright, found, "scan", obstacles=(plate,), seed=0).plan
    assert plan is not None and problems(upright, plan) == ""
    assert "does not come off its support at every turn" in problems(upright, unknown(plan))
    free = plan_pick(upright, found, "scan", seed=0).plan
    assert "at every turn" not in problems(upright, unknown(free))

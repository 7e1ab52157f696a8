"""A part is proven to come onto another one straight, as near as stated and no farther."""

import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from assembling import (
    assembly_cell,
    insertion,
    moved,
    placed_bolt,
    standing_spacer,
    turn,
    with_insertion,
)
from bending import with_leg

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.derived.assembling import rest_pose
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Obstacle, Scene
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.kinematics.straight import follow
from workbench.proof.claims.places.layers import kept_box
from workbench.proof.claims.prove import prove, scene_after
from workbench.proof.claims.stages import put_at
from workbench.proof.engine.robot import tree_of

WAYS = {"x": (1, 0, 0), "y": (0, 1, 0), "-x": (-1, 0, 0), "slant": (0.7, 0.7, 0)}


@pytest.fixture(scope="module")
def cell():
    return assembly_cell()


@pytest.fixture(scope="module")
def plan(cell):
    result = plan_pick(
        cell, (standing_spacer(cell),), "scan", obstacles=placed_bolt(cell), strategy="right"
    )
    assert result.plan is not None, str(result.verdict)
    return result.plan


def said(cell, plan, scene: Scene | None = None) -> str:
    """What a proof says of a plan in a cell that differs in its recipe alone."""
    plan = replace(plan, cell_digest=cell.digest)
    proof = prove(cell, plan.scene if scene is None else scene, plan)
    return "; ".join(str(one) for one in proof.violations)


def with_way(cell, plan, T_begin: pin.SE3, T_end: pin.SE3):
    """The plan whose insertion begins and ends elsewhere, by motions in the world about the seat.

    The legs before and after it go along, so that the way is one.
    """
    (arm_plan,) = plan.arms
    chain, place = chain_of(cell, cell.arm(arm_plan.arm)), np.asarray(arm_plan.leg("place").q)
    ends = [chain.pose(place[k]) for k in (0, -1)]
    seat = ends[1].translation
    about = pin.SE3(np.eye(3), seat)
    begin, end = (
        about * T * about.inverse() * T_tcp for T, T_tcp in zip((T_begin, T_end), ends, strict=True)
    )
    (solved,), residuals = chain.solve(end, place[-1][None])
    assert residuals.max() < 1e-3
    path, share = follow(chain, solved, begin, len(place))
    assert share == 1.0
    path = cell.controller.motion.rounded(path[::-1])
    plan = with_leg(plan, arm_plan.arm, "place", q=path)
    for name, row, q in (("return", -1, path[0]), ("home", 0, path[-1])):
        rows = np.array(arm_plan.leg(name).q)
        rows[row] = q
        plan = with_leg(plan, arm_plan.arm, name, q=rows)
    return plan


def test_a_plan_that_assembles_holds_and_its_file_brings_it_back(cell, plan, tmp_path):
    assert said(cell, plan) == ""
    assert said(cell, with_way(cell, plan, pin.SE3.Identity(), pin.SE3.Identity())) == ""
    write_plan(tmp_path / "plan.json", plan)
    again, stated = read_plan(tmp_path / "plan.json")
    assert (again.digest, stated) == (plan.digest, plan.digest)
    assert [box.part for box in again.obstacles] == ["bolt"]


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("far", [0.0007, 0.001, 0.002, 0.005])
def test_a_base_that_stands_elsewhere_is_the_wrong_one(cell, plan, way, far):
    elsewhere = moved(cell, plan.obstacles[0], pin.SE3(np.eye(3), far * np.array(way)))
    words = said(cell, replace(plan, obstacles=(elsewhere,)))
    assert "from its seat" in words or "within the safety margin" in words


@pytest.mark.parametrize("axis", "xy")
@pytest.mark.parametrize("degrees", [-10, -4, -1.5, 1.5, 4, 10])
def test_a_base_that_leans_is_the_wrong_one(cell, plan, axis, degrees):
    leaning = moved(cell, plan.obstacles[0], turn(axis, degrees))
    assert "from its seat" in said(cell, replace(plan, obstacles=(leaning,)))


def test_without_its_base_or_with_another_part_in_its_stead_nothing_is_assembled(cell, plan):
    (bolt,) = plan.obstacles
    unsure = Obstacle(bolt.T_world_box, bolt.size)
    other = replace(bolt, part="spacer")
    for obstacles in ((), (unsure,)):
        words = said(cell, replace(plan, obstacles=obstacles))
        assert "spacer comes onto bolt, and no bolt is known to stand" in words
    assert "has its spacer already" in said(cell, replace(plan, obstacles=(other,)))
    assert "has its spacer already" in said(cell, replace(plan, obstacles=(bolt, other)))
    assert "has its bolt already" in said(cell, replace(plan, obstacles=(bolt, bolt)))


def test_a_plan_does_not_say_by_itself_that_the_base_stands_there(cell, plan):
    (bolt,) = plan.obstacles
    scenes = [Scene(plan.scan_digest, plan.detections, obstacles) for obstacles in ((), (bolt,))]
    assert "seen-1" in said(cell, plan, scenes[0])
    turned = moved(cell, bolt, turn("z", 60.0))
    assert "seen-1" in said(cell, replace(plan, obstacles=(turned,)), scenes[1])


@pytest.mark.parametrize("far", [0.0006, 0.001, 0.0015, 0.003, 0.006])
@pytest.mark.parametrize("up", [-1.0, 1.0], ids=["past", "short"])
def test_an_insertion_that_ends_past_the_seat_or_before_it_is_refused(cell, plan, far, up):
    off = pin.SE3(np.eye(3), np.array([0.0, 0.0, up * far]))
    words = said(cell, with_way(cell, plan, pin.SE3.Identity(), off))
    (ends,) = re.findall(r"ends ([\d.]+) mm from its seat", words)
    assert float(ends) == pytest.approx(far * 1000, abs=0.2)


@pytest.mark.parametrize("axis", "xy")
@pytest.mark.parametrize("degrees", [-6.0, -3.0, -2.0, 2.0, 3.0, 6.0])
def test_a_tilted_insertion_is_refused(cell, plan, axis, degrees):
    T = turn(axis, degrees)
    assert "from its seat" in said(cell, with_way(cell, plan, T, T))


@pytest.mark.parametrize("axis", "xy")
@pytest.mark.parametrize("degrees", [-8.0, -4.0, 4.0, 8.0])
def test_a_part_that_turns_upright_on_its_way_is_refused(cell, plan, axis, degrees):
    words = said(cell, with_way(cell, plan, turn(axis, degrees), pin.SE3.Identity()))
    assert "off the straight line to its seat" in words


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("far", [0.001, 0.003, 0.01])
def test_an_insertion_from_another_direction_is_refused(cell, plan, way, far):
    off = pin.SE3(np.eye(3), far * np.array(way))
    words = said(cell, with_way(cell, plan, off, pin.SE3.Identity()))
    assert "off the straight line to its seat" in words


@pytest.mark.parametrize("far", [-0.02, -0.003, 0.003, 0.02])
def test_an_insertion_longer_or_shorter_than_stated_is_refused(cell, plan, far):
    off = pin.SE3(np.eye(3), np.array([0.0, 0.0, far]))
    words = said(cell, with_way(cell, plan, off, pin.SE3.Identity()))
    length = (insertion(cell).length + far) * 1000
    assert f"is {length:.1f} mm long instead of 65.0 mm" in words


@pytest.mark.parametrize("clearance", [0.0011, 0.0013, 0.0016, 0.002, 0.004])
def test_two_parts_keep_the_clearance_that_the_recipe_states(cell, plan, clearance):
    words = said(with_insertion(cell, clearance=clearance), plan)
    assert f"within the safety margin of {clearance * 1000:.1f} mm" in words
    assert "part-1 and bolt" in words or "bolt and part-1" in words


@pytest.mark.parametrize("clearance", [0.00005, 0.0003, 0.0007])
def test_less_clearance_than_there_is_holds(cell, plan, clearance):
    assert said(with_insertion(cell, clearance=clearance), plan) == ""


@pytest.mark.parametrize(
    "changes",
    [
        {"along": (0.0, 0.0, 1.0)},
        {"along": (1.0, 0.0, 0.0)},
        {"along": (0.0, float(np.sin(0.03)), -float(np.cos(0.03)))},
        {"length": 0.05},
        {"length": 0.075},
        {"position": (0.0, 0.0, -0.0133)},
        {"position": (0.001, 0.0, -0.014)},
        {"rpy": (0.0, 0.05, 0.0)},
        {"rpy": (0.0, 0.0, 0.2)},
    ],
)
def test_what_another_recipe_asks_for_is_not_what_the_plan_does(cell, plan, changes):
    assert said(with_insertion(cell, **changes), plan) != ""


def test_either_end_of_the_spacer_may_be_up_and_any_of_its_six_sides_in_front(cell, plan):
    for rpy in ((0.0, 0.0, np.pi / 3), (np.pi, 0.0, 0.0), (0.0, np.pi, np.pi / 3)):
        assert said(with_insertion(cell, rpy=rpy), plan) == ""


@pytest.mark.parametrize("gap", [0.0005, 0.002, 0.004])
def test_nothing_but_the_base_may_be_nearer_than_the_margin(cell, plan, gap):
    (bolt,) = plan.obstacles
    side = 0.02
    x = rest_pose(cell, bolt).translation[0] + 0.0174 + gap + side / 2
    middle = (x, *rest_pose(cell, bolt).translation[1:])
    beside = Obstacle(pose_from_rpy(middle), np.full(3, side))
    words = said(cell, replace(plan, obstacles=(bolt, beside)))
    assert "within the safety margin of 5.0 mm" in words and "seen-2" in words


def test_only_the_last_motion_brings_the_two_parts_together(cell, plan):
    """On all other legs they keep the whole margin: here the free leg ends too near the tip."""
    near = with_insertion(cell, length=0.062)
    off = pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.003]))
    words = said(near, with_way(cell, plan, off, pin.SE3.Identity()))
    assert "return" in words and "within the safety margin of 5.0 mm" in words


def test_an_assembled_part_is_in_the_way_by_its_own_shape_from_then_on(cell, plan):
    (bolt,), (arm_plan,) = plan.obstacles, plan.arms
    scene = scene_after(cell, plan)
    assert [box.part for box in scene.obstacles] == ["bolt", "spacer"]
    spacer = scene.obstacles[1]
    T_put = put_at(cell, tree_of(cell), plan, arm_plan)
    falls = T_put.translation[2] - rest_pose(cell, spacer).translation[2]
    assert 0.0 < falls < 0.0013, "down to the head of the bolt"
    off = rest_pose(cell, bolt).actInv(rest_pose(cell, spacer)).translation
    np.testing.assert_allclose(off, [0.0, 0.0, -0.015], atol=5e-4)
    unsure = kept_box(cell, (bolt,), plan.detections[0], T_put, is_sure=False)
    assert (unsure.part, unsure.T_world_put) == ("", None)


def test_a_base_is_put_where_the_cell_says_how_it_stands(cell):
    bolt = replace(standing_spacer(cell), part="bolt")
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.0135), (0.0, np.pi / 2, 0.0))
    result = plan_pick(cell, (replace(bolt, T_world_part=T),), "scan", strategy="right")
    assert result.proof is not None and result.proof.holds, str(result.verdict)
    assert [box.part for box in scene_after(cell, result.plan).obstacles] == ["bolt"]
    (right, left) = cell.arms
    place = right.part_places[0]
    higher = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.003]))

    def elsewhere(T_world_part, **changes):
        there = replace(place, T_world_part=T_world_part, **changes)
        arm = replace(right, part_places=(there,))
        return said(replace(cell, arms=(arm, left)), result.plan)

    assert "from its target pose" in elsewhere(higher * place.T_world_part)
    chain, q = chain_of(cell, right), result.plan.arms[0].leg("place").q[-1]
    of_hand = replace(right, part_places=(), Ts_world_place=(chain.pose(np.asarray(q)),))
    words = said(replace(cell, arms=(of_hand, left)), result.plan)
    assert "the hand opens where the arm has no place" in words
    unseen = replace(result.plan.detections[0], roll_known=False)
    words = said(cell, replace(result.plan, detections=(unseen,)))
    assert "a part of unknown roll cannot be assembled" in words
    lower = tuple(
        replace(one, T_world_fixture=pose_from_rpy((0, 0, -0.01)) * one.T_world_fixture)
        for one in cell.fixtures
    )
    assert "above its support" in said(replace(cell, fixtures=lower), result.plan)

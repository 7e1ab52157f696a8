"""What the cell forbids, and what the scan shows, is asked again of a plan that was good."""

from dataclasses import replace

import numpy as np
import pytest
from bending import with_grasps, with_leg

from workbench.app.picking.proving import prove
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import Guarantee, Strategy
from workbench.model.scan import Obstacle, Scene
from workbench.proof.claims.prove import prove as prove_in
from workbench.proof.claims.scene import scene_bodies
from workbench.proof.claims.table import PairTable, Situation
from workbench.proof.engine import search
from workbench.proof.engine.robot import tree_of


def problems(proof) -> str:
    assert not proof.holds
    return "; ".join(map(str, proof.violations))


def of_cell(cell, plan):
    """The plan as if it had been made for another cell."""
    return replace(plan, cell_digest=cell.digest)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"is_enabled": False}, "is disabled"),
        ({"arms": ("third",)}, "is for arm third"),
        ({"tool": "other tool"}, "is for tool other tool"),
        ({"opening": 0.038}, "fingers at"),
        ({"approach_length": 0.04}, "does not go in the direction of the grasp"),
        ({"retreat": np.array([0.0, 0.0, -1.0])}, "does not go in the direction of the grasp"),
    ],
)
def test_grasps_are_asked_again(cell, result, change, says):
    other = with_grasps(cell, lambda grasp: replace(grasp, **change))
    assert says in problems(prove(other, of_cell(other, result.plan)))


def test_the_strategy_is_what_the_plan_does(cell, result):
    alone = replace(result.plan, strategy=Strategy.single("left"))
    assert "strategy left arm only is not what the plan does" in problems(prove(cell, alone))
    at_once = replace(result.plan, guarantee=Guarantee.SYNCHRONISED)
    assert "move one after the other" in problems(prove(cell, at_once))


def test_a_part_that_the_plan_leaves_out_is_named(cell, result, detections):
    """The scan is an argument: the plan's word does not count against it."""
    plan, more = result.plan, pose_from_rpy(detections[0].T_world_part.translation + [0, 0.3, 0])
    known = (*plan.detections, replace(detections[0], T_world_part=more))
    proof = prove_in(cell, Scene(plan.scan_digest, known), plan)
    assert "leaves out part-3 of the scan" in problems(proof)
    moved = replace(known[0], T_world_part=more)
    proof = prove_in(cell, Scene(plan.scan_digest, (moved, *plan.detections[1:])), plan)
    assert "is not in the scan" in problems(proof)
    tower = Obstacle(more, np.full(3, 0.01))
    proof = prove_in(cell, Scene(plan.scan_digest, plan.detections, (tower,)), plan)
    assert "leaves out obstacle seen-1" in problems(proof)
    assert "another scan" in problems(prove_in(cell, Scene("other", plan.detections), plan))


@pytest.mark.parametrize(("depth", "is_wrong"), [(0.0005, False), (0.0025, True)])
def test_a_part_that_is_sunk_into_the_floor_has_a_wrong_pose(cell, result, depth, is_wrong):
    """The bin is raised instead of the parts lowered: hands still close where they did."""
    raised = pose_from_rpy([0, 0, depth]) * cell.bin.T_world_bin
    sunk = replace(cell, bin=replace(cell.bin, T_world_bin=raised))
    says = "; ".join(map(str, prove(sunk, of_cell(sunk, result.plan)).violations))
    assert ("too deep in its support" in says) is is_wrong, says


def test_more_speed_and_acceleration_than_the_cell_allows(cell, result):
    arm = result.plan.arms[0].arm
    leg = result.plan.arm(arm).leg("approach")
    for share, says in ((0.2, "faster than the joints may turn"), (0.95, "more acceleration")):
        bent = with_leg(result.plan, arm, "approach", t=leg.t * share)
        assert says in problems(prove(cell, bent))
    slower = with_leg(result.plan, arm, "approach", t=leg.t * 2)
    assert prove(cell, slower).holds


def test_a_crooked_approach_is_refused(cell, result):
    arm = result.plan.arms[0].arm
    leg = result.plan.arm(arm).leg("approach")
    q = np.array(leg.q)
    q[2] += np.deg2rad(0.5) * np.array([1, -1, 1, 1, 0, 0, 0])
    bent = with_leg(result.plan, arm, "approach", q=np.deg2rad(np.round(np.rad2deg(q), 2)))
    assert "is not straight" in problems(prove(cell, bent))


def test_a_lift_that_is_straight_at_its_ends_alone_is_refused(cell, result):
    """Joints that move in proportion from its first waypoint to its last lead the hand aside."""
    said, name = [], "extract"
    for one in result.plan.arms:
        leg = one.leg(name)
        bent = with_leg(result.plan, one.arm, name, q=leg.q[[0, -1]], t=leg.t[[0, -1]] * 3)
        said += map(str, prove(cell, bent).violations)
    assert any("is not straight" in text for text in said), said


def test_fingers_that_would_open_into_something_are_refused(cell, result):
    """A post beside the place, between where the closed and the open fingers are."""
    plan = result.plan
    one = plan.arms[0]
    arm = cell.arm(one.arm)
    T_tcp = arm.Ts_world_place[0]
    grip, wide = one.leg("place").opening / 2, one.leg("home").opening / 2
    hits = 0
    for axis in np.vstack([np.eye(3)[:2], -np.eye(3)[:2]]):
        at = T_tcp.act(axis * ((grip + wide) / 2 + 0.012))
        post = Obstacle(pose_from_rpy(at), np.full(3, 0.002))
        with_post = replace(plan, obstacles=(post,))
        hits += not prove(cell, with_post).holds
    assert hits >= 1


def test_parts_are_the_same_in_whatever_order_they_are_known(cell, result):
    """A hand holds the part that the plan means, not the one at its number in the scan."""
    plan = result.plan
    proof = prove_in(cell, Scene(plan.scan_digest, plan.detections[::-1]), plan)
    assert proof.holds
    assert proof.clearance == prove(cell, plan).clearance


def test_a_search_that_gives_up_is_no_proof(cell, result, monkeypatch):
    monkeypatch.setattr(search, "MOST_HALVES", 5)
    assert "for too long to be proven" in problems(prove(cell, result.plan))


@pytest.mark.parametrize(("near_arm", "kept"), [("", "margin"), ("right", "near_margin")])
def test_a_held_part_keeps_its_distance_to_the_arm_that_holds_it(cell, result, near_arm, kept):
    """As to anything else; links of one arm among themselves stand closer by design."""
    tree = tree_of(cell)
    bodies = scene_bodies(cell, tree, result.plan.scene)
    table = PairTable(cell, tree, bodies)
    one = result.plan.arm("right")
    moves = np.zeros(tree.model.nq, bool)
    moves[tree.columns["right"][:7]] = True
    joints = np.array([body.joint for body in bodies])
    held = np.array([body.part == one.detection for body in bodies])
    joints[held] = tree.flange(cell.arm("right"))[0]
    pairs = table.pairs(Situation(moves, {one.detection: "right"}, near_arm=near_arm), joints)
    a, b = table.first[pairs.rows], table.second[pairs.rows]
    own = np.array([body.kind == "link" and body.arm == "right" for body in bodies])
    with_part, alone = (held[a] & own[b]) | (held[b] & own[a]), own[a] & own[b]
    assert with_part.any() and alone.any()
    assert set(pairs.margins[with_part]) == {getattr(cell.policy, kept)}
    assert set(pairs.margins[alone]) == {cell.policy.self_margin}

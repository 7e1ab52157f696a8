"""Places that say how the part shall lie: the grasp decides how the hand stands there."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from bending import with_nests

from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.stations import put_down
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Candidate, Pick, Reason, Stage
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import PartPlace
from workbench.model.scan import Detection
from workbench.planning.collision.world import World
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve


def lying(cell, plan):
    """Where the plan puts each part, and where the first place of the arm wants it."""
    keeps = replace(cell, arms=tuple(replace(arm, keeps_parts=True) for arm in cell.arms))
    return [
        (found.T_world_part, cell.arm(one.arm).part_places[0].T_world_part)
        for found, one in zip(put_down(keeps, plan), plan.arms, strict=True)
    ]


def apart(T: pin.SE3, U: pin.SE3) -> tuple[float, float]:
    off = T.actInv(U)
    return float(np.linalg.norm(off.translation)), float(np.linalg.norm(pin.log3(off.rotation)))


@pytest.fixture(scope="module")
def nests(cell):
    return with_nests(cell, part="keyed_cylinder")


@pytest.fixture(scope="module")
def standing(nests, detections):
    return plan_pick(nests, detections, "scan", seed=0)


def test_parts_that_lie_are_put_upright_with_the_key_to_the_front(nests, standing):
    assert standing.proof.holds
    for T, wanted in lying(nests, standing.plan):
        far, turn = apart(T, wanted)
        assert far < 0.0005 and turn < np.deg2rad(0.1)


@pytest.mark.parametrize("approach", [(0.8, 0.0, -0.6), (1.0, 0.0, 0.0)])
def test_a_part_comes_to_its_place_from_where_that_has_it_come(nests, detections, approach):
    asks = with_nests(nests, part="keyed_cylinder", approach=approach)
    result = plan_pick(asks, detections, "scan", seed=0)
    assert result.proof.holds
    kinematics = Kinematics(asks)
    for one in result.plan.arms:
        q = one.leg("place").q
        start, end = (kinematics.tcp_pose(asks.arm(one.arm), q[k]).translation for k in (0, -1))
        assert np.allclose(end - start, 0.05 * np.array(approach), atol=0.001)
    for T, wanted in lying(asks, result.plan):
        assert apart(T, wanted)[0] < 0.0005


def test_grasps_that_allow_no_such_place_are_refused_with_a_number(standing):
    refused = [c.verdict for c in standing.candidates if c.verdict.reason is Reason.NO_PLACE]
    assert len(refused) >= 4
    for verdict in refused:
        assert verdict.stage is Stage.PLACE and verdict.note.args["count"] == 1
        assert verdict.distance is not None and verdict.q is not None


def test_a_part_that_may_be_turned_can_be_put_where_it_else_cannot(cell, detections):
    """On its collar, the key to a side for which the right arm would have to reach around it."""
    turned = pose_from_rpy((0.33, -0.33, 0.13), np.deg2rad([180.0, 0.0, 30.0]))
    counts = []
    for free in (0.0, np.deg2rad(60.0)):
        asks = with_nests(cell, T_world_part=turned, free_rotation=free)
        asks = replace(asks, arms=(asks.arm("right"),))
        counts.append(Counter(c.verdict.reason for c in judge(asks, detections)))
    assert counts[0][Reason.OK] == 0 < counts[0][Reason.NO_PLACE]
    assert counts[1][Reason.OK] > 0


def test_a_place_for_another_kind_is_no_place(cell, detections):
    result = plan_pick(with_nests(cell, part="bracket"), detections, "scan")
    assert result.plan is None and result.verdict.reason is Reason.NO_PLACE
    assert result.verdict.note == VerdictNote.NO_PLACE_FOR_PART(count=1, part="keyed_cylinder")


def test_a_part_in_a_wall_is_refused_whatever_the_arm_does(cell, detections):
    wall = cell.bin.T_world_bin * pose_from_rpy((0.1015, 0.0, 0.06))
    result = plan_pick(with_nests(cell, T_world_part=wall), detections, "scan")
    refused = [c.verdict for c in result.candidates if c.verdict.reason is Reason.NO_PLACE]
    assert result.plan is None and refused
    assert all(verdict.note.args["blocked"] == 1 for verdict in refused)
    assert {verdict.pair[1] for verdict in refused} == {"bin_wall_front"}


def test_places_of_the_hand_take_what_places_of_parts_do_not(cell, detections):
    far = with_nests(cell, T_world_part=pose_from_rpy((2.0, 0.0, 0.5)))
    both = replace(
        far,
        arms=tuple(
            replace(arm, Ts_world_place=cell.arm(arm.name).Ts_world_place) for arm in far.arms
        ),
    )
    result = plan_pick(both, detections, "scan", seed=0)
    assert result.proof.holds and len(result.plan.arms) == 2


@pytest.mark.parametrize(("free", "expected"), [(0.0, {Reason.ROLL_UNKNOWN}), (np.pi, set())])
def test_a_part_of_unknown_roll_needs_a_place_where_that_does_not_matter(
    cell, detections, free, expected
):
    unseen = (replace(detections[0], roll_known=False),)
    found = judge(with_nests(cell, free_rotation=free), unseen)
    late = {c.verdict.reason for c in found if c.verdict.stage is Stage.PLACE}
    assert late - {Reason.OK, Reason.NO_PLACE} == expected


def test_of_a_round_part_every_turn_is_as_good():
    cell = read_cell("tx2_90")
    (arm,) = cell.arms
    hand = arm.Ts_world_place[0]
    # As the hand at that place holds it by its top, but turned by 17 degrees about its axis.
    top = next(g for g in cell.part("puck").grasps if g.name == "top")
    turn = pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, np.deg2rad(17.0)))
    place = PartPlace(hand * top.T_part_tcp.inverse() * turn, "puck")
    round_ = replace(cell, arms=(replace(arm, Ts_world_place=(), part_places=(place,)),))
    height = float(np.ptp(cell.parts[0].mesh.points[:, 2])) / 2
    T = cell.bin.T_world_bin * pose_from_rpy((0.05, -0.05, height + 0.0005), (0.0, 0.0, 0.3))
    result = plan_pick(round_, (Detection("puck", T),), "scan")
    assert result.proof.holds
    ((T_put, wanted),) = lying(round_, result.plan)
    off = wanted.actInv(T_put)
    assert np.linalg.norm(off.translation) < 0.0005
    assert abs(off.rotation[2, 2]) > np.cos(np.deg2rad(0.1))


def test_places_are_not_tried_when_the_time_is_over(nests, detections):
    world = World(nests, detections)
    working = next(c for c in judge(nests, detections) if c.verdict.is_ok)
    candidate = next(c for c in propose(world) if same(c, working))
    assert isinstance(resolve(world, candidate, seed=0), Pick)
    world.deadline = -math.inf
    assert resolve(world, candidate, seed=0).reason is Reason.OUT_OF_TIME


def same(one: Candidate, other: Candidate) -> bool:
    return (one.detection, one.grasp.name, one.arm) == (
        other.detection,
        other.grasp.name,
        other.arm,
    )

"""What a candidate can be looked at in."""

from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin
import pytest

from workbench.gui.drawing.poses import PoseFinder
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.planning.collision.bodies import coal_shape
from workbench.planning.collision.world import World


@pytest.fixture(scope="module")
def finder() -> PoseFinder:
    return PoseFinder()


def test_a_good_candidate_shows_its_way_and_its_spare_freedom(finder, states, result):
    good = next(one for one in result.candidates if one.verdict.is_ok)
    poses = finder.poses(states.planned, good)
    assert [pose.label for pose in poses[:4]] == ["pre-grasp", "grasp", "lifted", "place"]
    elbows = [pose for pose in poses if "elbow" in str(pose.label)]
    assert len(elbows) > 5
    assert any(
        np.allclose(pose.q, poses[1].q) and str(pose.note).startswith("clear") for pose in elbows
    )
    assert all((str(pose.note).startswith("clear")) == (not pose.meets) for pose in poses)


def test_a_refused_candidate_shows_where_it_failed_and_what_meets(finder, states, result):
    refused = [one for one in result.candidates if one.verdict.q is not None]
    for one in refused:
        (pose,) = finder.poses(states.planned, one)
        assert np.array_equal(pose.q, one.verdict.q)
        assert pose.note == one.verdict.message
        if one.verdict.pair is not None:
            assert len(pose.meets) >= 2


def nearest(meets):
    """[m] Between the first body and the nearest of the others; below 0: they are in each other."""
    (shape, T), *others = [
        (coal_shape(shape), coal.Transform3s(T.rotation, T.translation)) for shape, T in meets
    ]
    ask, answer = coal.DistanceRequest(), coal.DistanceResult
    return min(coal.distance(shape, T, one, T_one, ask, answer()) for one, T_one in others)


def test_a_hand_that_was_refused_without_an_arm_shows_what_it_meets(finder, states, result):
    fell = [
        one
        for one in result.candidates
        if one.verdict.reason is Reason.TOOL_COLLISION and one.verdict.pair is not None
    ]
    assert fell
    for one in fell:
        (pose,) = finder.poses(states.planned, one)
        assert pose.q is None and len(pose.meets) >= 2
        assert nearest(pose.meets) == pytest.approx(one.verdict.distance, abs=1e-6)
        # As it stood there: its fingers as far apart as the verdict says.
        assert one.verdict.note.args["opening"] == pytest.approx(pose.opening)
        tool = pose.T_world_tcp
        assert np.allclose(tool.homogeneous, one.T_world_tcp.homogeneous)


def test_what_has_no_bodies_to_show_has_no_pose(finder, states, result):
    one = replace(result.candidates[0], verdict=Verdict(Reason.DISABLED, Stage.PROPOSE))
    assert finder.poses(states.planned, one) == ()


def test_a_part_that_stands_in_something_at_a_place_is_shown_there(finder, states, result):
    good = next(one for one in result.candidates if one.verdict.is_ok)
    cell = states.planned.cell
    arm = cell.arm(good.arm)
    # A place in the floor of the bin.
    low = pin.SE3(arm.Ts_world_place[0].rotation, cell.bin.T_world_bin.translation)
    other = replace(arm, Ts_world_place=(low,))
    arms = tuple(other if one is arm else one for one in cell.arms)
    state = replace(states.planned, cell=replace(cell, arms=arms))
    world = World(state.cell, state.detections)
    T_put = low * good.T_world_tcp.actInv(state.detections[good.detection].T_world_part)
    label = world.part_ways.standing_in(good.detection, T_put, world.policy.margin)
    part = f"part-{good.detection + 1}"
    refused = replace(good, verdict=Verdict(Reason.NO_PLACE, Stage.PLACE, (part, label)))
    (pose,) = finder.poses(state, refused)
    where = [T.translation for _, T in pose.meets]
    assert len(where) >= 2
    assert any(np.linalg.norm(p - T_put.translation) < 0.05 for p in where)
    assert np.linalg.norm(pose.T_world_tcp.translation - low.translation) < 0.02


def test_a_part_that_is_held_down_is_shown_where_its_lift_ends(finder, states, result):
    good = next(one for one in result.candidates if one.verdict.is_ok)
    found = states.planned.detections
    lying = found[good.detection].T_world_part
    # Something lies right above it.
    above = pin.SE3(lying.rotation, lying.translation + np.array([0.0, 0.0, 0.06]))
    other = 1 - good.detection
    lies = [replace(one, T_world_part=above) if k == other else one for k, one in enumerate(found)]
    state = replace(states.planned, detections=tuple(lies))
    pair = (f"part-{good.detection + 1}", f"part-{other + 1}")
    refused = replace(good, verdict=Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, pair))
    (pose,) = finder.poses(state, refused)
    lifted = pose.T_world_tcp.translation - good.T_world_tcp.translation
    assert 0.005 < lifted[2] < 0.06 and np.linalg.norm(lifted[:2]) < 0.02
    assert nearest(pose.meets) < 0.03

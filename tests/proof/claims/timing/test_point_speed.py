"""How fast points of arm, tool and part get: bounded, checked, and held against what is ridden."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from bending import with_leg
from paces import LINKS, resampled

from workbench.app.picking.pipeline import plan_pick
from workbench.devices.streamed_way import timed_way
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import greatest_speed
from workbench.model.plan import Guarantee, Step
from workbench.planning.collision.world import World
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.synchronized_motion import time_in_step
from workbench.plugins.robot_link import spoken_to_by
from workbench.proof.claims.prove import prove
from workbench.proof.claims.timing.point_speed import speed_claims
from workbench.proof.engine.robot import tree_of

STATES = 60
"""Of each leg."""


def limited(cell, **limits):
    return replace(cell, policy=replace(cell.policy, **limits))


@pytest.fixture(scope="module", params=LINKS)
def planned(request, cell, detections):
    """A cell of each kind of link in manual mode, and what planning brings."""
    one = limited(spoken_to_by(cell, LINKS[request.param]), manual_speed=True)
    return one, plan_pick(one, detections, "scan", strategy="right", seed=0)


def ridden(cell, plan, arm_plan, leg) -> Iterator[tuple[float, float]]:
    """Speeds [m/s] of the TCP and of the fastest corner of link, tool and part, by Pinocchio."""
    robot, arm = Kinematics(cell), cell.arm(arm_plan.arm)
    points: dict[int, list[np.ndarray]] = {}

    def add(joint, T, solid):
        corners = np.asarray(solid.shape.points)
        T = T * solid.T_owner_shape
        points.setdefault(joint, []).append(corners @ T.rotation.T + T.translation)

    moving = set(robot.columns[arm.name].tolist())
    joints = {j for j in range(1, robot.model.njoints) if robot.model.joints[j].idx_q in moving}
    for link in cell.robot.links:
        joint, T = robot.frames[link.name]
        for solid in link.collision:
            if joint in joints and solid.shape.kind == "mesh":
                add(joint, T, solid)
    hand, T_hand_flange = robot.frames[arm.flange]
    T_hand_tcp = T_hand_flange * arm.tool.T_flange_tcp
    for solid in arm.tool.body:
        if solid.shape.kind == "mesh":
            add(hand, T_hand_flange, solid)
    if leg.holding:
        part = cell.part(plan.detections[arm_plan.detection].part)
        T = T_hand_tcp * arm_plan.T_tcp_part
        points.setdefault(hand, []).append(part.mesh.points @ T.rotation.T + T.translation)
    # Where the controller stops, its corners are sharp.
    sharp = replace(cell, policy=replace(cell.policy, zone=cell.zone))
    way = timed_way(sharp, plan, arm, leg)
    q, v = robot.q_home.copy(), np.zeros(robot.model.nv)
    for t in np.linspace(0.0, way.seconds, STATES):
        s, speed = way.when(t)
        configuration, slope, _ = way.at(s)
        q[robot.columns[arm.name]], v[robot.columns[arm.name]] = configuration, slope * speed
        pin.forwardKinematics(robot.model, robot.data, q, v)
        fast = [
            np.linalg.norm(twist.linear + np.cross(twist.angular, np.vstack(some)), axis=1).max()
            for joint, some in points.items()
            for twist in [robot.data.v[joint]]
        ]
        at_hand = robot.data.v[hand]
        tcp = at_hand.linear + np.cross(at_hand.angular, T_hand_tcp.translation)
        yield float(np.linalg.norm(tcp)), float(max(fast))


def test_a_cell_without_limits_has_the_plan_and_the_proof_that_it_had(cell, result):
    assert result.proof.holds and result.proof.speeds == ()
    assert greatest_speed(result.proof.speeds) is None
    same = limited(cell, manual_speed=False)
    assert (same.digest, prove(cell, result.plan.scene, result.plan).digest) == (
        cell.digest,
        result.proof.digest,
    )


def test_a_plan_in_manual_mode_holds_and_no_point_exceeds_its_bound(planned):
    cell, result = planned
    assert result.proof.holds, result.proof.violations
    for bound in result.proof.speeds:
        arm_plan = result.plan.arm(bound.arm)
        found = np.array(list(ridden(cell, result.plan, arm_plan, arm_plan.leg(bound.leg))))
        assert found[:, 0].max() <= bound.tcp and found[:, 1].max() <= bound.point
        assert bound.tcp <= bound.point <= 0.25
    assert len(result.proof.speeds) == len(result.plan.arms[0].legs)


def test_the_bound_of_a_whole_plan_is_at_most_a_tenth_above_what_is_ridden(planned):
    cell, result = planned
    arm_plan = result.plan.arms[0]
    fastest = max(
        point for leg in arm_plan.legs for _, point in ridden(cell, result.plan, arm_plan, leg)
    )
    assert fastest <= greatest_speed(result.proof.speeds).point <= 1.1 * fastest


def with_times(plan, share, which=lambda leg: True):
    arms = tuple(
        replace(
            arm,
            legs=tuple(replace(leg, t=leg.t * share) if which(leg) else leg for leg in arm.legs),
        )
        for arm in plan.arms
    )
    return replace(plan, arms=arms)


@pytest.mark.parametrize("share", [0.94, 0.8, 0.5])
@pytest.mark.parametrize("name", ["reach", "extract", "home"])
def test_a_leg_made_faster_by_hand_is_refused(planned, share, name):
    cell, result = planned
    bent = with_times(result.plan, share, lambda leg: leg.name == name)
    proof = prove(cell, bent.scene, bent)
    assert not proof.holds and {v.leg for v in proof.violations} == {name}


def test_it_is_refused_with_the_limit_in_words(cell, detections):
    slow = limited(cell, tcp_speed=0.1)
    plan = plan_pick(slow, detections, "scan", strategy="right", seed=0).plan
    bent = with_times(plan, 0.9, lambda leg: leg.name == "reach")
    violation = prove(slow, bent.scene, bent).violations[0]
    assert violation.problem.text is ProofText.POINT_TOO_FAST
    assert "faster than the cell allows: 100 mm/s at most" in str(violation)


def test_slower_plans_hold_too(planned):
    cell, result = planned
    slower = with_times(result.plan, 1.7)
    assert prove(cell, slower.scene, slower).holds


def test_a_plan_of_another_cell_without_limits_does_not_hold_here(cell, result):
    slow = limited(cell, point_speed=0.5)
    plan = replace(result.plan, cell_digest=slow.digest)
    texts = {v.problem.text for v in prove(slow, plan.scene, plan).violations}
    assert texts == {ProofText.POINT_TOO_FAST}


def test_only_legs_with_the_part_in_hand_are_slower(cell, detections, result):
    slow = limited(cell, held_speed=0.1)
    found = plan_pick(slow, detections, "scan", seed=0)
    assert found.proof.holds
    for bound in found.proof.speeds:
        arm_plan = found.plan.arm(bound.arm)
        leg = arm_plan.leg(bound.leg)
        assert (bound.point <= 0.1) == leg.holding
        if not leg.holding and np.array_equal(leg.q, result.plan.arm(bound.arm).leg(leg.name).q):
            assert np.array_equal(leg.t, result.plan.arm(bound.arm).leg(leg.name).t)


def test_two_arms_in_step_keep_the_limit_each(cell, detections):
    slow = limited(cell, point_speed=0.2)
    plan = plan_pick(slow, detections, "scan", strategy="coordinated", seed=0).plan
    paths = [resampled(np.asarray(arm.leg("home").q), 6) for arm in plan.arms]
    legs = tuple(arm.leg("home") for arm in plan.arms)
    legs = time_in_step(World(slow, detections), plan.arms, legs, np.hstack(paths))
    for arm, leg in zip(plan.arms, legs, strict=True):
        plan = with_leg(plan, arm.arm, "home", q=leg.q, t=leg.t)
    both = Step(tuple((arm.arm, "home") for arm in plan.arms))
    plan = replace(plan, guarantee=Guarantee.SYNCHRONISED, sequence=(both,))
    violations, bounds = speed_claims(slow, tree_of(slow), plan)
    assert violations == () and {bound.arm for bound in bounds} == {"left", "right"}
    assert max(bound.point for bound in bounds) == pytest.approx(0.2)
    assert speed_claims(slow, tree_of(slow), with_times(plan, 0.94))[0]


def test_a_part_whose_roll_is_not_known_is_bounded_at_every_turn(cell, detections):
    slow = limited(cell, held_speed=0.15)
    rolled = tuple(replace(found, roll_known=False) for found in detections)
    found = plan_pick(slow, rolled, "scan", strategy="right", seed=0)
    assert found.plan is not None and found.proof.holds, found.verdict

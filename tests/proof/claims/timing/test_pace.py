"""Times that no robot can keep, though no joint is too fast on average between two waypoints."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from bending import with_leg
from judge_times import at_rest_between, soonest
from paces import LINKS, resampled, scaled

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import Guarantee, Step
from workbench.planning.kinematics.execution import compute_times
from workbench.plugins.robot_link import spoken_to_by
from workbench.proof.claims.timing.pace import pace_violations
from workbench.proof.claims.timing.point_speed import speed_claims
from workbench.proof.engine.robot import tree_of


@pytest.fixture(scope="module", params=LINKS)
def planned(request, cell, detections):
    """A cell of each kind of link, and a plan for it."""
    one = spoken_to_by(cell, LINKS[request.param])
    assert one.controller.motion.corners == request.param
    return one, plan_pick(one, detections, "scan", strategy="right", seed=0).plan


def limits(cell, arm: str):
    """The largest speeds and accelerations (n,) of an arm's joints, by the policy."""
    joints = cell.arm(arm).joints
    speeds = cell.robot.limits(joints)[2] * cell.policy.speed
    return speeds, np.asarray(cell.arm(arm).acceleration)


def looks_fine(cell, arm: str, leg) -> bool:
    """Whether mean speeds between waypoints, and their changes, are within limits: the old rule."""
    speeds, pushes = limits(cell, arm)
    allowed = 1.001 / (1 - cell.policy.zone)
    means = np.diff(leg.q, axis=0) / np.diff(leg.t)[:, None]
    rests = [np.zeros(len(speeds)), *means, np.zeros(len(speeds))]
    spans = np.concatenate([[0.0], np.diff(leg.t), [0.0]])
    changes = [
        np.abs(after - before) / (one + other)
        for (before, after), (one, other) in zip(pairwise(rests), pairwise(spans), strict=True)
    ]
    return bool(
        (np.abs(means) <= speeds * allowed).all() and (np.array(changes) <= pushes * allowed).all()
    )


def soon(cell, arm: str, leg) -> np.ndarray:
    """By how much the judge says that each way would have to take longer; 1: just as soon."""
    speeds, pushes = limits(cell, arm)
    if cell.zone:
        return soonest(np.asarray(leg.q), cell.zone, speeds, pushes) / np.diff(leg.t)
    ways = np.diff(leg.q, axis=0)
    return np.array([at_rest_between(way, speeds, pushes) for way in ways]) / np.diff(leg.t)


def test_a_plan_is_as_quick_as_limits_allow_and_holds_at_any_slower_pace(planned):
    cell, plan = planned
    for share in (1.0, 1.003, 1.3, 4.0, 60.0):
        assert list(pace_violations(cell, scaled(plan, share))) == []
    assert prove(cell, plan).holds


@pytest.mark.parametrize("share", [0.98, 0.9])
def test_a_plan_whose_mean_speeds_are_fine_and_whose_peaks_are_not_is_refused(planned, share):
    cell, plan = planned
    bent = scaled(plan, share)
    (one,) = bent.arms
    assert all(looks_fine(cell, one.arm, leg) for leg in one.legs)
    assert all(soon(cell, one.arm, leg).max() > 1.005 for leg in one.legs), "the judge says so"
    proof = prove(cell, bent)
    assert {violation.leg for violation in proof.violations} == {leg.name for leg in one.legs}
    said = {str(violation.problem) for violation in proof.violations}
    assert said <= {
        "is faster than the joints may turn",
        "asks for more acceleration than the arm has",
    }


def test_one_way_that_is_too_quick_is_named(planned):
    """The others take as long as they did, or longer."""
    cell, plan = planned
    (one,), named = plan.arms, 0
    for name in ("reach", "return", "home"):
        leg = one.leg(name)
        for row in range(1, len(leg.t) - 2):
            steps = np.diff(leg.t) * 1.2
            steps[row] *= 0.9 / 1.2
            bent = with_leg(plan, one.arm, name, t=np.concatenate([[0.0], np.cumsum(steps)]))
            if not looks_fine(cell, one.arm, bent.arm(one.arm).leg(name)):
                continue
            (violation,) = pace_violations(cell, bent)
            assert (violation.leg, violation.waypoint) == (name, row)
            named += 1
    assert named > 3


def test_a_way_from_rest_to_rest_at_its_top_speed_on_average_is_refused(cell, detections):
    """Where a controller stops it has to get there first, and to brake."""
    one = spoken_to_by(cell, "abb-socket")
    plan = plan_pick(one, detections, "scan", strategy="right", seed=0).plan
    leg = plan.arm("right").leg("reach")
    speeds, _ = limits(one, "right")
    least = (np.abs(np.diff(leg.q, axis=0)) / speeds).max(axis=1)
    assert (least < np.diff(leg.t)).all()
    bent = with_leg(plan, "right", "reach", t=np.concatenate([[0.0], np.cumsum(least * 1.001)]))
    (violation,) = pace_violations(one, bent)
    assert violation.problem == ProofText.TOO_HARD()


def test_where_a_zone_cannot_be_done_there_is_time_for_a_stop(cell, result):
    """Beside a long way the corner of a short one is passed slowly: a stop takes less time."""
    (one, *_), speeds, pushes = result.plan.arms, *limits(cell, result.plan.arms[0].arm)
    way = np.full(len(speeds), np.deg2rad(0.3)), np.full(len(speeds), np.deg2rad(30.0))
    ways = np.array([way[0], way[1], way[0]])
    stops = np.array([at_rest_between(step, speeds, pushes) for step in ways]) * 1.001
    q = np.vstack([np.zeros(len(speeds)), np.cumsum(ways, axis=0)])
    t = np.concatenate([[0.0], np.cumsum(stops)])
    plan = with_leg(result.plan, one.arm, "home", q=q, t=t)
    assert soon(cell, one.arm, plan.arm(one.arm).leg("home")).max() > 1.2, "not by rounding it"
    assert list(pace_violations(cell, plan)) == []
    (violation,) = pace_violations(spoken_to_by(cell, "abb-egm"), plan)
    assert (violation.arm, violation.leg) == (one.arm, "home")


def test_arms_in_step_are_one_motion(cell, result):
    """Each arm alone could be where it has to be, but for the clock that both have."""
    plan = replace(result.plan, guarantee=Guarantee.SYNCHRONISED)
    speeds, pushes = map(
        np.concatenate, zip(*(limits(cell, a.arm) for a in plan.arms), strict=True)
    )
    paths = [resampled(np.asarray(one.leg("home").q), 6) for one in plan.arms]
    times = compute_times(np.hstack(paths), speeds, pushes, cell.zone)
    for one, path in zip(plan.arms, paths, strict=True):
        plan = with_leg(plan, one.arm, "home", q=path, t=times)
    both = Step(tuple((one.arm, "home") for one in plan.arms))
    plan = replace(plan, sequence=(both,))
    assert list(pace_violations(cell, plan)) == []
    assert list(pace_violations(cell, scaled(plan, 3.0))) == []
    (violation,) = pace_violations(cell, scaled(plan, 0.98))
    assert violation.arm == plan.arms[0].arm


def test_points_keep_to_their_own_limit(cell, result):
    """In short what `test_point_speed` shows of each kind of link."""
    slow = replace(cell, policy=replace(cell.policy, point_speed=0.5))
    tree = tree_of(slow)
    violations, bounds = speed_claims(slow, tree, result.plan)
    assert {v.problem.text for v in violations} == {ProofText.POINT_TOO_FAST}
    assert max(bound.point for bound in bounds) == pytest.approx(0.5)
    assert speed_claims(slow, tree, scaled(result.plan, 5.0))[0] == ()
    assert speed_claims(cell, tree, result.plan) == ((), ())

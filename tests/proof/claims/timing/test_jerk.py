"""Plans for arms with limits of jerk: what was planned holds, a little more jerk does not."""

from dataclasses import replace

import numpy as np
import pytest
from bending import with_leg
from paces import LINKS, resampled, scaled

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import Guarantee, Step
from workbench.planning.kinematics.execution import compute_times
from workbench.plugins.robot_link import spoken_to_by
from workbench.proof.claims.timing.jerk import Limits, find_segment_over_jerk_limit
from workbench.proof.claims.timing.pace import pace_violations

TOO_JERKY = ProofText.TOO_JERKY()


def with_jerk(cell, ratio: float):
    """The cell with limits of jerk: so often the acceleration, in a second."""
    return replace(
        cell, arms=tuple(replace(arm, jerk=arm.acceleration * ratio) for arm in cell.arms)
    )


@pytest.fixture(scope="module", params=LINKS)
def planned(request, cell, detections):
    """A cell of each kind of link with limits of jerk, and a plan for it."""
    one = with_jerk(spoken_to_by(cell, LINKS[request.param]), 20.0)
    return one, plan_pick(one, detections, "scan", strategy="right", seed=0).plan


def timed_anew(cell, plan, share: float):
    """The plan with times for other limits of jerk: so often the cell's."""
    for one in plan.arms:
        arm = cell.arm(one.arm)
        velocity = cell.robot.limits(arm.joints)[2] * cell.policy.speed
        for leg in one.legs:
            t = compute_times(
                np.asarray(leg.q), velocity, arm.acceleration, cell.zone, arm.jerk * share
            )
            plan = with_leg(plan, one.arm, leg.name, t=t)
    return plan


def test_a_plan_holds_as_it_is_and_at_any_slower_pace(planned):
    cell, plan = planned
    for share in (1.0, 1.003, 1.3, 4.0, 60.0):
        assert list(pace_violations(cell, scaled(plan, share))) == []
    assert prove(cell, plan).holds


def test_one_percent_more_jerk_is_refused_on_every_leg(planned):
    cell, plan = planned
    assert list(pace_violations(cell, timed_anew(cell, plan, 1.0))) == []
    bent = timed_anew(cell, plan, 1.01)
    (one,) = bent.arms
    proof = prove(cell, bent)
    assert [violation.leg for violation in proof.violations] == [leg.name for leg in one.legs]
    assert {violation.problem for violation in proof.violations} == {TOO_JERKY}


def test_times_that_belong_to_jerk_one_percent_higher_everywhere_are_refused(planned):
    """All times divided by the cube root: the jerk is higher at each place, little else is."""
    cell, plan = planned
    refused = {violation.leg for violation in pace_violations(cell, scaled(plan, 1.01 ** (-1 / 3)))}
    assert refused == {leg.name for leg in plan.arms[0].legs}


def test_a_plan_for_arms_without_limits_is_refused(planned, cell, detections):
    one, plan = planned
    free = replace(one, arms=tuple(replace(arm, jerk=None) for arm in one.arms))
    quick = plan_pick(free, detections, "scan", strategy="right", seed=0).plan
    assert list(pace_violations(free, quick)) == []
    assert {violation.problem for violation in pace_violations(one, quick)} == {TOO_JERKY}
    assert quick.cycle_seconds < plan.cycle_seconds


def test_more_speed_and_more_acceleration_are_called_so(planned):
    cell, plan = planned
    said = {violation.problem for violation in pace_violations(cell, scaled(plan, 0.3))}
    assert said and said <= {
        ProofText.TOO_FAST(),
        ProofText.TOO_HARD(),
    }


def test_arms_in_step_are_one_motion_and_one_of_them_may_have_no_limit(cell, result):
    one = replace(cell.arms[0], jerk=cell.arms[0].acceleration * 10.0)
    cell = replace(cell, arms=(one, *cell.arms[1:]))
    plan = replace(result.plan, guarantee=Guarantee.SYNCHRONISED)
    arms = [cell.arm(each.arm) for each in plan.arms]
    speeds = np.concatenate([cell.robot.limits(arm.joints)[2] for arm in arms]) * cell.policy.speed
    pushes = np.concatenate([arm.acceleration for arm in arms])
    jerks = np.concatenate(
        [np.full(len(a.joints), np.inf) if a.jerk is None else a.jerk for a in arms]
    )
    paths = [resampled(np.asarray(each.leg("home").q), 6) for each in plan.arms]
    times = compute_times(np.hstack(paths), speeds, pushes, cell.zone, jerks)
    for each, path in zip(plan.arms, paths, strict=True):
        plan = with_leg(plan, each.arm, "home", q=path, t=times)
    plan = replace(plan, sequence=(Step(tuple((each.arm, "home") for each in plan.arms)),))
    assert list(pace_violations(cell, plan)) == []
    assert list(pace_violations(cell, scaled(plan, 0.99))) != []


@pytest.mark.parametrize("seed", range(40))
def test_ways_that_take_longer_by_different_shares_can_be(seed):
    """A motion is found where some ways take longer; where none is, no motion is claimed."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(rng.integers(1, 8), 4)) * 10 ** rng.uniform(-2, 0)
    limits = Limits(np.full(4, 1.5), np.full(4, 10.0), np.full(4, 10 ** rng.uniform(1, 4)))
    velocity, acceleration, jerk = limits
    path = np.vstack([np.zeros(4), np.cumsum(steps, axis=0)])
    times = np.diff(compute_times(path, velocity, acceleration, 0.2, jerk))
    assert find_segment_over_jerk_limit(steps, times, limits, 0.2) == -1
    assert find_segment_over_jerk_limit(steps, times * (1 - 1e-5), limits, 0.2) >= 0
    stops = np.diff(compute_times(path, velocity, acceleration, 0.0, jerk))
    assert (
        find_segment_over_jerk_limit(steps, stops * rng.uniform(1.0, 3.0, len(steps)), limits, 0.0)
        == -1
    )
    least = np.abs(steps).max(axis=1) / velocity[0] * 0.55
    assert find_segment_over_jerk_limit(steps, least, limits, 0.2) >= 0

"""Where everything is at a moment of a plan."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.gui.shared.playback import (
    Run,
    arm_path,
    follow_plan,
    interpolate,
    joint_values,
    moments,
    part_poses,
    sync_points,
    tcp_path,
    timeline,
)
from workbench.model.plan import Step
from workbench.planning.kinematics.robot import Kinematics


@pytest.fixture(scope="module")
def plan(result):
    return result.plan


@pytest.fixture(scope="module")
def runs(plan):
    return timeline(plan)


@pytest.fixture(scope="module")
def kinematics(cell):
    return Kinematics(cell)


def test_sync_points_stand_where_one_arm_waits_for_the_other(result):
    runs = timeline(result.plan)
    points = sync_points(runs)
    assert [point.name for point in points] == [f"S{k + 1}" for k in range(len(points))]
    for point in points:
        assert point.time == max(run.end for run in point.before)
        assert all(run.start == point.time for run in point.after)
        assert len({run.arm for run in (*point.before, *point.after)}) > 1
    together = {
        frozenset(arm for arm, _ in (*one.runs, *other.runs))
        for one, other in pairwise(result.plan.sequence)
    }
    assert points or all(len(arms) == 1 for arms in together)


def test_one_arm_alone_waits_for_nobody_and_no_plan_of_a_row_for_the_one_before(result):
    arm = result.plan.arms[0].arm
    first = tuple(run for run in timeline(result.plan) if run.arm == arm)
    assert sync_points(first) == ()
    shift = first[-1].end
    after = (Run("other", run.leg, run.start + shift, run.end + shift, 1) for run in first)
    assert sync_points((*first, *after)) == ()


def test_the_timeline_ends_with_the_cycle(plan, runs):
    assert runs[0].start == 0.0
    assert max(run.end for run in runs) == pytest.approx(plan.cycle_seconds)


def test_steps_follow_each_other_without_a_gap(plan, runs):
    at, rest = 0.0, list(runs)
    for step in plan.sequence:
        some, rest = rest[: len(step.runs)], rest[len(step.runs) :]
        assert [run.start for run in some] == pytest.approx([at] * len(step.runs))
        at = max(run.end for run in some)
    assert not rest


def test_legs_of_one_step_run_at_the_same_time(plan):
    right, left = (arm.arm for arm in plan.arms)
    both = replace(plan, sequence=(Step(((right, "reach"), (left, "reach"))), *plan.sequence[1:2]))
    first, second, third = timeline(both)
    assert first.start == second.start == 0.0
    assert third.start == max(first.end, second.end)


def test_every_waypoint_is_passed_at_its_time(cell, runs):
    for run in runs:
        for q, t in zip(run.leg.q[:-1], run.leg.t[:-1], strict=True):
            now = moments(cell, runs, run.start + t)[run.arm]
            np.testing.assert_allclose(now.q, q, atol=1e-9)
            assert now.leg is run.leg


def test_between_two_waypoints_joints_move_in_proportion_to_the_time(runs):
    leg = runs[0].leg
    halfway = interpolate(leg.q, leg.t, (leg.t[1] + leg.t[2]) / 2)
    np.testing.assert_allclose(halfway, (leg.q[1] + leg.q[2]) / 2)


def test_an_arm_stands_at_home_before_its_first_leg_and_stays_at_its_last_end(cell, plan, runs):
    second = plan.arms[1].arm
    before = moments(cell, runs, 0.5)[second]
    assert before.leg is None
    np.testing.assert_array_equal(before.q, cell.arm(second).home)
    first = plan.arms[0]
    after = moments(cell, runs, plan.cycle_seconds)[first.arm]
    np.testing.assert_allclose(after.q, first.legs[-1].q[-1])


def test_without_a_plan_all_arms_stand_at_home(cell):
    for arm in cell.arms:
        np.testing.assert_array_equal(moments(cell, (), 3.0)[arm.name].q, arm.home)


@settings(deadline=None, max_examples=50)
@given(time=st.floats(-10, 100))
def test_no_time_leaves_the_waypoints_of_the_plan(cell, runs, time):
    for name, now in moments(cell, runs, time).items():
        passed = [cell.arm(name).home, *(q for run in runs if run.arm == name for q in run.leg.q)]
        assert np.all(now.q >= np.min(passed, axis=0) - 1e-9)
        assert np.all(now.q <= np.max(passed, axis=0) + 1e-9)


def test_a_path_of_one_arm_is_made_of_its_moments(cell, plan, runs):
    times = np.linspace(0.0, plan.cycle_seconds, 50)
    for arm in cell.arms:
        expected = [moments(cell, runs, time)[arm.name].q for time in times]
        np.testing.assert_allclose(arm_path(arm, runs, times), expected)


@pytest.mark.parametrize("pace", [0.3, 1.0, 3.0])
def test_a_robot_on_the_path_is_followed_whatever_its_pace(cell, plan, runs, pace):
    found = 0.0
    for time in np.arange(0.0, plan.cycle_seconds, 0.05 * pace):
        joints = joint_values(cell, moments(cell, runs, time))
        found = follow_plan(cell, runs, joints, found)
        shown = joint_values(cell, moments(cell, runs, found))
        assert max(abs(shown[joint] - joints[joint]) for joint in joints) < 0.06
    assert found == pytest.approx(plan.cycle_seconds, abs=0.2)


def test_a_robot_that_stands_elsewhere_is_not_followed(cell, runs):
    joints = {joint: 1.5 for arm in cell.arms for joint in arm.joints}
    assert follow_plan(cell, runs, joints, 1.25) == 1.25
    assert follow_plan(cell, runs, {}, 1.25) == 1.25
    assert follow_plan(cell, (), joints, 1.25) == 1.25


def test_joint_values_name_every_joint_of_every_arm(cell, runs):
    values = joint_values(cell, moments(cell, runs, 1.0))
    assert set(values) == {joint for arm in cell.arms for joint in arm.joints}


def test_parts_lie_where_they_were_found_at_the_start(cell, kinematics, plan, runs):
    for T, detection in zip(
        part_poses(cell, kinematics, (plan,), runs, 0.0), plan.detections, strict=True
    ):
        assert T.isApprox(detection.T_world_part)


def test_a_part_is_taken_up_from_where_it_was_found(cell, kinematics, plan, runs):
    for arm in plan.arms:
        start = next(run.start for run in runs if run.arm == arm.arm and run.leg.holding)
        T = part_poses(cell, kinematics, (plan,), runs, start)[arm.detection]
        found = plan.detections[arm.detection].T_world_part
        assert np.linalg.norm(T.translation - found.translation) < 1e-3


def test_a_part_moves_with_the_hand_and_stays_where_it_was_placed(cell, kinematics, plan, runs):
    for arm_plan in plan.arms:
        arm = cell.arm(arm_plan.arm)
        carried = [run for run in runs if run.arm == arm.name and run.leg.holding]
        middle = (carried[1].start + carried[1].end) / 2
        q = moments(cell, runs, middle)[arm.name].q
        in_hand = kinematics.tcp_pose(arm, q) * arm_plan.T_tcp_part
        T = part_poses(cell, kinematics, (plan,), runs, middle)[arm_plan.detection]
        assert T.isApprox(in_hand)
        released = kinematics.tcp_pose(arm, carried[-1].leg.q[-1]) * arm_plan.T_tcp_part
        for time in (carried[-1].end + 0.01, plan.cycle_seconds + 5):
            T = part_poses(cell, kinematics, (plan,), runs, time)[arm_plan.detection]
            assert T.isApprox(released)


def test_the_drawn_path_begins_and_ends_with_the_leg(cell, kinematics, runs):
    run = runs[0]
    path = tcp_path(kinematics, cell, run, points=7)
    arm = cell.arm(run.arm)
    assert path.shape == (7, 3)
    np.testing.assert_allclose(path[0], kinematics.tcp_pose(arm, run.leg.q[0]).translation)
    np.testing.assert_allclose(path[-1], kinematics.tcp_pose(arm, run.leg.q[-1]).translation)

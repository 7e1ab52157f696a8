"""Robots under RAPID: ways, corners, stops, steps, and where the flange is."""

import itertools
import logging
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.devices.rapid.kinematics import Axes
from workbench.devices.rapid.motion import (
    CORNER_PATH,
    PREFETCH,
    TIME_STEP,
    JointWay,
    Mechanism,
    pair,
)
from workbench.planning.kinematics.robot import Kinematics

FAR = 1000.0


def robot(axes=2):
    return Mechanism("R", SimpleNamespace(home=np.zeros(axes)))


def run(*robots, steps=100_000):
    """Until all stand; every configuration of each that it went through."""
    seen = [[np.array(one.here)] for one in robots]
    for _ in range(steps):
        pair(robots)
        for one, where in zip(robots, seen, strict=True):
            one.advance(TIME_STEP)
            where.append(np.array(one.here))
        if all(one.is_standing for one in robots):
            return [np.array(where) for where in seen]
    raise AssertionError("it never stands")


def way(*points, seconds, share=0.0, number=None):
    return JointWay(np.array(points, float), seconds, share, number)


def inside(p, corners, slack=1e-9):
    """Whether a point of the plane lies in a triangle."""
    a, b, c = corners
    M = np.array([b - a, c - a]).T
    u, v = np.linalg.solve(M, p - a)
    return u >= -slack and v >= -slack and u + v <= 1 + slack


def beside(p, a, b):
    """How far a point is from the line through two others."""
    (x, y), (u, v) = b - a, p - a
    return abs(x * v - y * u) / np.hypot(x, y)


@pytest.mark.parametrize("seed", range(5))
def test_a_corner_stays_in_its_triangle_and_keeps_the_speed(seed):
    rng = np.random.default_rng(seed)
    points = np.concatenate([[[0, 0]], rng.uniform(-50, 50, (4, 2))])
    shares = rng.uniform(0.05, 0.5, 3)
    one = robot()
    ways = [
        way(a, b, seconds=float(rng.uniform(0.3, 2)), share=float(share))
        for a, b, share in zip(points[:-1], points[1:], [*shares, 0.0], strict=True)
    ]
    for each in ways:
        one.add(each)
    (path,) = run(one)
    assert np.allclose(path[-1], points[-1])
    took = (len(path) - 1) * TIME_STEP
    assert took == pytest.approx(sum(each.seconds for each in ways), abs=2 * TIME_STEP)
    most = max(np.abs(np.diff(each.path, axis=0)[0] / each.seconds).max() for each in ways)
    assert np.abs(np.diff(path, axis=0)).max() / TIME_STEP <= most * (1 + 1e-6)
    corners = [
        (b + share * (a - b), b, b + 0.5 * (c - b))
        for a, b, c, share in zip(points, points[1:], points[2:], shares, strict=False)
    ]
    for p in path:
        on = [beside(p, a, b) < 1e-9 for a, b in itertools.pairwise(points)]
        assert any(on) or any(inside(p, corner) for corner in corners)
    assert np.linalg.norm(path - points[1], axis=1).min() > 0.1, "no corner was rounded"


def test_a_stop_point_is_reached_and_a_zone_without_a_next_way_becomes_one(caplog):
    one = robot()
    one.add(way((0, 0), (10, 0), seconds=1.0, share=0.3))
    with caplog.at_level(logging.WARNING):
        run(one)
    assert np.allclose(one.here, (10, 0))
    assert CORNER_PATH in caplog.text


def test_a_zone_that_is_too_short_becomes_a_stop_point(caplog):
    one = robot()
    one.add(way((0, 0), (10, 0), seconds=1.0, share=0.001))
    with caplog.at_level(logging.WARNING):
        one.add(way((10, 0), (10, 10), seconds=1.0))
    assert CORNER_PATH in caplog.text
    (path,) = run(one)
    assert np.linalg.norm(path - (10, 0), axis=1).min() < 0.05


def test_the_program_goes_on_shortly_before_a_zone_and_after_a_stop_point():
    one = robot()
    first = way((0, 0), (10, 0), seconds=1.0, share=0.3)
    one.add(first)
    passed = 0
    while not one.lets_on(first):
        one.advance(TIME_STEP)
        passed += 1
    assert passed * TIME_STEP == pytest.approx(0.7 - PREFETCH, abs=2 * TIME_STEP)
    last = way((10, 0), (10, 10), seconds=1.0)
    one.add(last)
    while not one.lets_on(last):
        one.advance(TIME_STEP)
    assert np.allclose(one.here, (10, 10))


def test_a_stop_holds_the_robot_on_its_way_and_clearing_leaves_it_there():
    one = robot()
    one.add(way((0, 0), (10, 0), seconds=1.0))
    one.advance(0.5)
    one.stops.add("program")
    one.advance(FAR)
    assert np.allclose(one.here, (5, 0)) and one.is_standing
    one.stops.clear()
    one.advance(0.25)
    assert np.allclose(one.here, (7.5, 0))
    one.clear()
    one.advance(FAR)
    assert np.allclose(one.here, (7.5, 0)) and np.allclose(one.end, (7.5, 0))


def test_robots_in_step_pass_their_points_together():
    one, other = robot(), robot()
    one.is_in_step = other.is_in_step = True
    for k, seconds in enumerate((0.5, 0.8, 0.4), start=1):
        share = 0.3 if k < 3 else 0.0
        a = (10.0 * (k - 1), 10.0 * ((k - 1) % 2))
        b = (10.0 * k, 10.0 * (k % 2))
        one.add(way(a, b, seconds=seconds, share=share, number=k))
        other.add(way(a, b, seconds=0.6, share=share / 2, number=k))
    mine, theirs = run(one, other)
    assert np.allclose(mine, theirs)
    assert (len(mine) - 1) * TIME_STEP == pytest.approx(0.6 + 0.8 + 0.6, abs=2 * TIME_STEP)


def test_robots_in_step_wait_for_each_other_and_differ_in_no_number():
    one, other = robot(), robot()
    one.is_in_step = other.is_in_step = True
    one.add(way((0, 0), (1, 0), seconds=1.0, number=1))
    pair([one, other])
    one.advance(FAR)
    assert np.allclose(one.here, 0)
    other.add(way((0, 0), (1, 0), seconds=1.0, number=2))
    assert "differ" in pair([one, other])


@pytest.mark.parametrize("name", ["right", "left"])
def test_the_flange_is_where_planning_has_it(cell, name):
    arm = cell.arm(name)
    axes, judge = Axes(cell, arm), Kinematics(cell)
    rng = np.random.default_rng(4)
    lower, upper, _ = cell.robot.limits(arm.joints)
    home = np.asarray(arm.home)
    tool = axes.flange(axes.home).actInv(judge.tcp_pose(arm, home))
    for _ in range(20):
        q = rng.uniform(lower, upper)
        T = axes.flange(axes.from_chain(q)) * tool
        assert T.isApprox(judge.tcp_pose(arm, q), 1e-9)
        assert np.allclose(axes.to_chain(axes.from_chain(q)), q)


def test_a_pose_is_reached_again(cell):
    axes = Axes(cell, cell.arm("right"))
    goal = axes.home + np.array([5, -8, 6, -4, 9, 3, -7])
    found = axes.reach(axes.flange(goal), axes.home)
    assert found is not None
    assert axes.flange(found).isApprox(axes.flange(goal), 1e-6)
    far = axes.flange(goal)
    far.translation = far.translation + np.array([3.0, 0, 0])
    assert axes.reach(far, axes.home) is None

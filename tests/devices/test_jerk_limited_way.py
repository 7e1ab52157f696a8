"""A leg with limits of jerk as it is streamed: what SciPy makes of its references is the judge."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BSpline

from workbench.devices.jerk_limited_way import JerkLimitedWay, jerk_limited_way
from workbench.devices.streamed_way import Ride, StreamedWay, timed_way
from workbench.model.plan import Leg
from workbench.planning.kinematics.execution import compute_times

PERIOD = 0.0005
VELOCITY, ACCELERATION = np.full(7, 1.5), np.full(7, 10.0)
JERK = np.full(7, 120.0)
EQUAL = 1e-6


def leg_of(waypoints: int, zone: float, seed: int = 0) -> Leg:
    steps = np.random.default_rng(seed).normal(size=(waypoints, 7)) * 0.2
    path = np.cumsum(steps, axis=0)
    return Leg(
        "reach", "joint", False, 0.0, path, compute_times(path, VELOCITY, ACCELERATION, zone, JERK)
    )


def ridden(ride: Ride) -> np.ndarray:
    qs = [ride.q]
    while not ride.is_over:
        qs.append(ride.go())
    return np.array(qs)


def way_of(leg: Leg, zone: float) -> JerkLimitedWay:
    return jerk_limited_way(leg, VELOCITY, ACCELERATION, JERK, zone)


def judged(q: np.ndarray, period: float) -> list[np.ndarray]:
    """The largest speeds, accelerations and jerks (n,) of the B-spline whose points they are.

    Its third derivative is the mean of that of the motion over three periods: through references
    in which jerk jumps a spline would swing.
    """
    spline = BSpline(np.arange(-3, len(q) + 1) * period, q, 3)
    t = np.arange(0.0, len(q) - 3, 0.25) * period
    return [np.abs(spline.derivative(order)(t)).max(axis=0) for order in (1, 2, 3)]


@pytest.mark.parametrize("zone", [0.0, 0.2, 0.45])
@pytest.mark.parametrize("waypoints", [2, 3, 30])
def test_waypoints_are_passed_when_the_plan_says(zone, waypoints):
    """In the middle of a blend an arm is nearest to the corner, in time, and between both ways."""
    leg = leg_of(waypoints, zone, 3)
    way = way_of(leg, zone)
    assert way.seconds == pytest.approx(leg.seconds, rel=1e-9) and way.pace == pytest.approx(1.0)
    for row in range(1, waypoints - 1):
        before, after = leg.q[row] - leg.q[row - 1], leg.q[row + 1] - leg.q[row]
        q, _, _ = way.at(float(leg.t[row]))
        shares, *_ = np.linalg.lstsq(np.array([-before, after]).T, q - leg.q[row])
        assert np.allclose(shares @ np.array([-before, after]), q - leg.q[row], atol=EQUAL)
        assert (shares >= -EQUAL).all() and (shares <= zone / 4 + EQUAL).all(), "the parabola"


@pytest.mark.parametrize(("zone", "share"), [(0.2, 1.0), (0.45, 0.5), (0.0, 1.0)])
@pytest.mark.parametrize("seed", range(4))
def test_the_spline_of_references_keeps_the_limits(zone, share, seed):
    leg = leg_of(9, zone, seed)
    q = ridden(Ride(way_of(leg, zone), share, PERIOD))
    v, a, j = judged(q, PERIOD)
    limits = VELOCITY * share, ACCELERATION * share**2, JERK * share**3
    for found, most in zip((v, a, j), limits, strict=True):
        assert (found <= most * (1 + 1e-4)).all()
    assert j.max() >= limits[2].max() * 0.999, "what is allowed is used"
    assert np.array_equal(q[0], leg.q[0]) and np.array_equal(q[-1], leg.q[-1])


def test_a_curve_is_what_its_derivatives_say():
    way = way_of(leg_of(6, 0.2, 1), 0.2)
    t = np.linspace(0.0, way.end, 20_001)
    q, v, a = (np.array(rows) for rows in zip(*(way.at(s) for s in t), strict=True))
    middle = slice(2, -2)
    for rows, slopes in ((q, v), (v, a)):
        assert np.allclose(np.gradient(rows, t, axis=0)[middle], slopes[middle], atol=JERK * t[1])
    assert np.abs(np.diff(a, axis=0)).max() <= (JERK * np.diff(t)[0]).max() * (1 + 1e-9)


def test_equal_waypoints_are_passed():
    path = np.array([[0.0] * 7, [0.0] * 7, [0.3] * 7, [0.3] * 7])
    t = compute_times(path, VELOCITY, ACCELERATION, 0.2, JERK)
    way = way_of(Leg("reach", "joint", False, 0.0, path, t), 0.2)
    assert way.seconds == pytest.approx(t[-1]) and t[-1] < 3.0


@pytest.mark.parametrize("after", [3, 40, 200])
def test_a_stop_stays_on_the_way_and_within_accelerations(after):
    period = 0.004
    way = way_of(leg_of(8, 0.2), 0.2)
    ride = Ride(way, 1.0, period)
    qs = [ride.go() for _ in range(after)]
    ride.brake()
    qs += list(ridden(ride)[1:])
    a = np.diff(np.array(qs), n=2, axis=0) / period**2
    assert np.all(np.abs(a) <= ACCELERATION * 1.1) and ride.is_over
    fine = np.array([way.at(s)[0] for s in np.linspace(0, way.end, 4000)])
    assert max(np.abs(fine - q).max(axis=1).min() for q in qs[after:]) < 1e-3


def test_times_that_are_longer_are_ridden_slower_and_shorter_ones_are_not_believed():
    leg = leg_of(5, 0.2)
    for share, taken in ((2.0, 2.0), (0.5, 1.0)):
        way = way_of(Leg("reach", "joint", False, 0.0, leg.q, leg.t * share), 0.2)
        assert way.seconds == pytest.approx(taken * leg.seconds)


def test_a_leg_is_streamed_within_the_limits_of_its_cell(cell, plan):
    """Where an arm has no limit of jerk, as it was before there were any."""
    arm, period = replace(cell.arms[0], jerk=cell.arms[0].acceleration * 20.0), 0.004
    velocity = cell.robot.limits(arm.joints)[2] * cell.policy.speed
    leg = plan.arm(arm.name).legs[0]
    limits = velocity, arm.acceleration, arm.jerk
    t = compute_times(np.asarray(leg.q), velocity, arm.acceleration, cell.policy.zone, arm.jerk)
    way = timed_way(cell, plan, arm, replace(leg, t=t))
    assert way.seconds == pytest.approx(t[-1], rel=1e-9)
    for found, most in zip(judged(ridden(Ride(way, 1.0, period)), period), limits, strict=True):
        assert (found <= most * (1 + 1e-4)).all()
    assert isinstance(timed_way(cell, plan, cell.arms[0], leg), StreamedWay)

"""A leg as a curve in time: the plan's times, the limits, and stops on the way."""

import numpy as np
import pytest

from workbench.devices.streamed_way import Ride, way_of
from workbench.model.plan import Leg
from workbench.planning.kinematics.execution import compute_times

PERIOD = 0.004
VELOCITY, ACCELERATION = np.full(7, 1.5), np.full(7, 10.0)


def leg_of(waypoints: int, zone: float, seed: int = 0) -> Leg:
    steps = np.random.default_rng(seed).normal(size=(waypoints, 7)) * 0.2
    path = np.cumsum(steps, axis=0)
    return Leg(
        "reach", "joint", False, 0.0, path, compute_times(path, VELOCITY, ACCELERATION, zone)
    )


def ridden(ride: Ride, most: int = 100_000) -> np.ndarray:
    qs = [ride.q]
    while not ride.is_over and len(qs) <= most:
        qs.append(ride.go())
    return np.array(qs)


@pytest.mark.parametrize("zone", [0.2, 0.45])
@pytest.mark.parametrize("waypoints", [2, 3, 30])
def test_waypoints_are_passed_when_the_plan_says(zone, waypoints):
    leg = leg_of(waypoints, zone)
    way = way_of(leg, VELOCITY, ACCELERATION, zone)
    passed = way.t[np.searchsorted(way.s, np.arange(waypoints) - 1e-9)]
    assert np.abs(passed - leg.t).max() < 1e-6


@pytest.mark.parametrize(("zone", "share"), [(0.2, 1.0), (0.45, 0.3), (0.0, 1.0)])
def test_references_keep_the_limits_and_end_at_the_end(zone, share):
    leg = leg_of(12, zone)
    qs = ridden(Ride(way_of(leg, VELOCITY, ACCELERATION, zone), share, PERIOD))
    v = np.diff(qs, axis=0) / PERIOD
    a = np.diff(qs, n=2, axis=0) / PERIOD**2
    assert np.all(np.abs(v) <= VELOCITY * share * 1.001)
    assert np.all(np.abs(a) <= ACCELERATION * share**2 * 1.001)
    assert np.array_equal(qs[0], leg.q[0]) and np.allclose(qs[-1], leg.q[-1], atol=1e-12)
    assert len(qs) * PERIOD >= leg.seconds / share


@pytest.mark.parametrize("after", [3, 40, 200, 400])
def test_a_stop_stays_on_the_way_and_within_the_limits(after):
    way = way_of(leg_of(8, 0.2), VELOCITY, ACCELERATION, 0.2)
    ride, qs = Ride(way, 1.0, PERIOD), []
    for _ in range(after):
        qs.append(ride.go())
    ride.brake()
    qs += list(ridden(ride))
    a = np.diff(np.array(qs), n=2, axis=0)[1:] / PERIOD**2
    assert np.all(np.abs(a[: after - 3]) <= ACCELERATION * 1.001)
    fine = np.array([way.at(s)[0] for s in np.linspace(0, way.s[-1], 4000)])
    off = [np.abs(fine - q).max(axis=1).min() for q in qs[after:]]
    assert max(off) < 1e-3 and ride.is_over
    stood = ride.q
    assert np.array_equal(ride.go(), stood), "it stays where it stands"


def test_a_plan_that_was_timed_slower_is_ridden_slower():
    leg = leg_of(5, 0.2)
    slow = Leg(leg.name, leg.motion, False, 0.0, leg.q, leg.t * 2)
    assert way_of(slow, VELOCITY, ACCELERATION, 0.2).seconds == pytest.approx(2 * leg.seconds)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_streamed_keeps_the_limits_whatever_times_a_plan_has(seed):
    """Of a plan's times the last counts, and where that is too soon, what limits allow."""
    leg, draw = leg_of(10, 0.2, seed), np.random.default_rng(seed)
    steps = draw.permutation(np.diff(leg.t)) * draw.uniform(0.1, 2.0, 9)
    bent = Leg(leg.name, leg.motion, False, 0.0, leg.q, np.concatenate([[0.0], np.cumsum(steps)]))
    qs = ridden(Ride(way_of(bent, VELOCITY, ACCELERATION, 0.2), 1.0, PERIOD))
    assert np.all(np.abs(np.diff(qs, axis=0)) / PERIOD <= VELOCITY * 1.001)
    assert np.all(np.abs(np.diff(qs, n=2, axis=0)) / PERIOD**2 <= ACCELERATION * 1.001)
    assert len(qs) * PERIOD >= max(bent.seconds, leg.seconds) - PERIOD

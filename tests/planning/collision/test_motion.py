"""Curves as the controller follows them, and the continuous check along them."""

import itertools

import numpy as np
import pytest
from blend_curves import RoundedPolyline, curves_of
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.model.motion import MotionModel
from workbench.planning.collision.motion import (
    RESOLUTION,
    SHARP_CORNER,
    bound_curves,
    chain_contact,
    segment,
    straight,
)
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.execution import compute_times
from workbench.proof.claims.motion import sweep_path


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 9999), zone=st.floats(0.0, 0.45), count=st.integers(2, 8))
def test_curves_join_and_are_those_that_are_timed(seed, zone, count):
    path = np.random.default_rng(seed).uniform(-2.0, 2.0, (count, 3))
    curves = curves_of(path, zone)
    assert np.array_equal(curves.points[0, 0], path[0])
    assert np.array_equal(curves.points[-1, -1], path[-1])
    for a, b in itertools.pairwise(curves.points):
        np.testing.assert_allclose(a[-1], b[0], atol=1e-12)
    assert len(curves.waypoints) == len(curves.points)
    rounded = RoundedPolyline(path, zone)
    for points, waypoint in zip(curves.points, curves.waypoints, strict=True):
        a, b, c = points
        assert 0 <= waypoint < count - 1
        middle = (a + 2 * b + c) / 4
        dense = rounded(np.linspace(0.0, count - 1.0, 400 * (count - 1) + 1))
        assert np.linalg.norm(dense - middle, axis=1).min() < 0.02


@pytest.mark.parametrize("corners", ["blend", "streamed"])
@settings(max_examples=50, deadline=None)
@given(
    seed=st.integers(0, 9999),
    zone=st.floats(0.01, 0.45),
    count=st.integers(3, 6),
    less=st.floats(0.0, 1.0),
    along=st.floats(0.0, 1.0),
)
def test_whatever_a_controller_makes_of_a_corner_is_walked_nearby(
    corners, seed, zone, count, less, along
):
    """Rounded by less than allowed, or cut between two samples: wherever along it one looks."""
    path = np.random.default_rng(seed).uniform(-2.0, 2.0, (count, 3))
    motion = MotionModel("some", corners=corners, period=0.004)
    curves = bound_curves(path, motion, zone)
    assert np.all(np.diff(curves.waypoints) >= 0)
    for number, points in enumerate(straight(path).points):
        assert points.tolist() in curves.points[curves.waypoints == number].tolist()
    t = np.linspace(0.0, 1.0, 41)[:, None]
    for number, (before, corner, after) in enumerate(zip(path, path[1:], path[2:], strict=False)):
        share = less * (zone if corners == "blend" else 0.5)
        enter, leave = corner + share * (before - corner), corner + share * (after - corner)
        middle = corner if corners == "blend" else (enter + leave) / 2.0
        at = (1 - along) ** 2 * enter + 2 * along * (1 - along) * middle + along**2 * leave
        by = curves.points[np.isin(curves.waypoints, (number, number + 1))]
        dense = by[:, None, 0] + t * (by[:, None, 2] - by[:, None, 0])
        # Half of what lies between two roundings, and between two of the points looked at.
        near = np.abs(dense - at).max(axis=2).min()
        assert near <= SHARP_CORNER / 2 + np.abs(np.diff(dense, axis=1)).max() / 2


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 9999), zone=st.floats(0.01, 0.45))
def test_what_the_proof_checks_farthest_from_a_corner_is_walked(seed, zone):
    path = np.random.default_rng(seed).uniform(-2.0, 2.0, (3, 4))
    motion = MotionModel("some", corners="blend")
    before, corner, after = path
    sides = np.stack([before - corner, after - corner], axis=1)
    triangles = sweep_path(np.arange(4), path, motion, zone).corners[1:-1]
    chords = []
    for start, end in itertools.chain(*(itertools.combinations(one, 2) for one in triangles)):
        shares = np.linalg.lstsq(sides, np.stack([start - corner, end - corner], axis=1))[0]
        # Both ends lie on the widest parabola.
        if np.allclose(np.sqrt(np.abs(shares) / zone).sum(axis=0), 1.0, atol=1e-5):
            chords.append((start, end))
    assert len(chords) > 1
    curves = bound_curves(path, motion, zone).points
    for start, end in chords:
        ends = np.abs(curves[:, [0, 2]] - np.stack([start, end])).max(axis=(1, 2))
        assert ends.min() < 1e-9


def test_a_rounding_that_the_proof_would_refuse_is_not_clear(cell):
    """The widest rounding passes the wall at 5.0 mm, the proof's chords of it at 4.9 mm."""
    empty = World(cell, ())
    empty.enter(LegPhase(frozenset({"left"}), {"left": 0.04}))
    path = np.deg2rad(
        [
            [0.0, -130.0, 135.0, 30.0, 0.0, 40.0, 0.0],
            [-65.67, -62.11, 81.82, 26.65, 90.65, 59.06, -96.52],
            [-81.48, -65.18, 77.51, 21.89, 109.59, 62.14, -115.46],
        ]
    )
    columns, base = empty.kinematics.columns["left"], empty.configuration({})
    motion = MotionModel("some", corners="blend")
    assert chain_contact(empty, columns, base, straight(path)) is None
    contact, _, waypoint = chain_contact(empty, columns, base, bound_curves(path, motion, 0.2))
    assert (contact.pair, waypoint) == (("left finger_a", "bin_wall_left"), 0)
    assert 0.0049 < contact.distance < contact.margin


def test_a_controller_that_stops_makes_nothing_of_a_corner():
    path = np.random.default_rng(0).uniform(-2.0, 2.0, (5, 3))
    stopping = bound_curves(path, MotionModel("some", corners="stop"), 0.2)
    np.testing.assert_array_equal(stopping.points, straight(path).points)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 9999), zone=st.floats(0.05, 0.45))
def test_timing_respects_speed_and_acceleration(seed, zone):
    path = np.random.default_rng(seed).uniform(-1.0, 1.0, (6, 4))
    velocity, acceleration = np.array([1.0, 2.0, 1.5, 3.0]), np.full(4, 8.0)
    times = compute_times(path, velocity, acceleration, zone)
    assert times[0] == 0.0 and np.all(np.diff(times) > 0)
    mean_speed = np.abs(np.diff(path, axis=0)) / np.diff(times)[:, None]
    # A rounded corner is shorter than the waypoints make it look, never by more than its zone.
    assert np.all(mean_speed <= velocity / (1 - zone))


@pytest.mark.extensive
def test_a_motion_through_an_obstacle_is_found_between_clear_ends(world, cell):
    """From one side of the bin's wall to the other: both ends clear, the way not."""
    arm = cell.arm("right")
    chain, columns = world.chains["right"], world.kinematics.columns["right"]
    world.enter(LegPhase(frozenset({"right"})))
    base = world.configuration({})
    rng = np.random.default_rng(0)
    blocked = 0
    for _ in range(400):
        a, b = rng.uniform(chain.lower, chain.upper, (2, 7))
        ends = [world.contact(world.configuration({"right": q})) for q in (a, b)]
        if any(ends):
            continue
        found = chain_contact(world, columns, base, segment(a, b))
        rooms = [
            world.worst(world.configuration({"right": a + s * (b - a)}), 0.01)[1]
            for s in np.linspace(0.0, 1.0, 200)
        ]
        if min(rooms) < -RESOLUTION:
            assert found is not None, "dense sampling sees a contact that the bound missed"
        if found is not None:
            blocked += 1
            contact, q, _ = found
            assert contact.distance < contact.margin
            assert world.contact(world.configuration({"right": q})) is not None
    assert blocked > 5
    assert (
        chain_contact(world, columns, base, segment(np.asarray(arm.home), np.asarray(arm.home)))
        is None
    )


def test_compiled_and_measured_checks_agree(cell, detections):
    """The planner's check and the proof's, on the same motions."""
    fast, measured = World(cell, detections), World(cell, detections, by_coal=True)
    rng = np.random.default_rng(1)
    met = 0
    for name in ("right", "left") * 60:
        chain, columns = fast.chains[name], fast.kinematics.columns[name]
        start = rng.uniform(chain.lower, chain.upper)
        end = np.clip(start + rng.normal(0, 0.4, len(start)), chain.lower, chain.upper)
        found = []
        for world in (fast, measured):
            world.enter(LegPhase(frozenset({name}), {name: 0.03}))
            base = world.configuration({})
            found.append(chain_contact(world, columns, base, segment(start, end)))
        assert (found[0] is None) == (found[1] is None)
        if found[0] is not None:
            contact, *_ = found[0]
            assert contact.distance < contact.margin + 1e-6
            met += 1
    assert 20 < met < 110

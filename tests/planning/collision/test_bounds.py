"""The bounds on which every check rests: against brute force over all pairs."""

import numpy as np
import pinocchio as pin
from hypothesis import given, settings
from hypothesis import strategies as st
from shipped import shipped

from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World

CELL = shipped("yumi")
T_WORLD_PART = CELL.bin.T_world_bin * pose_from_rpy((0.0, 0.05, 0.02), (1.57, 0.0, 0.3))
WORLD = World(CELL, (Detection("keyed_cylinder", T_WORLD_PART),))
LOWER = WORLD.kinematics.model.lowerPositionLimit
UPPER = WORLD.kinematics.model.upperPositionLimit

EXACT = 1e-10

PHASES = (
    LegPhase(frozenset({"right", "left"})),
    LegPhase(
        frozenset({"right"}), {"right": 0.05}, targets={"right": 0}, straight=frozenset({"right"})
    ),
    LegPhase(frozenset({"left"}), {"left": 0.03}, held={"left": (0, pose_from_rpy((0, 0, 0.01)))}),
)


def all_distances(q: np.ndarray, tolerance: float | None = None) -> np.ndarray:
    """Every pair by Pinocchio and Coal, no bounds in between; inactive ones infinitely far.

    With its usual tolerance of 1e-6 Coal's distances are up to 1.5e-6 m too long (13,000 of them
    beside those with 1e-10).
    """
    kinematics, data = WORLD.kinematics, WORLD._data
    if tolerance is not None:
        data = pin.GeometryData(WORLD._geometry)
        for request in data.distanceRequests:
            request.gjk_tolerance, request.gjk_max_iterations = tolerance, 1000
    pin.computeDistances(kinematics.model, kinematics.data, WORLD._geometry, data, q)
    distances = np.array([result.min_distance for result in data.distanceResults])
    inactive = np.setdiff1d(np.arange(len(distances)), WORLD.pairs.among)
    distances[inactive] = np.inf
    return distances


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), phase=st.sampled_from(PHASES))
def test_the_nearest_pair_is_that_of_brute_force(seed, phase):
    WORLD.enter(phase)
    q = np.random.default_rng(seed).uniform(LOWER, UPPER)
    distances = all_distances(q)
    distances[WORLD.pairs.own] = np.inf
    clearance, pair = WORLD.clearance(q, 0.3)
    assert clearance == np.float64(min(distances.min(), 0.3)) or np.isclose(
        clearance, min(distances.min(), 0.3), atol=1e-6
    )
    assert (pair is None) == (distances.min() >= 0.3)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), phase=st.sampled_from(PHASES))
def test_a_contact_is_found_exactly_when_brute_force_finds_one(seed, phase):
    WORLD.enter(phase)
    q = np.random.default_rng(seed).uniform(LOWER, UPPER)
    room = (all_distances(q) - WORLD._margins).min()
    if abs(room) > 1e-6:
        assert (WORLD.contact(q) is not None) == (room < 0)


@settings(max_examples=80, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    phase=st.sampled_from(PHASES),
    size=st.floats(0.001, 0.5),
)
def test_no_pair_comes_nearer_than_the_motion_bound_allows(seed, phase, size):
    WORLD.enter(phase)
    rng = np.random.default_rng(seed)
    q = rng.uniform(LOWER, UPPER)
    span = rng.uniform(0.0, size, len(q))
    before = all_distances(q, EXACT)
    pairs, moves, lower = WORLD._close(q, span, 10.0, None)
    assert set(pairs) == set(WORLD.pairs.among)
    assert np.all(lower <= before[pairs] + 1e-6)
    for _ in range(4):
        after = all_distances(q + span * rng.uniform(-1.0, 1.0, len(q)), EXACT)
        # Depths of penetrations are not exact in Coal: what counts is that pairs which the bound
        # keeps apart are apart, and that those which are apart have come no nearer than it says.
        bound = before[pairs] - moves
        counts = (before[pairs] > 0) & ((bound > 0) | (after[pairs] > 0))
        assert np.all(after[pairs][counts] >= bound[counts] - 1e-6)

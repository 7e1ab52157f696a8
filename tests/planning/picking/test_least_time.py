"""The lower bound of a cycle: what a joint, a way and two arms need at least, and every plan."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.app.picking.pipeline import plan_pick
from workbench.model.messages.plans import cycle_words
from workbench.model.plan import Strategy
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.collision.world import World
from workbench.planning.kinematics.execution import compute_times
from workbench.planning.picking.least_time import least_cycle, least_seconds, share_work

VELOCITY, ACCELERATION = np.array([2.0, 3.0, 4.0]), np.array([10.0, 2.0, 15.0])

LIMITS = {"velocity": VELOCITY, "acceleration": ACCELERATION}


def quickest(far: float, velocity: float, acceleration: float) -> float:
    """What a joint needs from rest to rest, found by trying every time in steps."""
    for seconds in np.arange(0.0, 10.0, 0.0005):
        # As quick as can be from both ends: no motion is anywhere quicker.
        t = np.linspace(0.0, seconds, 2001)
        speed = np.minimum(np.minimum(t, seconds - t) * acceleration, velocity)
        if np.trapezoid(speed, t) >= far:
            return float(seconds)
    raise AssertionError


@pytest.mark.parametrize("far", [0.01, 0.3, 1.0, 2.5])
@pytest.mark.parametrize("joint", range(3))
def test_a_joint_alone_takes_as_long_as_trying_says(far, joint):
    ends = np.zeros((1, 7, 3))
    ends[0, 1:, joint] = far  # reach alone moves
    found = least_seconds(ends, **LIMITS)
    assert found == pytest.approx([quickest(far, VELOCITY[joint], ACCELERATION[joint])], abs=0.002)


@settings(max_examples=60)
@given(seed=st.integers(0, 9999), zone=st.sampled_from([0.0, 0.2, 0.45]))
def test_no_timing_of_any_legs_is_quicker(seed, zone):
    """Six legs with waypoints of their own between their ends, timed as plans are."""
    draw = np.random.default_rng(seed)
    ends = np.cumsum(draw.normal(size=(7, 3)) * draw.choice([0.01, 0.3, 2.0], (7, 1)), axis=0)
    legs = [
        np.vstack([a, draw.uniform(-1, 1, (draw.integers(4), 3)), b]) for a, b in pairwise(ends)
    ]
    taken = sum(compute_times(leg, VELOCITY, ACCELERATION, zone)[-1] for leg in legs)
    (least,) = least_seconds(ends[None], **LIMITS)
    assert least <= taken
    alone = sum(compute_times(leg[[0, -1]], VELOCITY, ACCELERATION, zone)[-1] for leg in legs)
    assert least <= alone <= 3.2 * least


def test_between_two_stops_nothing_stands_still():
    """Three legs to the place in one go: the joint speeds up once."""
    ends = np.zeros((1, 7, 3))
    ends[0, 3:, 0] = [1.0, 2.0, 3.0, 3.0]
    assert least_seconds(ends, **LIMITS) == pytest.approx(3.0 / 2.0 + 0.2)


@settings(max_examples=200)
@given(
    times=st.lists(st.none() | st.floats(0.5, 9.0), min_size=9, max_size=9),
    parts=st.integers(1, 3),
)
def test_parts_are_shared_among_arms_as_is_best(times, parts):
    arms = ("right", "left", "third")
    keys = product(arms, range(3))
    alone = {key: one for key, one in zip(keys, times, strict=True) if one is not None}
    best = np.inf
    for chosen in product(arms, repeat=parts):
        work = {arm: 0.0 for arm in arms}
        for part, arm in enumerate(chosen):
            work[arm] += alone.get((arm, part), np.inf)
        best = min(best, max(work.values()))
    if np.isfinite(best):
        assert share_work(alone, range(parts)) == pytest.approx(best)
    else:
        with pytest.raises(ValueError):
            share_work(alone, range(parts))


@pytest.mark.extensive
@pytest.mark.parametrize("seed", [3, 8, 16, 38])
def test_no_plan_is_quicker_than_its_bound(cell, seed):
    pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=seed)
    bounds = set()
    for strategy in ("right", "left", "alternated", "coordinated", "auto"):
        result = plan_pick(cell, pile, "scan", strategy=strategy, seed=seed)
        if result.plan is None:
            assert result.bound == 0.0
            continue
        assert 0.0 < result.bound <= result.plan.cycle_seconds
        bounds.add((len(result.plan.arms), round(result.bound, 2)))
    assert bounds


def test_other_ways_to_take_a_part_can_only_lower_it(cell, detections, result):
    """A plan by itself has the bound of its own ways; an arm that is slower has a higher one."""
    world = World(cell, detections)
    alone = least_cycle(world, result.plan, [])
    assert 0.0 < result.bound <= alone <= result.plan.cycle_seconds
    slow = World(cell, detections, policy=replace(cell.policy, speed=cell.policy.speed / 2))
    assert least_cycle(slow, result.plan, []) > 1.2 * alone
    first = replace(result.plan, arms=result.plan.arms[:1], strategy=Strategy.single("right"))
    assert least_cycle(world, first, []) <= alone


def test_it_is_said_beside_the_time():
    assert str(cycle_words(6.74, 5.0)) == "6.7 s, 1.3 × the theoretical minimum"
    assert str(cycle_words(6.74, 0.0)) == "6.7 s"

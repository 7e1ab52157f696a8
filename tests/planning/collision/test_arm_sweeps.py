"""Whether two arms can meet: the answer holds for all pairs of states on their ways."""

import itertools

import numpy as np
import pytest
from blend_curves import curves_of

from workbench.planning.collision.arm_sweeps import ArmSweep, first_contact, standing
from workbench.planning.collision.legs import phase_of
from workbench.planning.collision.motion import RESOLUTION, segment, straight
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import is_solution


@pytest.fixture
def both(world):
    """The world with both arms on the move and empty hands."""
    world.enter(LegPhase(frozenset({"right", "left"})))
    return world


def ways(world, seed: int, count: int = 4, spread: float = 0.5):
    """A way of each arm about its home, not through anything of its own."""
    rng = np.random.default_rng(seed)
    paths = {}
    for arm in world.cell.arms:
        lower, upper, _ = world.cell.robot.limits(arm.joints)
        path = np.asarray(arm.home) + rng.uniform(-spread, spread, (count, len(arm.joints)))
        # Towards the other arm: the first axis turns the arm inwards.
        path[:, 0] += rng.uniform(-1.2, 1.2)
        paths[arm.name] = np.clip(path, lower, upper)
    return paths


def between(world, state) -> float:
    """How much room the arms have beyond their margin, measured at one state."""
    q = world.configuration(state)
    contact = world.nearest(q, world.pairs.between())
    return contact.distance - contact.margin


def sweeps_of(world, paths):
    return [ArmSweep(arm, straight(path).points) for arm, path in paths.items()]


@pytest.fixture(params=["compiled", "by Coal"])
def either(request, both, cell, detections):
    """That world, and one whose arms are measured by Coal at every state."""
    if request.param == "compiled":
        return both
    measured = World(cell, detections, by_coal=True)
    measured.enter(LegPhase(frozenset({"right", "left"})))
    return measured


@pytest.mark.parametrize("seed", range(30))
def test_the_answer_agrees_with_dense_sampling(either, seed):
    both, paths = either, ways(either, seed)
    met = first_contact(both, both.configuration({}), *sweeps_of(both, paths))
    if met is not None:
        assert between(both, dict(zip(paths, met.q, strict=True))) < 0
        assert met.contact.distance < met.contact.margin
        return
    dense = {
        arm: np.concatenate(
            [a + s * (b - a) for a, b in itertools.pairwise(path) for s in np.linspace(0, 1, 5)]
        ).reshape(-1, 7)
        for arm, path in paths.items()
    }
    for q, p in itertools.product(dense["right"], dense["left"]):
        assert between(both, {"right": q, "left": p}) > -RESOLUTION


def test_the_seeds_above_show_both_answers(both):
    base = both.configuration({})
    answers = [
        first_contact(both, base, *sweeps_of(both, ways(both, seed))) is None for seed in range(30)
    ]
    assert 3 < sum(answers) < 27


@pytest.mark.parametrize("zone", [0.0, 0.3])
def test_compiled_and_measured_answers_agree(both, cell, detections, zone):
    """Along rounded ways too, where the one of an arm is many curves and that of the other few."""
    measured = World(cell, detections, by_coal=True)
    measured.enter(LegPhase(frozenset({"right", "left"})))
    met = 0
    for seed in range(40):
        paths = ways(both, seed, count=2 + seed % 4)
        paths["left"] = paths["left"][: 2 + seed % 2]
        sweeps = [ArmSweep(arm, curves_of(path, zone).points) for arm, path in paths.items()]
        found, known = (
            first_contact(world, world.configuration({}), *sweeps) for world in (both, measured)
        )
        assert (found is None) == (known is None)
        if found is not None and known is not None:
            met += 1
            assert found.contact.pair == known.contact.pair
            assert found.contact.distance == pytest.approx(known.contact.distance, abs=1e-9)
            assert found.curves == known.curves
            for q, p in zip(found.q, known.q, strict=True):
                np.testing.assert_allclose(q, p, atol=1e-12)
    assert 5 < met < 35


def test_one_that_stands_is_met_by_one_that_comes(both, cell, result):
    """The left hand goes to where the right one is; there it meets it, elsewhere it does not."""
    plan = result.plan.arm("right")
    there = np.asarray(plan.leg("approach").q[-1])
    T_world_tcp = both.chains["right"].pose(there)
    chain = both.chains["left"]
    rng = np.random.default_rng(0)
    starts = rng.uniform(chain.lower, chain.upper, (40, 7))
    answers, residuals = chain.solve(T_world_tcp, starts)
    goal = answers[is_solution(residuals)][0]
    base = both.configuration({})
    way = ArmSweep("left", segment(np.asarray(cell.arm("left").home), goal).points)
    met = first_contact(both, base, standing("right", there), way)
    assert met is not None
    assert {label.split("_")[0].split()[0] for label in met.contact.pair} == {"right", "left"}
    assert np.array_equal(met.q[0], there)


def test_ways_that_are_long_are_answered_in_bounded_time(both, monkeypatch):
    """With no looks left the arms count as meeting."""
    monkeypatch.setattr("workbench.planning.collision.arm_sweeps.MOST_LOOKS", 3)
    for seed in range(5):
        before = both.checks
        first_contact(both, both.configuration({}), *sweeps_of(both, ways(both, seed)))
        assert both.checks - before < 10


def test_phases_of_both_arms_hold_both_parts(result):
    first, second = result.plan.arms
    phase = phase_of([(first, "return", 0.03), (second, "reach", 0.04)])
    assert phase.moving == {"right", "left"}
    assert set(phase.held) == {first.arm}
    assert phase.openings == {first.arm: 0.03, second.arm: 0.04}
    waiting = phase_of([(second, "approach", 0.04)], [(first, "place", 0.03)])
    assert waiting.moving == {second.arm}
    number, T_tcp_part, q = waiting.placed[first.arm]
    assert number == first.detection
    assert T_tcp_part == first.T_tcp_part
    np.testing.assert_array_equal(q, first.leg("place").q[-1])
    assert not waiting.held
    assert waiting.straight == {second.arm}

"""How soon joints get somewhere, and configurations of an arm that are drawn to be sooner."""

import numpy as np
import pytest

from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import is_solution
from workbench.planning.kinematics.execution import compute_times
from workbench.planning.kinematics.quickness import (
    LEAST_GAIN,
    Pace,
    draw_towards,
    pace_of,
    seconds_to_all,
)

TURN = Pace(np.array([1.0, 2.0]), np.array([4.0, 4.0]))


@pytest.mark.parametrize(
    ("far", "seconds"),
    [
        ([0.0, 0.0], 0.0),
        ([1.0, 0.0], 1.0 / 1.0 + 1.0 / 4.0),  # up to speed, on, and down again
        ([0.01, 0.0], 2 * (0.01 / 4.0) ** 0.5),  # never up to speed
        ([-1.0, 4.0], 4.0 / 2.0 + 2.0 / 4.0),  # the second joint has longer to go
    ],
)
def test_the_slowest_joint_decides_how_long_it_takes(far, seconds):
    assert TURN.seconds(np.array(far)) == pytest.approx(seconds)


def test_no_timing_is_quicker_and_a_straight_one_is_as_quick():
    rng = np.random.default_rng(0)
    for _ in range(20):
        path = np.cumsum(rng.normal(size=(3, 2)), axis=0)
        least = TURN.seconds(path[-1] - path[0])
        assert compute_times(path, TURN.velocity, TURN.acceleration, 0.2)[-1] >= least - 1e-9
        straight = compute_times(path[[0, -1]], TURN.velocity, TURN.acceleration, 0.2)[-1]
        # All joints move in proportion there, so that two of them may hold it up in turn.
        assert least - 1e-9 <= straight <= 1.5 * least


@pytest.fixture(scope="module")
def held(cell):
    """The right arm of the cell, poses of its tool over the bin, and answers for each."""
    chain = World(cell, ()).chains["right"]
    home = np.asarray(cell.arm("right").home)
    rng = np.random.default_rng(3)
    found = []
    while len(found) < 6:
        near = np.clip(home + rng.uniform(-1.0, 1.0, 7), chain.lower, chain.upper)
        T = chain.pose(near)
        answers, residuals = chain.solve(T, rng.uniform(chain.lower, chain.upper, (20, 7)))
        if is_solution(residuals).sum() > 3:
            found.append((T, answers[is_solution(residuals)]))
    return chain, home, found


def test_drawn_configurations_hold_the_tool_as_before_and_are_sooner_at_home(cell, held):
    chain, home, found = held
    pace = pace_of(chain, cell.policy.speed)
    won = []
    for T, q in found:
        nearer = draw_towards(chain, T, q, home[None], pace)
        for one in nearer:
            assert chain.pose(one).isApprox(T, 1e-5)
        assert np.all((nearer >= chain.lower - 1e-12) & (nearer <= chain.upper + 1e-12))
        before, after = (
            seconds_to_all(q, home[None], pace),
            seconds_to_all(nearer, home[None], pace),
        )
        assert np.all(after <= before)
        is_same = np.all(nearer == q, axis=1)
        assert np.all(before[~is_same] - after[~is_same] > LEAST_GAIN)
        won.extend(before - after)
    assert np.median(won) > 0.03, "the spare axis is worth something for most of them"


def test_an_arm_without_a_spare_axis_is_left_as_it_is(held):
    chain, home, _ = held
    q = np.array([home[:6]])
    assert draw_towards(chain, chain.pose(home), q, q, Pace(np.ones(6), np.ones(6))) is q

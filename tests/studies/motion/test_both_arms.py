"""Both arms as one: ends that are what they say, ways that touch nothing, by either planner."""

import itertools

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.errors import InputError
from workbench.studies.motion.both_arms import (
    ABOVE_FLOOR,
    OMPL,
    OURS,
    BothArms,
    PlanningAttempt,
    compare,
    figures,
    summary,
)


def quiet(done: float, note: str) -> None:
    """Nobody listens."""


@pytest.fixture(scope="module")
def both() -> BothArms:
    return BothArms(read_cell("yumi"))


def touches(both: BothArms, q) -> bool:
    state = dict(zip(both.arms, np.split(q, 2), strict=True))
    world = both.worlds[OURS]
    return world.contact(world.configuration(state)) is not None


def test_the_bin_is_between_start_and_goal_and_neither_touches_anything(both):
    T_bin_world, kinds = both.cell.bin.T_world_bin.inverse(), set()
    for seed in range(4):
        ends = both.ends(seed)
        assert not touches(both, ends.start) and not touches(both, ends.goal)
        for arm, one, other in zip(
            both.arms, np.split(ends.start, 2), np.split(ends.goal, 2), strict=True
        ):
            chain = both.worlds[OURS].chains[arm]
            p, after = (T_bin_world.act(chain.pose(q).translation) for q in (one, other))
            assert p[1] * after[1] < 0 and 0 <= p[2] <= ABOVE_FLOOR and 0 <= after[2] <= ABOVE_FLOOR
        kinds.add(ends.is_straight)
        assert np.array_equal(ends.start, both.ends(seed).start)
    assert kinds <= {True, False}


@pytest.mark.parametrize("planner", [OURS, OMPL])
def test_a_way_goes_from_end_to_end_and_touches_nothing(both, planner):
    found = 0
    for seed in range(4):
        made = both.attempt(planner, both.ends(seed), seed, 60.0)
        if made.path is None:
            continue
        found += 1
        assert np.array_equal(made.path[0], made.ends.start)
        assert np.array_equal(made.path[-1], made.ends.goal)
        assert made.seconds > 0 and both.worlds[OURS].motion.is_sendable(made.path)
        for a, b in itertools.pairwise(made.path):
            assert not any(touches(both, a + share * (b - a)) for share in np.linspace(0, 1, 20))
    assert found >= 3


def test_rows_count_what_was_tried(both):
    attempts = compare(both, pairs=3, seed=20, seconds=60.0, report=quiet)
    rows = {(row["planner"], row["ends"]): row for row in summary(attempts)}
    for planner in (OURS, OMPL):
        whole, searched = rows[planner, "all"], rows[planner, "not straight ahead"]
        straight = sum(one.ends.is_straight for one in attempts if one.planner == planner)
        assert (whole["pairs"], searched["pairs"]) == (3, 3 - straight)
        assert 0 < whole["median_ms"] <= whole["p95_ms"]


def test_what_was_not_found_counts_with_its_time(both):
    ends = both.ends(0)
    row = figures([PlanningAttempt(OURS, ends, 0.5, None, None)])
    assert (row["pairs"], row["solved"], row["median_ms"], row["motion"]) == (1, 0, 500.0, None)
    assert figures([])["median_ms"] is None


def test_a_cell_with_one_arm_is_refused():
    with pytest.raises(InputError, match="one arm"):
        BothArms(read_cell("tx2_90"))

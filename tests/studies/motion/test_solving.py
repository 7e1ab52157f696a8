"""Motion problems planned: what is invalid, what is found, and that it is clear."""

import itertools

import numpy as np
import pytest
from motion_stand_in import make_motion_problems
from stand_ins import DATA, sources

from workbench.formats.robots.motion_problems import read_motion_problems
from workbench.model.cell import Policy
from workbench.studies.motion.problems import ARM, cases_of
from workbench.studies.motion.solving import (
    OMPL,
    attempt,
    compare,
    figures,
    summary,
)

POLICY = Policy(margin=0.0, near_margin=0.0, self_margin=0.0)


def quiet(done: float, note: str) -> None:
    """Nobody listens."""


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    folder = tmp_path_factory.mktemp("problems")
    make_motion_problems(folder)
    return cases_of(read_motion_problems(folder), POLICY)


def test_what_starts_or_ends_in_something_is_told_apart(cases):
    invalid = {case.problem: case.invalid for case in cases if case.invalid}
    assert invalid == {
        "into the ball": invalid["into the ball"],
        "beyond": "its goal is beyond the limits of a joint",
    }
    assert invalid["into the ball"].startswith("at its goal ")
    assert "ball touch" in invalid["into the ball"]


def clear_along(case, path, steps=50) -> bool:
    shares = np.linspace(0.0, 1.0, steps)[:, None]
    return all(
        case.world.contact(case.world.configuration({ARM: q})) is None
        for a, b in itertools.pairwise(path)
        for q in a + shares * (b - a)
    )


@pytest.mark.parametrize("planner", ["rrtconnect", OMPL])
def test_a_path_goes_from_start_to_goal_in_whole_steps_and_touches_nothing(cases, planner):
    for case in (case for case in cases if not case.invalid):
        path = attempt(case, planner, 0, 60.0).path
        assert path is not None
        assert np.array_equal(path[0], case.start) and np.array_equal(path[-1], case.goal)
        assert case.world.motion.is_sendable(path)
        assert clear_along(case, path)


def test_the_way_past_the_ball_is_not_straight(cases):
    past = next(case for case in cases if case.problem == "past the ball")
    assert not clear_along(past, np.array([past.start, past.goal]))


def test_the_same_seed_brings_the_same_path(cases):
    past = next(case for case in cases if case.problem == "past the ball")
    one, other = (attempt(past, "rrtconnect", 5, 60.0).path for _ in range(2))
    assert np.array_equal(one, other)
    # The ends are the same ones for every seed, so what differs is the way between them.
    assert any(
        not np.array_equal(one, attempt(past, "rrtconnect", seed, 60.0).path) for seed in range(4)
    )


def test_a_row_a_set_counts_what_is_invalid_apart(cases):
    attempts = compare(cases, with_ompl=True, seed=0, seconds=60.0, report=quiet)
    for planner in ("rrtconnect", OMPL):
        free, way = summary(cases, attempts, planner)
        assert (free["set"], free["problems"], free["invalid"], free["solved"]) == ("free", 1, 0, 1)
        assert (way["set"], way["problems"], way["invalid"], way["solved"]) == (
            "in_the_way", 3, 2, 1,
        )  # fmt: skip
        assert 0 < way["median_ms"] <= way["p95_ms"]
    assert len(attempts) == 4


def test_without_a_valid_problem_there_are_no_times(cases):
    row = figures([case for case in cases if case.invalid], [])
    assert (row["problems"], row["invalid"], row["solved"]) == (2, 2, 0)
    assert row["median_ms"] is None and row["way"] is None


@pytest.mark.parametrize("source", sources("motion_problems")[1:])
def test_public_problems_on_a_table_are_solved(source):
    sets = read_motion_problems(DATA / "motion_problems", "panda")
    cases = cases_of([one for one in sets if one.name == "table_pick_panda"], POLICY)
    attempts = compare(cases, with_ompl=False, seed=0, seconds=60.0, report=quiet)
    assert len(attempts) == len(cases) == 10
    for case, made in zip(cases, attempts, strict=True):
        assert made.path is not None and clear_along(case, made.path, 10)

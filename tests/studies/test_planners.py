"""The comparison of planners: what counts as a target, and that attempts are what they say."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.studies.planners import Course, compare, summary
from workbench.studies.targets import TILT, drawn_poses


def quiet(done: float, note: str) -> None:
    """Nobody listens."""


@pytest.fixture(scope="module")
def course() -> Course:
    cell = read_cell("tx2_90")
    upright = replace(cell.arms[0], home=np.zeros(6))
    return Course(replace(cell, arms=(upright,)), 24, 0)


def test_poses_lie_in_the_bin_and_point_down_within_the_tilt():
    bin = read_cell("tx2_90").bin
    for T_world_tcp in drawn_poses(bin, 200, 1):
        p = bin.T_world_bin.actInv(T_world_tcp).translation
        assert np.all(np.abs(p[:2]) <= bin.size[:2] / 2) and 0 <= p[2] <= bin.size[2]
        assert -T_world_tcp.rotation[2, 2] >= np.cos(TILT) - 1e-9


def test_goals_are_clear_and_at_their_targets(course):
    chain = course.world.chains[course.arm.name]
    assert len(course.goals) >= 10
    for number, q in course.goals:
        at = course.targets[number].T_world_tcp.actInv(chain.pose(q))
        assert np.linalg.norm(at.translation) < 1e-3
        whole = course.world.configuration({course.arm.name: q})
        assert course.world.contact(whole) is None


def test_other_targets_say_why_nobody_can_solve_them(course):
    for target in course.targets:
        assert (target.q is None) == (target.outcome != "clear")


def test_more_iterations_never_lose_a_target(course):
    attempts = compare(course, ["rrtconnect", "sbl"], [2, 400], quiet)
    few, many, *_ = (
        {one.target for one in attempts if one.planner == "rrtconnect" and one.allowed == allowed
         and one.tool_way is not None}
        for allowed in (2, 400)
    )  # fmt: skip
    assert few <= many
    assert len(many) == len(course.goals)


def test_attempts_repeat_to_the_bit(course):
    def ways() -> list[float | None]:
        return [one.tool_way for one in compare(course, ["rrtconnect"], [100], quiet)]

    assert ways() == ways()


def test_no_way_is_shorter_than_the_straight_line(course):
    chain = course.world.chains[course.arm.name]
    start = chain.pose(course.start).translation
    for one in compare(course, ["rrtconnect"], [400], quiet):
        end = course.targets[one.target].T_world_tcp.translation
        assert one.tool_way >= np.linalg.norm(end - start) - 1e-3


def test_a_row_a_planner_and_number_of_iterations(course):
    attempts = compare(course, ["rrt", "sbl"], [5, 50], quiet)
    rows = summary(attempts)
    pairs = [(row["planner"], row["allowed"]) for row in rows]
    assert pairs == list(itertools.product(["rrt", "sbl"], [5, 50]))
    assert all(0 <= row["success"] <= 1 and row["attempts"] == len(course.goals) for row in rows)

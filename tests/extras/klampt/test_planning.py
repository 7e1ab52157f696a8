"""Klamp't solves what our planners do, over the same geometry."""

from dataclasses import replace

import numpy as np
import pytest
from motion_stand_in import make_motion_problems

from workbench.extras.klampt.planning import attempts_by_klampt, paths_by_klampt, solve_by_klampt
from workbench.formats.cells.reading import read_cell
from workbench.formats.robots.motion_problems import read_motion_problems
from workbench.model.cell import Policy
from workbench.model.errors import InputError
from workbench.studies.motion.problems import cases_of
from workbench.studies.motion.solving import KLAMPT, summary
from workbench.studies.planners import Course

POLICY = Policy(margin=0.0, near_margin=0.0, self_margin=0.0)


def quiet(done: float, note: str) -> None:
    """Nobody listens."""


@pytest.fixture(scope="module")
def course() -> Course:
    cell = read_cell("tx2_90")
    upright = replace(cell.arms[0], home=np.zeros(6))
    return Course(replace(cell, arms=(upright,)), 24, 0)


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    folder = tmp_path_factory.mktemp("problems")
    make_motion_problems(folder)
    return cases_of(read_motion_problems(folder), POLICY)


def test_a_peer_that_ends_at_once_is_an_input_error(course, monkeypatch):
    monkeypatch.setattr("workbench.extras.klampt.planning.sys.executable", "/bin/false")
    with pytest.raises(InputError, match="Klamp't did not finish"):
        attempts_by_klampt(course, planners=["sbl"] * 20_000, seconds=5.0, report=quiet)


def test_klampt_solves_the_same_course(course):
    pytest.importorskip("klampt")
    attempts = attempts_by_klampt(course, planners=["sbl"], seconds=5.0, report=quiet)
    assert [one.target for one in attempts] == [number for number, _ in course.goals]
    assert sum(one.tool_way is not None for one in attempts) >= 0.8 * len(attempts)


def test_klampt_sees_no_collision_at_the_ends_of_the_course(course):
    pytest.importorskip("klampt")
    ends = [q for _, q in course.goals]
    world, joints = course.world, course.arm.joints
    found = paths_by_klampt(world, joints, course.start, ends, ["sbl"], seconds=1e-6, report=quiet)
    assert [one.is_possible for one in found] == [True] * len(ends)


def test_without_klampt_the_comparison_says_so(cases, monkeypatch):
    monkeypatch.setattr("workbench.extras.klampt.planning.sys.executable", "/bin/false")
    with pytest.raises(InputError, match="Klamp't did not finish"):
        solve_by_klampt(cases, seconds=5.0, report=quiet)


def test_klampt_solves_the_same_problems(cases):
    pytest.importorskip("klampt")
    attempts = solve_by_klampt(cases, seconds=20.0, report=quiet)
    rows = summary(cases, attempts, KLAMPT)
    assert [(row["set"], row["solved"]) for row in rows] == [("free", 1), ("in_the_way", 1)]
    for case, made in zip([one for one in cases if not one.invalid], attempts, strict=True):
        assert np.allclose(made.path[0], case.start) and np.allclose(made.path[-1], case.goal)

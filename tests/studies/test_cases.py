"""A study's cases: the same results wherever they run, also when a worker is lost."""

import os
import signal
from pathlib import Path

import pytest

from workbench.model.errors import InputError
from workbench.studies.cases import run_cases


def square(case: int) -> int:
    return case * case


def square_or_die(task: tuple[int, str]) -> int:
    """The first process that gets to case 3 is killed."""
    case, folder = task
    if case == 3:
        try:
            (Path(folder) / "died").touch(exist_ok=False)
        except FileExistsError:
            return 9
        os.kill(os.getpid(), signal.SIGKILL)
    return case * case


def test_results_come_in_the_order_of_the_cases_from_any_number_of_workers():
    cases = list(range(12))
    assert run_cases(square, cases) == run_cases(square, cases, workers=2)


def test_a_lost_worker_loses_no_case(tmp_path):
    tasks = [(case, str(tmp_path)) for case in range(8)]
    assert run_cases(square_or_die, tasks, workers=2) == [case * case for case in range(8)]
    assert (tmp_path / "died").exists()


def test_progress_rises():
    told: list[float] = []
    run_cases(square, range(5), report=lambda done, note: told.append(done))
    assert told == sorted(told) and told[0] == 0.0


def test_a_cluster_that_is_not_there_is_an_error_that_says_so():
    with pytest.raises(InputError, match="nonsense"):
        run_cases(square, [1], scheduler="nonsense://here")

"""A job in a process that is started for it."""

import os
import threading
from pathlib import Path

import pytest
from job_listener import workers

from workbench.app.runtime.own_process import in_own_process
from workbench.model.errors import FileError, JobCancelled


@pytest.fixture(autouse=True)
def _tiny_work(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1])


def asked(cell, name, report=lambda done, note: None, given_up=None, **arguments):
    return in_own_process("tiny_work", name, cell, arguments, report, given_up or threading.Event())


def test_a_job_runs_in_a_process_of_its_own_that_is_gone_afterwards(cell):
    result = asked(cell, "echo", said="this")
    assert (result["cell"], result["said"]) == (cell.name, "this")
    assert result["process"] != os.getpid()
    assert not workers()


def test_who_waits_hears_how_far_it_is(cell):
    notes = []
    assert asked(cell, "count", lambda done, note: notes.append(note)) == 5
    assert notes[-1] == "step 4"


@pytest.mark.parametrize("job", ["wait_politely", "wait_stubbornly"])
def test_who_gives_up_does_not_wait_for_the_job(cell, job):
    given_up = threading.Event()
    with pytest.raises(JobCancelled):
        asked(cell, job, lambda done, note: given_up.set(), given_up)
    assert not workers()


def test_what_ended_the_job_is_raised(cell):
    with pytest.raises(FileError, match="is truncated"):
        asked(cell, "refuse")
    assert not workers()


def test_a_job_may_end_without_a_value(cell):
    assert asked(cell, "bring_nothing") is None
    assert not workers()

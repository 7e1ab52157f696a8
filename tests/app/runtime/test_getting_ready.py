"""What the worker does once before the first task: tasks wait for it, and it is not their time."""

import functools
from pathlib import Path

import pytest
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.readiness import NOTE
from workbench.journal.journal import Journal

HERE = Path(__file__).parents[1]


@pytest.fixture
def go(tmp_path, monkeypatch) -> Path:
    """The worker gets ready until that file is there."""
    monkeypatch.syspath_prepend(HERE)
    monkeypatch.setenv("TINY_GO", str(tmp_path / "go"))
    return tmp_path / "go"


@pytest.fixture
def bench(cell, tmp_path, go):
    machines = functools.partial(EffectRunner, module="slow_work")
    bench = Bench(cell, Journal(tmp_path / "session"), effects=machines)
    wait_until(lambda: bench.live.getting_ready is not None)
    yield bench
    bench.close()


def test_the_worker_tells_how_far_it_is_before_the_first_task(bench, go):
    told = bench.live.getting_ready
    assert (told.done, told.note) == (0.4, NOTE)
    go.touch()
    wait_until(lambda: bench.live.getting_ready is None)


def test_a_task_waits_says_for_what_and_runs_by_itself_with_its_own_clock(bench, go):
    number = bench.do(TakeScan(seed=5), "ada").number
    pressed = bench.live.started
    assert bench.live.progress_of(number) == (0.4, NOTE)
    go.touch()
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert state.phase is Phase.SCANNED
    assert bench.live.getting_ready is None
    assert bench.live.started > pressed
    assert bench.live.progress_of(number) == (0.5, "the scanner looks")


def test_a_task_that_waits_can_be_cancelled_and_what_it_waited_for_goes_on(bench, go, samples):
    bench.do(UseScan(samples.scan()), "ada")
    state = bench.do(FindParts(), "ada")
    bench.do(CancelJob(), "ada")
    ended = bench.wait(lambda newer: newer.number > state.number + 1, PATIENCE)
    assert str(ended.message) == "the search for parts was cancelled by ada"
    assert bench.live.getting_ready is not None
    bench.do(TakeScan(seed=5), "ada")
    go.touch()
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert state.scan is not None and len(state.scan.points) == 5000


def test_a_bench_is_closed_while_its_worker_gets_ready(bench):
    bench.close()
    assert bench.live.getting_ready is not None

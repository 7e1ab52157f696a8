"""What is compiled or loaded is on nobody's clock."""

import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest
from numba.core import event

from workbench.app.picking import judging
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.planners import clock
from workbench.planning.planners.clock import processor_time, working_time

LONG = 1000.0


class Wall:
    """A clock on the wall that tests move on."""

    def __init__(self, monkeypatch):
        self.seconds = 5.0
        # What was spent on a wall that is none must not be known to other tests.
        monkeypatch.setattr(clock, "_spent", clock._Spent())
        monkeypatch.setattr(
            clock, "time", SimpleNamespace(monotonic=self.now, thread_time=self.now)
        )

    def now(self):
        return self.seconds

    def compile(self):
        """As numba tells it: one function, and another that it calls."""
        with event.trigger_event("numba:compiler_lock"):
            with event.trigger_event("numba:compiler_lock"):
                self.seconds += LONG / 2
            self.seconds += LONG / 2


@pytest.fixture
def wall(monkeypatch):
    return Wall(monkeypatch)


def test_the_working_time_stands_still_while_something_is_compiled(wall):
    before = working_time()
    wall.seconds += 1
    wall.compile()
    wall.seconds += 2
    assert working_time() - before == pytest.approx(3)


def test_the_working_time_goes_on_while_another_thread_compiles(wall):
    before = working_time()
    other = threading.Thread(target=wall.compile)
    other.start()
    other.join()
    assert working_time() - before == pytest.approx(LONG)


def test_the_processor_time_stands_still_while_something_is_compiled(wall):
    before = processor_time()
    wall.seconds += 1
    wall.compile()
    assert processor_time() - before == pytest.approx(1)


def test_the_processor_time_stands_still_while_nothing_is_done():
    before, began = processor_time(), working_time()
    time.sleep(0.5)
    assert processor_time() - before < (working_time() - began) / 2


@pytest.mark.parametrize("is_compiling", [True, False])
def test_a_plan_is_late_by_what_it_does_and_not_by_what_is_compiled(
    wall, monkeypatch, is_compiling
):
    def slow(*args, **kwargs):
        if is_compiling:
            wall.compile()
        else:
            wall.seconds += LONG
        return quick(*args, **kwargs)

    quick = judging.resolve
    monkeypatch.setattr(judging, "resolve", slow)
    cell = read_cell("yumi")
    cell = replace(cell, policy=replace(cell.policy, seconds=1.0))
    result = plan_pick(cell, drop_parts(cell.parts[:1] * 2, cell.bin, seed=28), "scan")
    reasons = {one.verdict.reason for one in result.candidates}
    assert (Reason.OUT_OF_TIME in reasons) is not is_compiling
    assert (result.plan is not None) is is_compiling
    assert (result.seconds["resolve"] < LONG) is is_compiling

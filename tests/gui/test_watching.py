"""The server sees who has let a plan play to its end; skipping with the scrubber does not count."""

import time

import pytest

from workbench.app.bench import Bench
from workbench.app.commands import JobEnded, MakePlan, UseDetections, UseScan
from workbench.app.live import Live
from workbench.gui.server import serve
from workbench.journal.journal import Journal

PATIENCE = 120.0
"""How long [s] to wait for what must happen."""


class Nothing:
    """Effects that are not carried out."""

    def __init__(self, cell, do, now):
        self.live = Live()

    def run(self, effect):
        pass

    def close(self):
        pass


@pytest.fixture
def bench(cell, scan, detections, result, tmp_path):
    bench = Bench(cell, Journal(tmp_path / "session"), effects=Nothing)
    bench.do(UseScan(scan), "Anna")
    bench.do(UseDetections(detections), "Anna")
    number = bench.do(MakePlan(), "Anna").number
    bench.do(JobEnded(number, result), "worker")
    yield bench
    bench.close()


def test_a_plan_that_was_skipped_through_was_not_watched(bench):
    page = serve(bench, port=0, most_points=100)
    look = page._renderer._look
    end = bench.state.plan.cycle_seconds

    def played_from(start: float) -> None:
        time.sleep(0.5)
        look.change(time=start, is_playing=True, by=None)
        until = time.monotonic() + PATIENCE
        while look.now.is_playing:
            assert time.monotonic() < until
            time.sleep(0.05)

    played_from(end - 0.5)
    assert bench.state.watched == ()
    played_from(0.0)
    bench.wait(lambda state: state.watched != (), PATIENCE)
    assert bench.state.watched == ("operator",)
    page.close()

"""The server sees who has let a plan play to its end; skipping with the scrubber does not count."""

import time

import pytest

from workbench.app.commands import JobEnded, MakePlan, UseDetections, UseScan
from workbench.gui.server import serve

PATIENCE = 120.0
"""How long [s] to wait for what must happen."""


@pytest.fixture
def planned(bench, scan, detections, result):
    bench.do(UseScan(scan), "Anna")
    bench.do(UseDetections(detections), "Anna")
    number = bench.do(MakePlan(), "Anna").number
    bench.do(JobEnded(number, result), "worker")
    return bench


def test_a_plan_that_was_skipped_through_was_not_watched(planned):
    bench = planned
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

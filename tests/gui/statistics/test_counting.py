"""What is counted of a session, and of which part of it."""

import threading
from dataclasses import replace

from waiting import PATIENCE

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.review.history import History
from workbench.gui.statistics.counting import EntryCounter
from workbench.gui.statistics.panel import WHOLE, StatisticsPanel


def test_a_recorded_session_is_counted_whole_at_every_moment_and_says_so(
    bench, visitor, scan, detections, result, view_of
):
    bench.do(UseScan(scan), "Ada")
    bench.do(JobEnded(bench.do(FindParts(), "Ada").number, detections), "worker")
    bench.do(JobEnded(bench.do(MakePlan(), "Ada").number, result), "worker")
    history, done = History(bench._journal), threading.Event()
    history.go(0)
    counted = EntryCounter(history, done.set)
    counted.of(history.state)
    assert done.wait(PATIENCE)
    whole = counted.of(history.state)
    assert len(whole.cycles) == 1
    history.go(history.count)
    assert counted.of(history.state) is whole
    counted.close()
    view = view_of(history.state)
    panel = StatisticsPanel(visitor)
    panel.show(None, view)
    assert WHOLE not in panel._tables.content
    panel.show(None, replace(view, is_recorded=True))
    assert WHOLE in panel._tables.content

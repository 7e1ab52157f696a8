"""The demo waits for its tasks as long as it takes, says for what, and does not count it."""

import functools
import time

import pytest
from prepared_bench import Canned, make_results

from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.standing import moved_away
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.live import Live
from workbench.app.runtime.readiness import NOTE
from workbench.cli.serving import demo
from workbench.cli.serving.demo import Cycle
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """Its worker gets ready until somebody lets it go."""
    monkeypatch.setenv("TINY_GO", str(tmp_path / "go"))
    machines = functools.partial(EffectRunner, module="slow_work")
    bench = Bench(read_cell("yumi"), Journal(tmp_path / "session"), effects=machines)
    yield bench
    bench.close()


def test_the_demo_tells_what_it_waits_for_and_does_not_count_it_as_the_stage(bench, tmp_path):
    rows, let_go = [], []

    def report(done, note):
        if note == f"cycle 1, scan: {NOTE}" and done == 0.4 and not let_go:
            let_go.append(time.time())
            (tmp_path / "go").touch()

    state = Cycle(bench, 1, rows, report)._stage("scan", TakeScan(5, 2), Phase.SCANNED)
    assert len(state.scan.points) == 5000
    assert time.time() - rows[0].seconds >= let_go[0]


class LateReports(Canned):
    """Its robot is reported where it was in motion, to whoever looks the first few times."""

    def __init__(self, results, do, looks):
        arm = results.cell.arm("left")
        self._far = Live(joints=dict(zip(arm.joints, [q + 1.0 for q in arm.home], strict=True)))
        self._looks = looks
        super().__init__(results, do)

    @property
    def live(self):
        self._looks -= 1
        return self._far if self._looks >= 0 else Live()

    @live.setter
    def live(self, live):
        pass


def cycle_with(results, folder, looks):
    effects = functools.partial(LateReports, looks=looks)
    bench = Bench(results.cell, Journal(folder), effects=lambda cell, do, now: effects(results, do))
    try:
        plan, cycle = results.planned.plan, Cycle(bench, 1, [], lambda done, note: None)
        cycle._wait_while(lambda cell, joints: moved_away(cell, plan, joints))
        return bench.live.joints
    finally:
        bench.close()


def test_an_approval_waits_for_the_report_that_the_robot_has_come_back(tmp_path, monkeypatch):
    results = make_results()
    assert cycle_with(results, tmp_path / "late", looks=3) == {}
    # One that never comes back is not waited for without end: the approval says where it stands.
    monkeypatch.setattr(demo, "REPORTED", 0.0)
    assert cycle_with(results, tmp_path / "away", looks=1000) != {}

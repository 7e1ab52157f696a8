"""The demo waits for its tasks as long as it takes, says for what, and does not count it."""

import functools
import time

import pytest

from workbench.app.core.commands import TakeScan
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.readiness import NOTE
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

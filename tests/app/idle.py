"""Effects for a bench that records and decides, and moves nothing."""

import pytest
from waiting import PATIENCE

from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal


class Idle:
    """Effects that are not carried out."""

    def __init__(self, cell, do, now):
        self.live = Live()
        self.asked = []

    def run(self, effect):
        pass

    def ask(self, question):
        self.asked.append(question)

    def close(self):
        pass


class Noting:
    """Effects that are noted as `jobs`, for a test that answers them itself."""

    def __init__(self, cell, do, now):
        self.live, self.jobs, self.cell = Live(), [], cell

    def run(self, effect):
        self.jobs.append(effect)

    def close(self):
        pass


@pytest.fixture
def idle(tmp_path):
    """A bench of the YuMi that begins nothing: a worker takes seconds to start."""
    bench = Bench(read_cell("yumi"), Journal(tmp_path / "session"), effects=Idle)
    yield bench
    bench.close()


def done(bench):
    """The state once no task runs."""
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert state.job is None
    return state

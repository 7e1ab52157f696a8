"""The page while what tasks wait for is done once."""

from functools import partial

import pytest
from playwright.sync_api import expect

from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal


@pytest.fixture
def forked():
    """Nothing is: this worker is told by its environment what it waits for."""


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """Its worker gets ready until somebody lets it go."""
    monkeypatch.setenv("TINY_GO", str(tmp_path / "go"))
    machines = partial(EffectRunner, module="slow_work")
    bench = Bench(read_cell("yumi"), Journal(tmp_path / "session"), effects=machines)
    yield bench
    bench.close()


def test_the_page_says_that_it_gets_ready_and_what_is_pressed_runs_afterwards(
    bench, screen, tmp_path, wait
):
    screen.wait_for("Getting ready, once, about a minute")
    screen.wait_for("40%")
    screen.tab("Cell")
    screen.button("Jog").wait_for()
    expect(screen.button("Jog")).to_be_disabled()
    screen.tab("Cycle")
    screen.press("Scan")
    screen.wait_for("then: ")
    screen.shoot("getting_ready")
    assert bench.state.job is not None and bench.state.scan is None
    (tmp_path / "go").touch()
    wait(lambda: bench.state.scan is not None, "the scan")
    screen.page.get_by_text("Getting ready").first.wait_for(state="detached")
    screen.tab("Cell")
    wait(lambda: not screen.button("Jog").is_disabled(), "the button")

"""The page does not compile beside the worker: its threads wait and load, its drawing goes on."""

import threading
from types import SimpleNamespace

import pytest
from numba.core import event
from waiting import PATIENCE

from workbench.app.runtime.live import Live
from workbench.app.runtime.worker import GettingReady
from workbench.gui.page.patience import Patience


@pytest.fixture
def bench():
    return SimpleNamespace(live=Live(getting_ready=GettingReady(0.4, "getting ready")))


@pytest.fixture
def patience(bench):
    made = Patience(bench)
    yield made
    made.close()


def compiling(name):
    """A thread that needs something compiled, and what tells that it has it."""
    has_it = threading.Event()

    def work():
        with event.trigger_event("numba:compiler_lock"):
            has_it.set()

    threading.Thread(target=work, name=name, daemon=True).start()
    return has_it


def test_a_thread_of_the_page_waits_until_the_worker_is_ready(bench, patience):
    has_it = compiling("reach")
    assert not has_it.wait(0.5)
    bench.live = Live()
    assert has_it.wait(PATIENCE)


def test_the_drawing_does_not_wait(patience):
    assert compiling("renderer").wait(PATIENCE)


def test_nobody_waits_when_the_page_is_closed(patience):
    has_it = compiling("reach")
    patience.close()
    patience.close()
    assert has_it.wait(PATIENCE)
    assert compiling("coverage").wait(PATIENCE)

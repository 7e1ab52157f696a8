"""While the journal hangs in an append, stops still act and the state can still be read."""

import threading

import pytest
from hung_disk import HungDisk
from noted import Noted, approved
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Sent, Stop
from workbench.app.core.effects import Send, StopSending
from workbench.app.core.people import Role
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.errors import NotAllowed
from workbench.model.release import Receipt


@pytest.fixture
def journal(tmp_path):
    return Journal(tmp_path / "session")


@pytest.fixture
def noted():
    return []


@pytest.fixture
def bench(cell, journal, noted):
    made = Bench(cell, journal, effects=lambda *with_: noted.append(Noted(*with_)) or noted[-1])
    yield made
    made.close()


@pytest.fixture
def disk(journal, monkeypatch):
    return HungDisk(journal, monkeypatch)


def in_thread(function, *arguments):
    thread = threading.Thread(target=function, args=arguments, daemon=True)
    thread.start()
    return thread


def ends(function):
    """Whether a call ends while the disk hangs."""
    done = threading.Event()
    in_thread(lambda: (function(), done.set()))
    return done.wait(PATIENCE)


def receipt(bench):
    return Sent(Receipt(bench.state.number, "right", "start", "startR#", 1, 4))


def test_the_first_step_of_an_end_stops_the_robot_and_returns(bench, noted, samples, disk):
    bench.do(SendPlan(approved(bench, samples)), "ada")
    with disk.during(bench.do, receipt(bench), "robot link"):
        assert ends(bench.stop_sending)
        assert isinstance(noted[0].ran[-1], StopSending)


def test_a_sending_whose_record_hangs_while_all_ends_is_stopped(bench, noted, samples, disk):
    with disk.during(bench.do, SendPlan(approved(bench, samples)), "ada"):
        assert ends(bench.stop_sending)
    kinds = [type(effect) for effect in noted[0].ran]
    assert kinds[kinds.index(Send) :] == [Send, StopSending]


def test_a_stop_that_comes_while_the_sending_is_recorded_stops_it(bench, noted, samples, disk):
    digest, answers = approved(bench, samples), []
    with disk.during(bench.do, SendPlan(digest), "ada"):
        thread = in_thread(lambda: answers.append(bench.do(Stop(), "bob", Role.OPERATOR)))
        # It waits for what is being recorded, and is not refused.
        thread.join(0.2)
        assert thread.is_alive()
    thread.join(PATIENCE)
    assert answers[0].stopped_by == "bob"
    kinds = [type(effect) for effect in noted[0].ran]
    assert kinds[kinds.index(Send) :][:2] == [Send, StopSending]


def test_the_end_that_a_stop_brings_is_recorded_behind_it(bench, noted, samples, disk, monkeypatch):
    bench.do(SendPlan(approved(bench, samples)), "ada")
    run, ends_, answers = noted[0].run, [], []

    def ending(effect):
        run(effect)
        if isinstance(effect, StopSending) and not ends_:
            ends_.append(in_thread(bench.do, LinkEnded("stopped"), "robot link"))

    monkeypatch.setattr(noted[0], "run", ending)
    with disk.during(bench.do, receipt(bench), "robot link"):
        thread = in_thread(lambda: answers.append(bench.do(Stop(), "bob", Role.OPERATOR)))
        wait_until(lambda: ends_)
    thread.join(PATIENCE)
    ends_[0].join(PATIENCE)
    assert answers[0].stopped_by == "bob"
    assert bench.state.phase is not Phase.SENDING


def test_who_may_not_stop_stops_nothing_while_the_disk_hangs(bench, noted, samples, disk):
    bench.do(SendPlan(approved(bench, samples)), "ada")
    with disk.during(bench.do, receipt(bench), "robot link"):
        with pytest.raises(NotAllowed):
            bench.do(Stop(), "vic", Role.VIEWER)
        assert not any(isinstance(effect, StopSending) for effect in noted[0].ran)


def test_state_and_head_are_read_and_observers_come_and_go(bench, journal, samples, disk):
    approved(bench, samples)
    before = bench.head
    with disk.during(bench.do, TakeScan(seed=3), "ada"):
        assert ends(lambda: bench.subscribe(print)())
        assert ends(lambda: bench.head)
        assert ends(lambda: bench.wait(lambda state: False, 0.01))
        assert bench.head == before
        assert bench.state.phase is Phase.APPROVED
    wait_until(lambda: bench.state.job is not None)
    assert bench.head == (journal.count, journal.head)

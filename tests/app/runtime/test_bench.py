"""The bench takes commands from many threads, records each before it acts, and tells everybody."""

import dataclasses
import logging
import queue
import sqlite3
import threading
from contextlib import closing

import pytest
from noted import Clock, Noted, approved
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Sent, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StartJob, StopSending
from workbench.app.core.state import Phase
from workbench.app.picking import facts
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.journal import files
from workbench.journal.journal import Journal
from workbench.model.cell import PlanOverrides
from workbench.model.errors import CommandRefused, JournalError
from workbench.model.release import Receipt


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def journal(tmp_path):
    return Journal(tmp_path / "session", patience=0.05)


@pytest.fixture
def noted():
    return []


@pytest.fixture
def bench(cell, journal, clock, noted):
    def effects(cell, do, now):
        noted.append(Noted(cell, do, now))
        return noted[-1]

    made = Bench(cell, journal, now=clock, effects=effects)
    yield made
    made.close()


def test_a_command_is_recorded_published_and_set_in_motion(bench, journal, noted):
    state = bench.do(TakeScan(seed=3), "ada")
    assert bench.state is state
    assert journal.count == state.number == 2
    (effect,) = noted[0].ran
    assert isinstance(effect, StartJob)
    assert (effect.number, effect.name) == (2, "scan")


def test_a_refused_command_leaves_no_trace(bench, journal, noted):
    before = bench.state
    for command in (FindParts(), TakeScan(seed=object()), TakeScan(parts=float("nan"))):
        with pytest.raises(CommandRefused):
            bench.do(command, "ada")
    assert bench.state is before
    assert journal.count == before.number
    assert noted[0].ran == []


def test_a_planner_that_is_not_installed_is_refused_and_yet_computed_again(
    bench, journal, samples, monkeypatch
):
    scan = samples.scan()
    bench.do(UseScan(scan), "ada")
    bench.do(UseDetections(samples.detections()), "ada")
    foreign = MakePlan(overrides=PlanOverrides(planner="foreign"))
    with pytest.raises(CommandRefused, match=r"no planner 'foreign'; known: .*rrtconnect"):
        bench.do(foreign, "ada")
    with monkeypatch.context() as installed:
        installed.setattr(facts, "planner_named", lambda name: None)
        state = bench.do(foreign, "ada")
        bench.do(JobEnded(state.number, samples.planned(state.scene_digest)), "worker")
    *_, (_, last) = replay(journal, bench.cell)
    assert last.phase is Phase.PLANNED


def test_what_cannot_be_recorded_is_not_done(bench, journal, noted, samples):
    digest = approved(bench, samples)
    before, ran = bench.state, list(noted[0].ran)
    other = sqlite3.connect(journal.folder / "journal.sqlite", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    with pytest.raises(CommandRefused, match="nothing was done"):
        bench.do(SendPlan(digest), "ada")
    assert bench.state is before
    assert noted[0].ran == ran
    other.execute("ROLLBACK")
    other.close()
    assert bench.do(SendPlan(digest), "ada").phase is Phase.SENDING


def test_a_stop_is_carried_out_even_when_it_cannot_be_recorded(bench, journal, noted, samples):
    bench.do(SendPlan(approved(bench, samples)), "ada")
    other = sqlite3.connect(journal.folder / "journal.sqlite", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    with pytest.raises(CommandRefused, match="the stop is carried out"):
        bench.do(Stop(), "ada")
    other.close()
    assert isinstance(noted[0].ran[-1], StopSending)
    assert bench.state.phase is Phase.SENDING


def test_a_stop_is_carried_out_while_another_command_hangs_at_the_disk(
    bench, journal, noted, samples, monkeypatch
):
    bench.do(SendPlan(approved(bench, samples)), "ada")
    hangs, may_end = threading.Event(), threading.Event()
    append = journal.append

    def slow(*words):
        hangs.set()
        assert may_end.wait(PATIENCE)
        return append(*words)

    monkeypatch.setattr(journal, "append", slow)
    receipt = Sent(Receipt(bench.state.number, "right", "start", "startR#", 1, 4))
    threads = [threading.Thread(target=bench.do, args=(receipt, "robot link"))]
    threads[0].start()
    try:
        assert hangs.wait(PATIENCE)
        threads.append(threading.Thread(target=bench.do, args=(Stop(), "ada")))
        threads[1].start()
        wait_until(lambda: isinstance(noted[0].ran[-1], StopSending))
        assert threads[1].is_alive(), "it waits until it is on record"
    finally:
        may_end.set()
        for thread in threads:
            thread.join(PATIENCE)


def test_a_stop_waits_for_no_scan_on_its_way_to_the_disk(bench, journal, samples, monkeypatch):
    digest = approved(bench, samples)
    writing, may_end = threading.Event(), threading.Event()
    write = files._write_durably

    def slow(path, content):
        writing.set()
        assert may_end.wait(PATIENCE)
        write(path, content)

    monkeypatch.setattr(files, "_write_durably", slow)
    scan = samples.scan(seed=7, points=5000)

    def use():
        # By then something is sent.
        with pytest.raises(CommandRefused):
            bench.do(UseScan(scan), "ada")

    thread = threading.Thread(target=use)
    thread.start()
    try:
        assert writing.wait(PATIENCE)
        bench.do(SendPlan(digest), "ada")
        assert bench.do(Stop(), "ada").phase is Phase.SENDING
    finally:
        may_end.set()
        thread.join()
    assert journal.verify() == ()


def test_an_approval_is_on_the_disk_before_anything_is_sent(cell, journal, clock, samples):
    recorded = []

    class Looking(Noted):
        def run(self, effect):
            if isinstance(effect, Send):
                recorded.extend(row.kind for row in journal.entries())

    bench = Bench(cell, journal, now=clock, effects=Looking)
    bench.do(SendPlan(approved(bench, samples)), "ada")
    assert recorded[-2:] == ["Approve", "SendPlan"]
    bench.close()


def test_time_comes_from_the_clock_given(bench, clock, samples):
    digest = approved(bench, samples)
    assert bench.state.approval.at == clock.now
    clock.now += 301
    with pytest.raises(CommandRefused, match="has run out"):
        bench.do(SendPlan(digest), "ada")


def test_no_command_of_many_threads_is_lost(bench, journal, samples):
    scans = [samples.scan(seed, points=3) for seed in range(8)]
    numbers = queue.Queue()

    def ask(scan):
        for _ in range(200):
            numbers.put(bench.do(UseScan(scan), "ada").number)

    threads = [threading.Thread(target=ask, args=(scan,)) for scan in scans]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(numbers.queue) == list(range(2, 1602))
    assert bench.state.number == journal.count == 1601
    assert journal.verify() == ()
    *_, (_, last) = replay(journal, bench.cell)
    assert (last.number, last.scan.digest) == (1601, bench.state.scan.digest)


def test_an_observer_sees_every_change_when_it_keeps_up(bench, samples):
    seen = queue.Queue()
    first = bench.state
    bench.subscribe(lambda old, new: seen.put((old, new)))
    previous = first
    for seed in range(3):
        state = bench.do(UseScan(samples.scan(seed)), "ada")
        old, new = seen.get(timeout=PATIENCE)
        assert (old, new) == (previous, state)
        previous = state


def test_a_slow_observer_delays_nobody_and_next_sees_the_newest(bench, samples):
    entered, go_on, seen = threading.Event(), threading.Event(), queue.Queue()

    def slow(old, new):
        entered.set()
        go_on.wait(PATIENCE)
        seen.put((old.number, new.number))

    bench.subscribe(slow)
    bench.do(UseScan(samples.scan()), "ada")
    entered.wait(PATIENCE)
    for seed in range(20):
        bench.do(UseScan(samples.scan(seed)), "ada")
    go_on.set()
    assert seen.get(timeout=PATIENCE) == (1, 2)
    assert seen.get(timeout=PATIENCE) == (2, 22)


def test_an_observer_that_fails_is_logged_and_told_again(bench, samples, caplog):
    seen = queue.Queue()

    def broken(old, new):
        seen.put(new.number)
        raise ValueError("a broken page")

    bench.subscribe(broken)
    with caplog.at_level(logging.ERROR):
        for seed in range(2):
            number = bench.do(UseScan(samples.scan(seed)), "ada").number
            assert seen.get(timeout=PATIENCE) == number
    assert "a broken page" in caplog.text


def test_an_observer_may_give_commands(bench, samples):
    def follow(old, new):
        if new.phase is Phase.SCANNED and new.job is None:
            bench.do(FindParts(), "ada")

    bench.subscribe(follow)
    bench.do(UseScan(samples.scan()), "ada")
    assert bench.wait(lambda state: state.job is not None, PATIENCE).job.name == "localize"


def test_nobody_is_told_after_unsubscribing(bench, samples):
    told, kept = queue.Queue(), queue.Queue()
    unsubscribe = bench.subscribe(lambda old, new: told.put(new))
    bench.subscribe(lambda old, new: kept.put(new))
    unsubscribe()
    unsubscribe()
    bench.do(UseScan(samples.scan()), "ada")
    kept.get(timeout=PATIENCE)
    assert told.empty()


def test_waiting_gives_up_with_the_state_as_it_is(bench):
    assert bench.wait(lambda state: state.phase is Phase.DONE, 0.01) is bench.state


def test_a_closed_bench_refuses_people_and_ends_its_effects(cell, journal, clock, noted):
    bench = Bench(
        cell, journal, now=clock, effects=lambda *with_: noted.append(Noted(*with_)) or noted[-1]
    )
    bench.close()
    bench.close()
    assert noted[0].closed
    with pytest.raises(CommandRefused, match="is closing"):
        bench.do(TakeScan(), "ada")


def test_stopping_comes_first_and_the_rest_of_the_end_later(bench, noted):
    bench.stop_sending()
    assert [type(effect) for effect in noted[0].ran] == [StopSending]
    assert not noted[0].closed
    with pytest.raises(CommandRefused, match="is closing"):
        bench.do(TakeScan(), "ada")
    bench.close()
    assert noted[0].closed
    bench.stop_sending()
    assert len(noted[0].ran) == 1


def test_a_session_that_somebody_writes_to_is_not_gone_on_with(cell, journal, clock, samples):
    bench = Bench(cell, journal, now=clock, effects=Noted)
    approved(bench, samples)
    count, other = journal.count, Journal(journal.folder)
    with pytest.raises(JournalError, match="is written to by process"):
        Bench(cell, other, now=clock, effects=Noted)
    other.close()
    # Nothing was written into the middle of what goes on there.
    assert bench.do(SendPlan(bench.state.plan.digest), "ada").number == count + 1
    bench.close()


def test_a_session_goes_on_where_it_ended(cell, journal, clock, samples):
    bench = Bench(cell, journal, now=clock, effects=Noted)
    digest = approved(bench, samples)
    bench.close()
    again = Bench(cell, Journal(journal.folder), now=clock, effects=Noted)
    assert again.state.phase is Phase.PLANNED
    assert again.state.plan.digest == digest
    again.do(WatchPlan(digest), "ada")
    again.do(Approve(digest), "ada")
    assert again.do(SendPlan(digest), "ada").phase is Phase.SENDING
    again.close()


def test_a_sending_that_was_interrupted_is_a_fault_in_the_continued_session(
    cell, journal, clock, samples
):
    bench = Bench(cell, journal, now=clock, effects=Noted)
    bench.do(SendPlan(approved(bench, samples)), "ada")
    bench.do(Sent(Receipt(clock.now, "right", "start", "startR#", 1, 4)), "robot link")
    journal.close()
    again = Bench(cell, Journal(journal.folder), now=clock, effects=Noted)
    assert again.state.phase is Phase.FAULT
    assert "ended while sending" in str(again.state.fault)
    assert len(again.state.receipts) == 1
    again.close()


def test_a_job_that_was_interrupted_has_failed_in_the_continued_session(cell, journal, clock):
    bench = Bench(cell, journal, now=clock, effects=Noted)
    bench.do(TakeScan(), "ada")
    bench.close()
    again = Bench(cell, Journal(journal.folder), now=clock, effects=Noted)
    assert again.state.job is None
    assert (
        str(again.state.message) == "the scan failed: the workbench ended before the task was done"
    )
    again.close()


def test_a_scan_by_a_scanner_on_an_arm_that_was_interrupted_has_failed_too(journal, clock):
    cell = read_cell(find("robots", "yumi") / "on_arm.toml")
    carrier = cell.scanner.on_arm

    def at_view(cell, do, now):
        noted = Noted(cell, do, now)
        stands = {arm.name: arm.home for arm in cell.arms} | {carrier.arm: carrier.view.q}
        noted.live = Live(joints=cell.joint_values(stands))
        return noted

    bench = Bench(cell, journal, now=clock, effects=at_view)
    bench.do(TakeScan(), "ada")
    bench.close()
    again = Bench(cell, Journal(journal.folder), now=clock, effects=at_view)
    assert again.state.job is None and again.state.scan is None
    again.close()


def test_a_session_of_another_cell_is_not_continued(cell, journal, clock, make_cell):
    Bench(cell, journal, now=clock, effects=Noted).close()
    again = Journal(journal.folder)
    with closing(again), pytest.raises(JournalError, match="ran with the cell"):
        Bench(make_cell("other"), again, now=clock, effects=Noted)


def test_people_cannot_report_for_machines(bench, samples):
    bench.do(SendPlan(approved(bench, samples)), "ada")
    with pytest.raises(CommandRefused, match="reported by a machine"):
        bench.do(LinkEnded(parts_placed=1), "ada")
    with pytest.raises(dataclasses.FrozenInstanceError):
        bench.state.phase = Phase.DONE

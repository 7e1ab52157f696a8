"""The bench with a real worker process, and a simulated controller spoken to over TCP."""

import dataclasses
import logging
import multiprocessing
import os
import signal
import socket
import sqlite3
import threading
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from controller_ports import at
from full_disk import FullDisk
from idle import Idle
from ports import free_port
from waiting import PATIENCE, wait_until

from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.cell.part_edits import DropDraft
from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import SendPlan, Stop
from workbench.app.core.state import Phase
from workbench.app.picking import facts
from workbench.app.records.replay import replay
from workbench.app.runtime import effect_runner, record_retries
from workbench.app.runtime.bench import Bench
from workbench.devices.abb_simulated.serve_requests import RequestClient
from workbench.journal.journal import Journal
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused

HERE = Path(__file__).parents[1]
MESSAGES = ["startR#", "inR#*30.00*", "outR#*60.00*", "stopR#"]


def test_a_scan_comes_from_the_worker_with_progress(bench):
    number = bench.do(TakeScan(seed=5), "ada").number
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert (state.phase, len(state.scan.points)) == (Phase.SCANNED, 5000)
    assert not state.scan.points.flags.writeable
    live = bench.live
    assert (live.job, live.done, live.note) == (number, 0.5, "the scanner looks")
    assert live.started > 0


def test_a_failed_job_leaves_its_sentence(bench, samples):
    bench.do(UseDetections(samples.detections()), "ada")
    bench.do(MakePlan("right"), "ada")
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert str(state.message) == "the planning failed: no plan by strategy right"


def test_a_cancelled_job_is_gone_at_once_and_its_end_is_recorded(bench, samples):
    bench.do(UseScan(samples.scan()), "ada")
    bench.do(FindParts(), "ada")
    wait_until(lambda: bench.live.note == "waiting")
    state = bench.do(CancelJob(), "ada")
    assert state.job is None
    ended = bench.wait(lambda newer: newer.number > state.number, PATIENCE)
    assert (ended.phase, str(ended.message)) == (
        Phase.SCANNED,
        "the search for parts was cancelled by ada",
    )


def test_the_next_job_runs_after_a_cancel(bench, samples):
    bench.do(UseScan(samples.scan()), "ada")
    bench.do(FindParts(), "ada")
    bench.do(CancelJob(), "ada")
    bench.do(TakeScan(), "ada")
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert len(state.scan.points) == 5000


def test_a_result_that_cannot_be_recorded_ends_the_job_with_an_error(bench, samples, caplog):
    bench.do(UseScan(samples.scan()), "ada")
    bench.do(FindParts(seed=13), "ada")
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert "internal error, see the log: TypeError: no canonical form for complex" in str(
        state.message
    )
    assert "Traceback" in caplog.text


def test_an_approved_plan_goes_out_and_the_parts_are_counted(cell, controller, bench_at):
    simulated = controller(speed=200)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    wait_until(lambda: bench.live.joints)
    assert bench.live.joints == {"joint_1": 0.0}
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    state = bench.wait(lambda state: state.phase is not Phase.SENDING, PATIENCE)
    assert (state.phase, state.fault, state.parts_placed) == (Phase.DONE, "", 1)
    assert [receipt.sent for receipt in state.receipts] == MESSAGES
    wait_until(lambda: np.isclose(bench.live.joints["joint_1"], np.deg2rad(60)))
    wait_until(lambda: str(bench.live.robot) == "stands")
    kinds = [entry.command.__class__.__name__ for entry, _ in replay(bench._journal, bench.cell)]
    assert kinds[-7:] == ["Approve", "SendPlan", *["Sent"] * 4, "LinkEnded"]


def test_what_a_controller_reported_last_is_known_when_it_reports_no_more(
    cell, controller, bench_at
):
    simulated = controller(speed=200)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    wait_until(lambda: bench.live.joints)
    simulated.stop()
    wait_until(lambda: not bench.live.joints)
    assert bench.live.last_joints == {"joint_1": 0.0}
    assert bench.live.reported_at > 0


def test_a_stop_closes_the_link_in_the_middle_of_a_motion(cell, controller, bench_at):
    simulated = controller(speed=0.001)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    bench.wait(lambda state: len(state.receipts) == 2, PATIENCE)
    wait_until(lambda: str(bench.live.robot) == "moves arm right")
    bench.do(Stop(), "bob")
    state = bench.wait(lambda state: state.phase is Phase.FAULT, PATIENCE)
    assert str(state.fault) == "sending was stopped before message 3 of 4"
    assert len(state.receipts) == 2
    wait_until(lambda: str(bench.live.robot).startswith("fault"))
    assert bench.do(AcknowledgeFault(), "ada").phase is Phase.IDLE


def test_a_controller_that_is_not_there_is_a_fault_with_its_address(cell, bench_at):
    port = free_port()
    bench = bench_at(at(cell, port, port))
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    state = bench.wait(lambda state: state.phase is Phase.FAULT, PATIENCE)
    assert f"no controller answers at 127.0.0.1:{port}" in str(state.fault)
    assert state.receipts == ()
    assert (bench.live.joints, bench.live.robot) == ({}, None)


def test_a_controller_that_talks_nonsense_is_a_fault(cell, bench_at):
    with socket.create_server(("127.0.0.1", 0)) as server:
        bench = bench_at(at(cell, server.getsockname()[1], 1))
        bench.do(SendPlan(bench.state.plan.digest), "ada")
        client, _ = server.accept()
        with client:
            client.sendall(b"hello")
            state = bench.wait(lambda state: state.phase is Phase.FAULT, PATIENCE)
    assert "the controller said b'hello'" in str(state.fault)


def test_what_the_controller_says_of_a_fault_is_part_of_it(cell, controller, bench_at):
    (joint,) = cell.robot.joints
    narrow = dataclasses.replace(joint, lower=-0.1, upper=0.1)
    strict = dataclasses.replace(cell.robot, joints=(narrow,))
    simulated = controller(speed=200, of=dataclasses.replace(cell, robot=strict))
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    wait_until(lambda: bench.live.joints)
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    state = bench.wait(lambda state: state.phase is Phase.FAULT, PATIENCE)
    says = (
        "closed the link at message 3 of 4; the controller reports: protocol error: joint joint_1"
    )
    assert says in str(state.fault)
    assert "30.00 deg is outside" in str(state.fault)
    assert [receipt.sent for receipt in state.receipts] == MESSAGES[:2]


def test_sending_ends_when_it_can_no_longer_be_recorded(
    cell, controller, bench_at, caplog, monkeypatch
):
    # Under way to the first place until nothing can be recorded any more.
    is_locked = threading.Event()
    monkeypatch.setattr(RequestClient, "_move", lambda *_: is_locked.wait(PATIENCE))
    simulated = controller(speed=1)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    bench.wait(lambda state: len(state.receipts) == 2, PATIENCE)
    other = sqlite3.connect(bench._journal.folder / "journal.sqlite", isolation_level=None)
    with caplog.at_level(logging.ERROR):
        other.execute("BEGIN IMMEDIATE")
        is_locked.set()
        wait_until(lambda: "is not recorded" in caplog.text)
        other.execute("ROLLBACK")
    other.close()
    # The third message is out, its record is missing.
    wait_until(lambda: simulated.state()["received"] == 3)
    # Nobody has to ask for it: the end is on record as soon as it can be.
    state = bench.wait(lambda state: state.phase is Phase.FAULT, PATIENCE)
    assert "database is locked" in str(state.fault)
    assert simulated.state()["received"] == 3, "nothing followed it"


def test_closing_while_sending_stops_the_robot_and_records_it(cell, controller, bench_at):
    simulated = controller(speed=0.001)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    bench.wait(lambda state: len(state.receipts) == 2, PATIENCE)
    bench.close()
    assert bench.state.phase is Phase.FAULT
    again = Journal(bench._journal.folder)
    *_, (last, state) = replay(again, bench.cell)
    assert (
        str(state.fault) == str(last.command.fault) == "sending was stopped before message 3 of 4"
    )
    again.close()


def test_a_stop_does_not_wait_for_a_journal_that_is_read(cell, controller, bench_at):
    simulated = controller(speed=0.001)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    bench.wait(lambda state: len(state.receipts) == 2, PATIENCE)
    rows = bench._journal.entries()
    next(rows)
    bench.do(Stop(), "ada")
    assert bench.wait(lambda state: state.phase is Phase.FAULT, PATIENCE).fault
    rows.close()


def test_a_worker_killed_in_a_job_ends_the_job_and_the_next_one_runs(bench, samples):
    bench.do(UseScan(samples.scan()), "ada")
    bench.do(FindParts(), "ada")
    wait_until(lambda: bench.live.note == "waiting")
    (worker,) = (p for p in multiprocessing.active_children() if p.name == "workbench worker")
    os.kill(worker.pid, signal.SIGKILL)
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert "the worker process ended (SIGKILL) during the search for parts" in str(state.message)
    bench.do(TakeScan(), "ada")
    assert bench.wait(lambda state: state.job is None, PATIENCE).phase is Phase.SCANNED


def test_a_plan_is_not_sent_twice_even_by_two_people_at_once(cell, controller, bench_at):
    simulated = controller(speed=200)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    digest = bench.state.plan.digest
    outcomes = []

    def ask(actor):
        try:
            bench.do(SendPlan(digest), actor)
            outcomes.append("sent")
        except CommandRefused:
            outcomes.append("refused")

    people = [threading.Thread(target=ask, args=(name,)) for name in ("ada", "bob", "eve")]
    for person in people:
        person.start()
    for person in people:
        person.join()
    bench.wait(lambda state: state.phase is Phase.DONE, PATIENCE)
    assert sorted(outcomes) == ["refused", "refused", "sent"]
    assert simulated.state()["received"] == 4


def test_what_a_search_discarded_is_shown_and_not_recorded(cell, tmp_path, machines, samples):
    bench = Bench(cell, Journal(tmp_path / "session"), effects=machines)
    try:
        bench.do(UseScan(samples.scan()), "ada")
        bench.do(FindParts(seed=14), "ada")
        state = bench.wait(lambda state: state.detections is not None, PATIENCE)
        findings = bench.live.findings
        assert findings is not None and findings.detections is state.detections
        assert [str(one.words) for one in findings.rejected] == [
            "reaches into another part: part-1"
        ]
    finally:
        bench.close()
    with closing(Journal(tmp_path / "session")) as journal:
        *_, (_, last) = replay(journal, cell)
    assert digest_of(last.detections) == digest_of(findings.detections)


def test_films_of_emptied_piles_are_shown_and_not_recorded(
    cell, tmp_path, machines, samples, monkeypatch
):
    # The cell of these tests is no place to pile up parts in: that is asked before the worker is.
    monkeypatch.setattr(facts, "check_pile", lambda cell, count: None)
    bench = Bench(cell, Journal(tmp_path / "session"), effects=machines)
    try:
        bench.do(TryEmptying(count=1, piles=1), "ada")
        state = bench.wait(lambda state: state.emptying is not None, PATIENCE)
        films = bench.live.films
        assert films is not None and films.emptying is state.emptying
        assert [film.task for film in films.films] == [one.task for one in state.emptying.plain]
    finally:
        bench.close()
    with closing(Journal(tmp_path / "session")) as journal:
        *_, (_, last) = replay(journal, cell)
    assert last.emptying == films.emptying
    again = Bench(cell, Journal(tmp_path / "session"), effects=Idle)
    assert again.live.films is None and again.state.emptying == films.emptying
    again.close()


def test_a_disk_that_is_slow_to_take_a_draft_holds_nobody_up(bench, cell, monkeypatch):
    may_go, waits = threading.Event(), threading.Event()

    def slow(*arguments):
        waits.set()
        assert may_go.wait(PATIENCE)
        return {}

    monkeypatch.setattr(effect_runner, "part_folders", slow)
    monkeypatch.setattr(bench._effects, "_cell_file", Path("cell.toml"))
    bench.do(DropDraft(cell.parts[0].name), "ada")
    assert waits.wait(PATIENCE)
    # The bench takes commands meanwhile.
    assert bench.do(WantThreshold(0.1), "ada").wanted_threshold == 0.1
    may_go.set()


@pytest.fixture
def disk(monkeypatch):
    monkeypatch.setattr(record_retries, "RETRY", 0.01)
    return FullDisk(monkeypatch)


def test_a_task_that_ends_while_the_disk_is_full_is_taken_when_it_is_not(bench, samples, disk):
    bench.do(UseScan(samples.scan()), "ada")
    disk.fill(after=1)
    bench.do(FindParts(seed=14), "ada")
    wait_until(lambda: disk.tries > 2)
    assert bench.state.job is not None
    assert "no space left on device" in str(bench.live.unrecorded)
    disk.free()
    bench.wait(lambda state: state.job is None, PATIENCE)
    assert bench.state.detections is not None
    wait_until(lambda: bench.live.unrecorded is None)


def test_a_sending_that_breaks_off_since_the_disk_is_full_is_a_fault_on_record(
    cell, controller, bench_at, disk
):
    simulated = controller(speed=200)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    disk.fill(after=2)
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    wait_until(lambda: disk.tries > 3)
    assert bench.state.phase is Phase.SENDING
    assert "no space left on device" in str(bench.live.unrecorded)
    disk.free()
    state = bench.wait(lambda state: state.phase is Phase.FAULT, PATIENCE)
    assert "no space left on device" in str(state.fault)
    wait_until(lambda: bench.live.unrecorded is None)


def test_a_bench_that_closes_waits_for_no_disk(cell, controller, bench_at, disk):
    simulated = controller(speed=200)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    disk.fill(after=2)
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    wait_until(lambda: disk.tries > 3)
    bench.close()
    disk.free()

"""An approval counts in the start of the bench that it was given to, and nowhere else.

What is tried here moved a robot twice with one approval: over real TCP, with `abb-socket`, whose
controller knows no tickets and runs whatever it is sent.
"""

import contextlib
import dataclasses
import shutil
import socket
import threading
import time
from pathlib import Path

import pytest
from idle import Idle
from waiting import PATIENCE

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.cycle.sending import SendPlan, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StopSending
from workbench.app.core.state import Phase
from workbench.app.records.replay import replay
from workbench.app.records.session_archive import export_session, import_session
from workbench.app.records.sessions import cell_of
from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.app.runtime.robot_link import LinkRunner
from workbench.cli.main import main
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused, JournalError
from workbench.plugins.robot_link import Simulation, controller_by

ROOT = Path(__file__).resolve().parents[3]
MESSAGES = ["startR#", "inR#*30.00*", "outR#*60.00*", "stopR#"]
"""Of one run of the plan."""


def at(cell, controller):
    address = controller_by("abb-socket", port=controller.port, state_port=controller.state_port)
    return dataclasses.replace(cell, controller=address)


class Linked(Idle):
    """The real link to the robot, and no worker."""

    def __init__(self, cell, do, now):
        super().__init__(cell, do, now)
        self.live = Live()
        self._robot = LinkRunner(cell, do, now, lambda **changes: None)

    def run(self, effect):
        if isinstance(effect, Send):
            self._robot.send(effect.plan, effect.approval)
        elif isinstance(effect, StopSending):
            self._robot.stop()

    def close(self):
        self._robot.close()


@pytest.fixture
def controller(cell):
    simulated = SimulatedController(cell, Simulation(speed=1000))
    thread = threading.Thread(target=simulated.run)
    thread.start()
    yield simulated
    simulated.stop()
    thread.join()


@pytest.fixture
def bench_in(cell, controller):
    """Opens a folder, as a start of the server does."""
    opened = []

    def open_in(folder, **options):
        reached = at(cell, controller)
        options = {"effects": Linked, **options}
        opened.append(Journal(folder))
        opened.append(Bench(options.pop("cell", reached), opened[-1], **options))
        return opened[-1]

    yield open_in
    for one in reversed(opened):
        one.close()


def approved(bench, samples):
    """The digest of a plan that a person has let out in this bench."""
    bench.do(UseScan(samples.scan()), "ada")
    bench.do(UseDetections(samples.detections()), "ada")
    state = bench.do(MakePlan(), "ada")
    result = samples.planned(state.scene_digest)
    bench.do(JobEnded(state.number, result), "worker")
    say_yes(bench)
    return result.plan.digest


def say_yes(bench):
    digest = bench.state.plan.digest
    bench.do(WatchPlan(digest), "ada")
    assert bench.do(Approve(digest), "ada").phase is Phase.APPROVED


def sent(bench, digest):
    bench.do(SendPlan(digest), "ada")
    return bench.wait(lambda state: state.phase is not Phase.SENDING, PATIENCE)


def refused(bench, digest):
    with pytest.raises(CommandRefused) as caught:
        bench.do(SendPlan(digest), "ada")
    return str(caught.value)


def has_no_word(bench):
    state = bench.state
    return state.approval is None and state.votes == () and state.watched == ()


def exported(bench, tmp_path):
    export_session(bench._journal, tmp_path / "taken.zip", None)
    return import_session(tmp_path / "taken.zip", tmp_path / "elsewhere")


def copied(bench, tmp_path):
    return Path(shutil.copytree(bench.folder, tmp_path / "copy"))


def restored(bench, tmp_path):
    home = tmp_path / "home"
    for name in ("robots/tx2_90", "parts/puck"):
        shutil.copytree(ROOT / name, home / name)
    shutil.copytree(bench.folder, home / "sessions" / "one")
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(home)
        assert main(["backup", str(tmp_path / "kept.zip"), "--with-sessions"]) == 0
        shutil.rmtree(home / "sessions")
        assert main(["restore", str(tmp_path / "kept.zip")]) == 0
    return home / "sessions" / "one"


@pytest.mark.parametrize("taken", [exported, copied, restored])
def test_an_approval_is_not_taken_along(tmp_path, samples, controller, bench_in, taken):
    original = bench_in(tmp_path / "original")
    digest = approved(original, samples)
    # The original goes on meanwhile.
    folder = taken(original, tmp_path)
    assert sent(original, digest).phase is Phase.DONE
    assert controller.state()["received"] == len(MESSAGES)
    copy = bench_in(folder)
    assert copy.state.plan.digest == digest
    assert has_no_word(copy)
    assert "approved" in refused(copy, digest)
    copy.do(WatchPlan(digest), "ada")
    assert "approved" in refused(copy, digest)
    assert controller.state()["received"] == len(MESSAGES), "nothing has moved twice"
    # A person who stands there and says so moves it: the copy is a session like any other.
    say_yes(copy)
    assert sent(copy, digest).phase is Phase.DONE
    assert controller.state()["received"] == 2 * len(MESSAGES)


def test_words_of_some_are_not_taken_along(tmp_path, cell, samples, controller, bench_in):
    two = dataclasses.replace(at(cell, controller), approvers=2)
    original = bench_in(tmp_path / "original", cell=two)
    original.do(UseScan(samples.scan()), "ada")
    original.do(UseDetections(samples.detections()), "ada")
    state = original.do(MakePlan(), "ada")
    result = samples.planned(state.scene_digest)
    original.do(JobEnded(state.number, result), "worker")
    for name in ("ada", "bob"):
        original.do(WatchPlan(result.plan.digest), name)
    original.do(Approve(result.plan.digest), "ada")
    copy = bench_in(copied(original, tmp_path), cell=two)
    copy.do(WatchPlan(result.plan.digest), "bob")
    assert copy.do(Approve(result.plan.digest), "bob").phase is Phase.PLANNED
    assert "approved" in refused(copy, result.plan.digest)


def test_a_session_opened_again_is_on_record_and_begins_without_a_word(
    tmp_path, samples, controller, bench_in
):
    bench = bench_in(tmp_path / "one")
    digest = approved(bench, samples)
    bench.close()
    again = bench_in(tmp_path / "one")
    assert has_no_word(again) and again.state.phase is Phase.PLANNED
    assert "opened again" in str(again.state.message)
    assert "approved" in refused(again, digest)
    *_, last = again.entries()
    assert last.kind == "Opened"
    *_, (entry, state) = replay(again._journal, again.cell)
    assert (entry.actor, state.approval) == ("session start", None)
    assert controller.state()["received"] == 0


def test_a_session_that_has_only_begun_has_nothing_to_end(tmp_path, bench_in):
    bench_in(tmp_path / "one").close()
    assert [row.kind for row in bench_in(tmp_path / "one").entries()] == ["Session"]


def test_a_folder_is_opened_once_and_the_first_one_goes_on(tmp_path, samples, bench_in):
    first = bench_in(tmp_path / "one")
    digest = approved(first, samples)
    count = first.state.number
    with pytest.raises(JournalError, match="is written to by process"):
        bench_in(tmp_path / "one")
    assert first.state.number == count
    assert sent(first, digest).phase is Phase.DONE


def test_nothing_is_sent_when_that_cannot_be_recorded(tmp_path, samples, controller, bench_in):
    bench = bench_in(tmp_path / "one")
    digest = approved(bench, samples)
    bench._journal.close()
    assert "nothing was done" in refused(bench, digest)
    assert bench.state.phase is Phase.APPROVED
    assert controller.state()["received"] == 0


def test_that_it_was_sent_is_on_record_before_the_first_message(
    tmp_path, samples, controller, bench_in
):
    known = []

    class Looking(Idle):
        def run(self, effect):
            if isinstance(effect, Send):
                journal = Journal(tmp_path / "one")
                known.append([row.kind for row in journal.entries()][-1])
                journal.close()

    bench = bench_in(tmp_path / "one", effects=Looking)
    bench.do(SendPlan(approved(bench, samples)), "ada")
    assert known == ["SendPlan"]
    # Also when the process dies right then: whoever opens it again finds a fault, no approval.
    copy = bench_in(copied(bench, tmp_path))
    assert copy.state.phase is Phase.FAULT and has_no_word(copy)


def nobody_listens(bench, controller):
    port = controller.port
    controller.stop()
    with socket.socket() as probe:
        while probe.connect_ex(("127.0.0.1", port)) == 0:
            probe.close()
            time.sleep(0.01)


def is_stopped(bench, controller):
    def stop(old, new):
        if new.phase is Phase.SENDING:
            with contextlib.suppress(CommandRefused):
                bench.do(Stop(), "bob")

    bench.subscribe(stop)


@pytest.mark.parametrize("ends", [nobody_listens, is_stopped, lambda bench, controller: None])
def test_a_spent_approval_lets_nothing_out_again(tmp_path, samples, controller, bench_in, ends):
    bench = bench_in(tmp_path / "one")
    digest = approved(bench, samples)
    approval = bench.state.approval
    ends(bench, controller)
    state = sent(bench, digest)
    assert state.phase in (Phase.FAULT, Phase.DONE)
    received = controller.state()["received"]
    refused(bench, digest)
    with pytest.raises(CommandRefused):
        bench.do(Approve(digest), "ada")
    if state.phase is Phase.FAULT:
        bench.do(AcknowledgeFault(), "ada")
        refused(bench, digest)
        assert has_no_word(bench)
    # Whoever gets past the rules meets the link, which remembers.
    bench._effects.run(Send(state.plan, approval))
    bench._effects.close()
    assert controller.state()["received"] == received


def test_a_clock_that_is_set_back_keeps_no_approval_alive(tmp_path, samples, controller, bench_in):
    clock, steady = [1_000_000.0], [50.0]
    bench = bench_in(tmp_path / "one", now=lambda: clock[0], steady=lambda: steady[0])
    digest = approved(bench, samples)
    minutes = bench.state.cell.policy.approval_minutes
    steady[0] += minutes * 60.0
    clock[0] += 1.0
    assert "set back" in refused(bench, digest)
    clock[0] -= 3600.0
    assert "has run out" in refused(bench, digest)
    assert controller.state()["received"] == 0
    # Said anew it counts anew.
    clock[0] += 3600.0
    say_yes(bench)
    assert sent(bench, digest).phase is Phase.DONE


def test_a_session_from_before_there_was_such_an_entry_goes_on_and_is_looked_at(tmp_path):
    folder = Path(shutil.copytree(ROOT / "sessions" / "example", tmp_path / "example"))
    journal = Journal(folder)
    assert "Opened" not in [row.kind for row in journal.entries()]
    recorded = History(journal)
    bench = Bench(cell_of(journal), Journal(folder), effects=Idle)
    assert bench.state.phase is recorded.state.phase
    assert has_no_word(bench)
    assert History(bench._journal).count == recorded.count + 1
    bench.close()
    journal.close()

"""What was written can be read again, computed again, and by people without this program."""

import dataclasses
import hashlib
import json
import sqlite3
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from idle import Idle

from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.command import Entry
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ForgetAvoided, ReportPick
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.scanning import TakeScan, UseObservations, UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Sent, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.decide import decide
from workbench.app.core.session import WriteNote
from workbench.app.core.state import Phase, State
from workbench.app.records.forms import large_arrays, restore_value
from workbench.app.records.record import command_form, entry_of, entry_record
from workbench.app.records.replay import replay
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.cell import Arm, PlanOverrides
from workbench.model.digest import canonical, digest_of
from workbench.model.errors import CommandRefused, FileError, JobCancelled, JournalError
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.message import plain
from workbench.model.part import PartPlace
from workbench.model.prediction import EmptiedPile, Emptying, LeftPart, PileTask
from workbench.model.release import Receipt
from workbench.model.scan import Detection, Scan, SearchOverrides

NOW = 1_700_000_000.0


def emptied(cell) -> Emptying:
    left = (LeftPart("part-2", "no path", plain("no way was found"), ""),)
    pile = EmptiedPile(
        PileTask(cell.name, "peg", 2, 7, "scan"), 2, 1, (0, 1, 0), 0, 0, 2, 5, 7.5, left,
        (0.25, 0.5), (("propose", 0.1), ("prove", 0.2)), 1.5, outcomes=("", "crooked"),
    )  # fmt: skip
    return Emptying(cell.digest, (pile,))


def commands(samples):
    scan = samples.scan(points=3000)
    planned = samples.planned(scan.digest)
    return (
        TakeScan(3, 4),
        UseScan(scan),
        UseScan(replace(scan, colours=np.arange(9000).reshape(3000, 3) % 251)),
        FindParts(5),
        UseDetections(samples.detections()),
        MakePlan("right", 0.25, 6),
        WantThreshold(0.15),
        WatchPlan("d" * 64),
        Approve("d" * 64),
        SendPlan("d" * 64),
        Stop(),
        ReportPick(1, False, "slipped"),
        ForgetAvoided(),
        WriteNote("pads of the left gripper changed"),
        CancelJob(),
        AcknowledgeFault(),
        JobEnded(1, scan),
        JobEnded(2, samples.detections()),
        JobEnded(3, planned),
        JobEnded(4, samples.refused()),
        TryEmptying(("peg",), 5, 2, 7, "scan", ("lifts", "bin")),
        JobEnded(7, emptied(samples.cell)),
        JobEnded(5, FileError("scan.ply", "is truncated")),
        JobEnded(6, JobCancelled("cancelled")),
        Sent(Receipt(NOW, "right", "in", "inR#*1.00*", 2, 9)),
        LinkEnded("the controller closed the connection", 1),
    )


def run(journal: Journal, cell, sequence) -> State:
    """Decide and write, as the bench does, without its threads."""
    state = State(cell, number=journal.count)
    for number, command in enumerate(sequence):
        machine = isinstance(command, JobEnded | Sent | LinkEnded)
        actor = ("worker" if isinstance(command, JobEnded) else "robot link") if machine else "ada"
        entry = Entry(state.number + 1, NOW + number, actor, command)
        state, _ = decide(state, entry)
        record = entry_record(entry, command_form(command), state)
        journal.append(record.kind, record.body, record.files)
    return state


def cycle(samples):
    scan = samples.scan(points=3000)
    planned = samples.planned(scan.digest)
    digest = planned.plan.digest
    return (
        TakeScan(),
        JobEnded(2, scan),
        FindParts(),
        JobEnded(4, samples.detections()),
        MakePlan(),
        JobEnded(6, planned),
        WatchPlan(digest),
        Approve(digest),
        SendPlan(digest),
        Sent(Receipt(NOW, "right", "start", "startR#", 1, 2)),
        LinkEnded("", 1),
    )


@pytest.fixture
def journal(tmp_path, cell):
    opened = new_session(tmp_path, cell, NOW)
    yield opened
    opened.close()


def test_every_command_comes_back_as_it_was(samples):
    for command in commands(samples):
        form = command_form(command)
        entry = Entry(9, NOW, "ada", command)
        record = entry_record(entry, form, State(samples.cell))
        again, _ = entry_of(9, record.kind, record.body, record.files.__getitem__)
        assert (again.number, again.at, again.actor) == (9, NOW, "ada")
        assert type(again.command) is type(command)
        assert command_form(again.command).form == form.form or isinstance(
            command.result, FileError
        )
        assert command_form(again.command).files == form.files


def test_commands_on_record_by_their_first_names_are_read():
    """A command and three fields were renamed in 0.2.0; sessions keep their first names."""

    def read(kind, form):
        body = {"at": 1.0, "actor": "ada", "role": "engineer", "command": form, "after": {}}
        return entry_of(2, kind, json.dumps(body).encode(), None)[0].command

    planned = MakePlan(overrides=PlanOverrides(planner="sbl"))
    form = json.loads(command_form(planned).form)
    assert form["wishes"]["planner"] == "sbl" and "overrides" not in form
    assert canonical(read("MakePlan", form)) == form
    sought = json.loads(command_form(FindParts(3, SearchOverrides(0.5, 0.1))).form)
    assert sought["wishes"]["detail"] == 0.5 and canonical(read("FindParts", sought)) == sought
    left = {"sightings": [], "says": "none is left"}
    assert isinstance(read("UseSightings", left), UseObservations)


def test_values_come_back_with_their_digests_and_protected(samples):
    scan = samples.scan(points=3000)
    planned = samples.planned(scan.digest)
    for value in (scan, planned.plan, planned.proof):
        form = json.loads(json.dumps(canonical(value)))
        again = restore_value(type(value), form, large_arrays(value).__getitem__)
        assert again.digest == value.digest
    arm = replace(samples.cell.arms[0], part_places=(PartPlace(pose_from_rpy((0.3, 0.2, 0.1))),))
    places = restore_value(
        Arm, json.loads(json.dumps(canonical(arm))), large_arrays(arm).__getitem__
    )
    assert digest_of(places) == digest_of(arm) != digest_of(samples.cell.arms[0])
    again = restore_value(Scan, canonical(scan), large_arrays(scan).__getitem__)
    assert not again.points.flags.writeable
    assert again.pixels.dtype == scan.pixels.dtype


@given(
    score=st.floats(0, 1) | st.integers(0, 1),
    gap=st.none() | st.floats(allow_nan=False),
    place=st.tuples(*[st.floats(-10, 10)] * 3),
    angles=st.tuples(*[st.floats(-3, 3)] * 3),
    roll_known=st.booleans(),
)
def test_detections_of_any_kind_keep_their_digest(score, gap, place, angles, roll_known):
    T = pin.SE3(pin.rpy.rpyToMatrix(*angles), np.array(place))
    detection = Detection("peg", T, score, 1.0, gap, roll_known=roll_known)
    form = json.loads(json.dumps(canonical(detection)))
    assert digest_of(restore_value(Detection, form, {}.__getitem__)) == digest_of(detection)


def test_a_form_with_missing_or_unknown_fields_is_not_taken(samples):
    (detection,) = samples.detections()
    form = canonical(detection)
    for wrong in (form | {"weight": 1}, {k: form[k] for k in form if k != "part"}):
        with pytest.raises(ValueError, match="were expected"):
            restore_value(Detection, wrong, {}.__getitem__)


def test_a_session_computed_again_goes_through_the_same_states(journal, cell, samples):
    last = run(journal, cell, cycle(samples))
    history = list(replay(journal, cell))
    assert [str(state.phase) for _, state in history] == [
        "idle",
        "scanned",
        "scanned",
        "localized",
        "localized",
        "planned",
        "planned",
        "approved",
        "sending",
        "sending",
        "done",
    ]
    end = history[-1][1]
    assert end.phase is last.phase is Phase.DONE
    for field in ("scan", "plan", "proof", "approval"):
        assert getattr(end, field).digest == getattr(last, field).digest
    assert digest_of(end.detections) == digest_of(last.detections)
    assert journal.verify() == ()


def test_what_became_of_piles_is_on_record_and_comes_back(journal, cell, samples):
    found = emptied(cell)
    run(journal, cell, (TryEmptying(), JobEnded(2, found), *cycle_after(samples)))
    end = list(replay(journal, cell))[-1][1]
    assert end.emptying == found and end.phase is Phase.SCANNED


def cycle_after(samples):
    return (TakeScan(), JobEnded(4, samples.scan(points=3000)))


def test_people_can_read_scan_plan_proof_and_approval_from_the_folder(journal, cell, samples):
    last = run(journal, cell, cycle(samples))
    connection = sqlite3.connect(journal.folder / "journal.sqlite")
    bodies = {
        number: json.loads(body)
        for number, body in connection.execute("SELECT number, body FROM entries")
    }
    connection.close()
    points = bodies[3]["command"]["result"]["scan"]["points"]
    content = (journal.folder / "files" / points["sha256"][:2] / points["sha256"]).read_bytes()
    read = np.frombuffer(content, points["type"]).reshape(points["shape"])
    assert np.array_equal(read, last.scan.points)
    plan = bodies[7]["command"]["result"]["plan"]["plan"]
    unsigned = {key: plan[key] for key in plan if key != "seconds"}
    text = json.dumps(unsigned, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    assert hashlib.sha256(text.encode()).hexdigest() == last.plan.digest
    assert bodies[7]["command"]["result"]["plan"]["proof"]["plan_digest"] == last.plan.digest
    assert bodies[9]["approval"]["actor"] == "ada"
    assert bodies[9]["approval"]["plan_digest"] == last.plan.digest


def test_a_session_of_another_cell_is_not_computed_with_this_one(journal, samples, make_cell):
    run(journal, samples.cell, cycle(samples))
    with pytest.raises(JournalError, match="not with other as it is now"):
        list(replay(journal, make_cell("other")))


def test_an_entry_that_the_rules_refuse_ends_the_replay(journal, cell, samples):
    *most, _ = cycle(samples)[:9]
    state = run(journal, cell, most)
    approval = dataclasses.replace(state.approval, plan_digest="0" * 64)
    entry = Entry(10, NOW + 9, "ada", SendPlan(state.plan.digest))
    forged = dataclasses.replace(state, phase=Phase.SENDING, approval=approval)
    late = dataclasses.replace(entry, at=NOW + 1000)
    record = entry_record(late, command_form(entry.command), forged)
    journal.append(record.kind, record.body, record.files)
    with pytest.raises(JournalError, match=r"entry 10 \(SendPlan\) was not in order.*run out"):
        list(replay(journal, cell))


def test_a_session_is_continued_that_stricter_rules_would_refuse(
    journal, cell, samples, monkeypatch
):
    run(journal, cell, cycle(samples)[:4])

    def refuse(command, state, asked):
        raise CommandRefused("a rule that is newer than this session")

    monkeypatch.setattr(UseScan, "check", refuse)
    monkeypatch.setattr(TakeScan, "check", refuse)
    with pytest.raises(JournalError, match="was not in order: a rule that is newer"):
        list(replay(journal, cell))
    bench = Bench(cell, journal, effects=Idle)
    assert bench.state.scan is not None
    bench.close()


def test_a_state_other_than_recorded_ends_the_replay(journal, cell, samples):
    state = State(cell, number=1)
    entry = Entry(2, NOW, "ada", UseScan(samples.scan()))
    record = entry_record(entry, command_form(entry.command), state)
    journal.append(record.kind, record.body, record.files)
    with pytest.raises(JournalError, match="led to phase 'idle', computed again it is 'scanned'"):
        list(replay(journal, cell))


@pytest.mark.parametrize(
    ("kind", "body"),
    [
        ("Dance", b"{}"),
        ("Stop", b"not json"),
        ("Stop", b"[]"),
        ("Stop", b'{"at": 1, "actor": "ada"}'),
        ("TakeScan", b'{"at": 1, "actor": "ada", "command": {"seeds": 1}, "after": {}}'),
        ("UseScan", b'{"at": 1, "actor": "ada", "command": {}, "after": {}}'),
        (
            "JobEnded",
            b'{"at": 1, "actor": "a", "command": {"number": 1, "result": {}}, "after": {}}',
        ),
        ("JobEnded", b'{"at": 1, "actor": "a", "command": 7, "after": {}}'),
        (
            "JobEnded",
            b'{"at": 1, "actor": "a", "command": {"number": 1, "result": 7}, "after": {}}',
        ),
        ("Stop", b"[" * 100_000),
    ],
)
def test_a_record_that_nobody_can_read_is_named_by_its_number(kind, body):
    with pytest.raises(JournalError, match="entry 5"):
        entry_of(5, kind, body, {}.__getitem__)


def test_a_journal_that_does_not_begin_a_session_is_refused(tmp_path, cell):
    journal = Journal(tmp_path / "session")
    with pytest.raises(JournalError, match="is empty"):
        list(replay(journal, cell))
    journal.append("note", b"hello")
    with pytest.raises(JournalError, match="not the beginning of a session"):
        list(replay(journal, cell))
    journal.close()


def test_sessions_begun_in_the_same_second_get_folders_of_their_own(tmp_path, cell):
    journals = [new_session(tmp_path, cell, NOW) for _ in range(3)]
    assert [journal.folder.name for journal in journals] == [
        "20231114-221320-sample",
        "20231114-221320-sample-2",
        "20231114-221320-sample-3",
    ]
    for journal in journals:
        journal.close()


def test_a_session_where_no_folder_can_be_made_is_refused(tmp_path, cell):
    (tmp_path / "file").write_text("")
    with pytest.raises(JournalError, match="cannot be made"):
        new_session(tmp_path / "file", cell, NOW)

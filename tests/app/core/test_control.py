"""Roles and control: who may give a command, and how control passes from one to the other."""

import dataclasses
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from idle import Idle

from workbench.app.core.cell.changes import SaveCell
from workbench.app.core.command import Entry
from workbench.app.core.commands import COMMANDS
from workbench.app.core.control import (
    MOST_ASKING,
    AskForControl,
    DenyControl,
    GiveControl,
    ReleaseControl,
    TakeControl,
)
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import Stop
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.people import FRONT_DOOR, MACHINES, POSES_FOLDER, Role
from workbench.app.core.rights import lacks_right
from workbench.app.core.state import Phase, State
from workbench.app.records.record import command_form, entry_of, entry_record
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused, JobCancelled, JournalError, NotAllowed

NOW = 1_000_000.0
PEOPLE = {"Ada": Role.ENGINEER, "Bob": Role.OPERATOR, "Cleo": Role.OPERATOR, "Vic": Role.VIEWER}


def after(state: State, command, actor: str, role: Role | None = None) -> State:
    """The state after a command that the rules let pass."""
    role = role or PEOPLE.get(actor, Role.ENGINEER)
    check_allowed(state, command, actor, NOW, role=role)
    return decide(state, Entry(state.number + 1, NOW, actor, command, role=role))[0]


def refusal(state: State, command, actor: str, role: Role | None = None) -> str:
    with pytest.raises(CommandRefused) as refused:
        after(state, command, actor, role)
    return str(refused.value)


@pytest.fixture
def idle(cell) -> State:
    return State(cell)


@pytest.fixture
def held(idle) -> State:
    """Bob is in control."""
    return after(idle, TakeControl(), "Bob")


@pytest.mark.parametrize("command", [c for c in COMMANDS if not c.right.by_machine])
def test_a_viewer_may_give_no_command_and_an_engineer_every_one(idle, command):
    assert "you are a viewer" in str(lacks_right(idle, command, "Vic", Role.VIEWER))
    assert lacks_right(idle, command, "Ada", Role.ENGINEER) is None


def test_a_role_that_is_not_enough_is_refused_with_a_sentence(idle):
    said = refusal(idle, SaveCell(""), "Bob")
    assert said == "saving the cell is for engineers; you are an operator"
    assert refusal(idle, TakeScan(), "Vic") == "a scan is for operators; you are a viewer"


def test_whoever_acts_from_the_shell_may_do_everything_and_needs_no_control(idle):
    check_allowed(idle, TakeScan(), "ada", NOW)
    check_allowed(idle, SaveCell(""), "ada", NOW)


def test_while_somebody_is_in_control_others_may_only_do_what_cannot_wait(held):
    sending = dataclasses.replace(held, phase=Phase.SENDING)
    assert refusal(held, TakeScan(), "Cleo") == "Bob is in control; ask for control first"
    assert refusal(held, TakeScan(), "Ada") == "Bob is in control; ask for control first"
    assert after(held, TakeScan(), "Bob").job is not None
    after(sending, Stop(), "Cleo")
    assert "in control" not in refusal(held, Approve("x"), "Cleo")
    busy = after(held, TakeScan(), "Bob")
    assert "in control" in refusal(busy, CancelJob(), "Cleo")


def test_machines_need_no_control(held, samples):
    state = after(held, UseDetections(samples.detections()), POSES_FOLDER)
    busy = after(state, TakeScan(), "Bob")
    assert after(busy, JobEnded(busy.job.number, JobCancelled("x")), "worker").job is None


def test_control_that_nobody_has_is_taken_and_that_of_another_only_by_an_engineer(held):
    assert held.control == "Bob"
    assert str(held.message) == "Bob takes control"
    assert refusal(held, TakeControl(), "Cleo") == "Bob is in control; ask for control first"
    assert refusal(held, TakeControl(), "Bob") == "you are in control already"
    over = after(held, TakeControl(), "Ada")
    assert (over.control, str(over.message)) == ("Ada", "Ada takes control over from Bob")


def test_control_is_handed_over_to_somebody_who_has_asked(held):
    assert "'Cleo' has not asked for it; nobody has" in refusal(held, GiveControl("Cleo"), "Bob")
    asked = after(held, AskForControl(), "Cleo")
    assert asked.asking == ("Cleo",)
    assert str(asked.message) == "Cleo asks Bob for control"
    assert "you have asked already" in refusal(asked, AskForControl(), "Cleo")
    given = after(asked, GiveControl("Cleo"), "Bob")
    assert (given.control, given.asking) == ("Cleo", ())


def test_who_is_in_control_may_keep_it(held):
    kept = after(after(held, AskForControl(), "Cleo"), DenyControl("Cleo"), "Bob")
    assert (kept.control, kept.asking) == ("Bob", ())
    assert str(kept.message) == "Bob keeps control, Cleo has asked"


def test_nobody_hands_over_what_is_not_theirs(held):
    asked = after(held, AskForControl(), "Cleo")
    assert "Bob is in control" in refusal(asked, GiveControl("Cleo"), "Ada")
    assert "Bob is in control" in refusal(asked, ReleaseControl(), "Ada")
    free = dataclasses.replace(asked, control="")
    assert "nobody is in control" in refusal(free, AskForControl(), "Cleo")


def test_only_so_many_people_wait_for_an_answer(held):
    crowd = dataclasses.replace(held, asking=tuple(f"p{n}" for n in range(MOST_ASKING)))
    assert "wait until one of them" in refusal(crowd, AskForControl(), "Cleo")


def test_control_ends_when_it_is_given_back_or_its_person_has_gone(held):
    assert after(held, ReleaseControl(), "Bob").control == ""
    gone = after(held, ReleaseControl("Bob"), FRONT_DOOR)
    assert (gone.control, str(gone.message)) == ("", "Bob left: nobody is in control")
    over = after(held, TakeControl(), "Ada")
    assert "'Bob' is not in control, Ada is" in refusal(over, ReleaseControl("Bob"), FRONT_DOOR)
    assert "'Ada' has to give control back" in refusal(held, ReleaseControl("Ada"), "Bob")


def test_a_new_scan_leaves_control_where_it_is(held, samples):
    state = after(held, UseDetections(samples.detections()), "Bob")
    assert state.control == "Bob"


names = st.sampled_from(sorted(PEOPLE))
words = st.one_of(
    st.builds(AskForControl),
    st.builds(TakeControl),
    st.builds(GiveControl, names),
    st.builds(DenyControl, names),
    st.builds(ReleaseControl, st.one_of(st.just(""), names)),
)


@given(st.lists(st.tuples(st.sampled_from([*sorted(PEOPLE), FRONT_DOOR]), words), max_size=40))
def test_no_sequence_of_words_takes_control_from_a_person_but_an_engineer_does(cell, said):
    state = State(cell)
    for actor, word in said:
        try:
            new = after(state, word, actor)
        except CommandRefused as error:
            assert len(str(error)) > 10
            continue
        if new.control != state.control and state.control:
            is_theirs = actor == state.control or actor == FRONT_DOOR
            assert is_theirs or PEOPLE[actor] is Role.ENGINEER
        assert PEOPLE.get(new.control, Role.OPERATOR).covers(Role.OPERATOR)
        assert new.control not in MACHINES and new.control not in new.asking
        assert all(PEOPLE[name].covers(Role.OPERATOR) for name in new.asking)
        state = new


def test_a_session_from_before_there_were_roles_is_that_of_engineers(cell):
    entry = Entry(2, NOW, "Ada", TakeScan(), role=Role.OPERATOR)
    record = entry_record(entry, command_form(entry.command), State(cell))
    body = json.loads(record.body)
    assert body["role"] == "operator"
    read, _ = entry_of(2, record.kind, record.body, lambda digest: b"")
    assert read.role is Role.OPERATOR
    del body["role"]
    read, _ = entry_of(2, record.kind, json.dumps(body).encode(), lambda digest: b"")
    assert read.role is Role.ENGINEER
    body["role"] = "owner"
    with pytest.raises(JournalError, match="owner"):
        entry_of(2, record.kind, json.dumps(body).encode(), lambda digest: b"")


def test_what_a_role_may_never_do_is_told_apart_from_what_is_not_in_order_now(idle, held):
    with pytest.raises(NotAllowed):
        after(idle, SaveCell(""), "Bob")
    for state, command, actor in ((idle, Stop(), "Bob"), (held, TakeScan(), "Cleo")):
        with pytest.raises(CommandRefused) as refused:
            after(state, command, actor)
        assert not isinstance(refused.value, NotAllowed)


def test_role_and_control_are_recorded_and_asked_again(cell, tmp_path):
    bench = Bench(cell, Journal(tmp_path), now=lambda: NOW, effects=Idle)
    bench.do(TakeControl(), "Bob", Role.OPERATOR)
    with pytest.raises(CommandRefused, match="Bob is in control"):
        bench.do(TakeScan(), "Ada", Role.ENGINEER)
    bench.do(TakeScan(), "Bob", Role.OPERATOR)
    bench.close()
    journal = Journal(tmp_path)
    entries = [entry for entry, _ in replay(journal, cell)]
    assert [(entry.actor, entry.role) for entry in entries] == [("Bob", Role.OPERATOR)] * 2
    again = Bench(cell, journal, now=lambda: NOW, effects=Idle)
    assert again.state.control == "Bob", "a bench that begins again has not forgotten"
    again.close()

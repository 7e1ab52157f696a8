"""Every start is on record with what ran; what has changed is acknowledged before a sending."""

import os
from contextlib import closing
from dataclasses import replace

import pytest
from idle import Idle
from line import Line, make_plan

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import SESSION_START, Role
from workbench.app.core.rights import obstacle
from workbench.app.core.session import AcknowledgeChanges, Started
from workbench.app.core.state import Phase
from workbench.app.provenance.gathering import inventory
from workbench.app.records import starts
from workbench.app.records.replay import replay
from workbench.app.records.sessions import new_session
from workbench.app.records.starts import start, start_before
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused

AT = 1_700_000_000.0


@pytest.fixture
def ran(cell):
    return inventory(cell, {"Anna": "engineer"})


def another(ran):
    first, *rest = ran.distributions
    return replace(ran, distributions=(replace(first, version="99"), *rest))


def served(root, cell, ran, before=None, at=AT):
    return Bench(cell, new_session(root, cell, at), effects=Idle, start=start(ran, before))


def planned(samples, line):
    make_plan(samples, line)
    digest = line.state.plan.digest
    line.do(WatchPlan(digest))
    line.do(Approve(digest))
    return digest


def test_a_first_start_has_nothing_to_acknowledge_and_every_entry_names_what_ran(
    tmp_path, cell, ran
):
    with closing(served(tmp_path, cell, ran)) as bench:
        assert bench.state.changed == ()
        bench.do(TakeScan(), "ada")
        folder = bench.folder
    with closing(Journal(folder)) as journal:
        *_, last = replay(journal, cell)
        assert f'"ran":"{ran.digest}"'.encode() in journal.last().body
    assert last[1].ran.digest == ran.digest


def test_what_has_changed_since_another_session_waits_for_an_engineer(tmp_path, cell, ran):
    served(tmp_path, cell, ran).close()
    now = another(ran)
    with closing(served(tmp_path, cell, now, start_before(tmp_path, cell.name))) as bench:
        assert f"{ran.distributions[0].name} {ran.distributions[0].version} is now 99" in str(
            bench.state.message
        )
        with pytest.raises(CommandRefused, match="for engineers"):
            bench.do(AcknowledgeChanges(now.digest), "otto", Role.OPERATOR)
        with pytest.raises(CommandRefused, match="look at the current changes"):
            bench.do(AcknowledgeChanges(ran.digest), "ada")
        bench.do(AcknowledgeChanges(now.digest), "ada")
        assert bench.state.changed == ()
        with pytest.raises(CommandRefused, match="nothing has changed"):
            bench.do(AcknowledgeChanges(now.digest), "ada")


def test_nothing_is_sent_before_it_is_acknowledged(samples, cell, ran):
    line = Line(cell)
    line.do(Started(another(ran), ("numpy 1 is 2 now",), "session x"), SESSION_START)
    digest = planned(samples, line)
    assert line.state.approval.ran == another(ran).digest
    assert "numpy 1 is 2 now" in str(obstacle(line.state, SendPlan))
    with pytest.raises(CommandRefused, match="an engineer acknowledges: this has changed"):
        line.do(SendPlan(digest))
    line.do(AcknowledgeChanges(another(ran).digest))
    assert line.do(SendPlan(digest)).phase is Phase.SENDING


def test_another_start_does_not_make_the_change_forgotten(tmp_path, cell, ran):
    served(tmp_path, cell, ran).close()
    now = another(ran)
    for _ in range(2):
        served(tmp_path, cell, now, start_before(tmp_path, cell.name)).close()
    before = start_before(tmp_path, cell.name)
    assert before.ran.digest == now.digest
    with closing(served(tmp_path, cell, now, before)) as bench:
        (said,) = bench.state.changed
        assert "is now 99" in said
        bench.do(AcknowledgeChanges(now.digest), "ada")
    with closing(served(tmp_path, cell, now, start_before(tmp_path, cell.name))) as bench:
        assert bench.state.changed == ()


def test_going_on_with_a_session_is_a_start_of_its_own(tmp_path, cell, ran):
    with closing(served(tmp_path, cell, ran)) as bench:
        folder = bench.folder
    before = start_before(tmp_path, cell.name)
    again = Bench(cell, Journal(folder), effects=Idle, start=start(another(ran), before))
    with closing(again) as bench:
        assert bench.state.changed
    with closing(Journal(folder)) as journal:
        assert [row.kind for row in journal.entries()].count("Started") == 2
        assert journal.verify() == ()


def test_a_trial_and_a_session_without_starts_count_for_nothing(tmp_path, cell, ran):
    served(tmp_path, cell, ran).close()
    trial = Started(another(ran), is_trial=True)
    Bench(cell, new_session(tmp_path, cell, AT), effects=Idle, start=trial).close()
    Bench(cell, new_session(tmp_path, cell, AT), effects=Idle).close()
    (tmp_path / f"broken-{cell.name}").mkdir()
    (tmp_path / f"broken-{cell.name}" / "journal.sqlite").write_bytes(b"no database" * 99)
    assert start_before(tmp_path, cell.name).ran.digest == ran.digest
    assert start_before(tmp_path, "another cell") is None
    assert start_before(tmp_path / "nowhere", cell.name) is None


def test_the_last_start_is_told_by_its_own_time_whatever_files_say(tmp_path, cell, ran):
    with closing(served(tmp_path, cell, ran)) as bench:
        first = bench.folder
    served(tmp_path, cell, another(ran)).close()
    # As when somebody has packed it, or opened it once more.
    later = (first / "journal.sqlite").stat().st_mtime + 1000
    os.utime(first / "journal.sqlite", (later, later))
    assert start_before(tmp_path, cell.name).ran.digest == another(ran).digest


def test_many_trials_and_other_cells_hide_no_start(tmp_path, cell, ran, monkeypatch):
    monkeypatch.setattr(starts, "MOST_LOOKED_AT", 2)
    served(tmp_path, cell, ran).close()
    neighbour = replace(ran, cell=f"{cell.name}-2")
    for _ in range(3):
        trial = Started(another(ran), is_trial=True)
        Bench(cell, new_session(tmp_path, cell, AT), effects=Idle, start=trial).close()
        named = replace(cell, name=neighbour.cell)
        served(tmp_path, named, neighbour).close()
    assert start_before(tmp_path, cell.name).ran.digest == ran.digest


def test_a_session_counts_under_whatever_name_it_lies(tmp_path, cell, ran):
    with closing(served(tmp_path, cell, ran)) as bench:
        folder = bench.folder
    folder.rename(tmp_path / "from the other machine")
    assert start_before(tmp_path, cell.name).session == "from the other machine"

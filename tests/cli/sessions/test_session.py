"""`workbench session`: a session told, checked, and computed again."""

import json
import sqlite3
import time
from pathlib import Path

import pytest
from waiting import PATIENCE

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.records.session_archive import sessions_in
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.cli.sessions.inspecting import summarize_session
from workbench.cli.sessions.statistics import sessions_below
from workbench.formats.cells.reading import read_cell
from workbench.gui.shared.movable_frames import move_frame
from workbench.journal import journal
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A session with two plans in it, one in a cell whose bin was moved."""
    cell = read_cell("yumi")
    journal = new_session(tmp_path_factory.mktemp("sessions"), cell, time.time())
    folder = journal.folder
    bench = Bench(cell, journal)

    def step(command, phase: str) -> None:
        bench.do(command, "Ada")
        state = bench.wait(lambda state: state.phase == phase and state.job is None, PATIENCE)
        assert state.phase == phase, state.message

    for _ in range(2):
        step(TakeScan(seed=1), "scanned")
        step(FindParts(seed=1), "localized")
        step(MakePlan(seed=1), "planned")
        bench.do(WatchPlan(bench.state.plan.digest), "Ada")
        step(Approve(bench.state.plan.digest), "approved")
        away = pose_from_rpy(bench.state.cell.bin.T_world_bin.translation + [0.005, 0, 0])
        bench.do(ChangeCell(move_frame(bench.state.cell, "bin", away), "the bin is moved"), "Ada")
    bench.close()
    return folder


def test_a_session_is_listed(say, folder):
    said = say("session", "list", "--sessions", folder.parent, "--json")
    (one,) = json.loads(said.out)["sessions"]
    assert (one["session"], one["cell"]) == (folder.name, "yumi")
    assert int(one["entries"]) > 12 and one["message"] == "the bin is moved"


def test_the_example_that_is_shipped_is_marked_in_the_list_and_not_counted(say):
    listed = say("session", "list", "--sessions", ROOT / "sessions").out
    assert "example (shipped)" in listed
    assert sessions_in(ROOT / "sessions") == ()
    with pytest.raises(InputError, match="there are no sessions of yours in it"):
        sessions_below(ROOT / "sessions")


def test_the_row_of_a_long_session_reads_its_first_and_its_last_entry(folder, monkeypatch):
    read, files_of = [], journal._files_of

    def counted(connection, number):
        read.append(number)
        return files_of(connection, number)

    monkeypatch.setattr(journal, "_files_of", counted)
    row = summarize_session(folder)
    assert read == [1, int(row[2])] and int(row[2]) > 12 and row[4] == "the bin is moved"


def test_a_session_tells_who_did_what(say, folder):
    entries = json.loads(say("session", "show", folder, "--json").out)["entries"]
    kinds = [one["kind"] for one in entries]
    assert kinds[:3] == ["Session", "TakeScan", "JobEnded"]
    assert kinds.count("Approve") == 2 and kinds.count("ChangeCell") == 2
    assert {one["actor"] for one in entries if one["kind"] == "Approve"} == {"Ada"}
    assert "approved by Ada" in say("session", "show", folder).out


def test_a_session_is_computed_again_with_the_same_results(say, folder):
    said = say("session", "replay", folder)
    assert said.code == 0, said.out
    assert said.out.count(": equal") == 6
    assert "every result is the same" in said.out


def test_a_changed_session_is_found_out(say, folder, tmp_path):
    import shutil

    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    assert say("session", "verify", copy).code == 0
    connection = sqlite3.connect(copy / "journal.sqlite")
    connection.execute("DROP TRIGGER entries_stay")
    connection.execute(
        "UPDATE entries SET body = CAST(replace(body, 'Ada', 'Eve') AS BLOB) WHERE kind = 'Approve'"
    )
    connection.commit()
    connection.close()
    said = say("session", "verify", copy)
    assert said.code == 3 and "was changed after it was written" in said.out


def test_a_folder_that_holds_none_is_refused(say, tmp_path):
    said = say("session", "show", tmp_path)
    assert said.code == 2 and "is not the folder of a session" in said.problem

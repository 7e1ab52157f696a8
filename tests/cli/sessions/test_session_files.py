"""Sessions that are taken along and brought back, the example that ships, and what is removed."""

import json
import os
import shutil
import sqlite3
import sys
import time
import zipfile
from contextlib import closing
from pathlib import Path

import pytest

from workbench.app.picking.proving import check
from workbench.app.records.certificates import certificates
from workbench.app.records.sessions import cell_of, new_session
from workbench.app.review.history import History
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.certificates import read_certificate
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused, FileError

EXAMPLE = Path(__file__).resolve().parents[3] / "sessions" / "example"
DAY = 86400


@pytest.fixture
def example(tmp_path) -> Path:
    return Path(shutil.copytree(EXAMPLE, tmp_path / "here" / "example"))


def test_the_example_is_small_whole_and_comes_out_the_same_again(say, example):
    assert sum(file.stat().st_size for file in example.rglob("*") if file.is_file()) < 2**20
    assert "unchanged since they were written" in say("session", "verify", example).out
    said = say("session", "replay", example)
    assert said.code == 0, said.out
    # A scan made again differs a little where another make of processor recorded it.
    results = [line.partition(": ")[2] for line in said.out.splitlines()[:-1]]
    assert len(results) == 3, said.out
    # Where somebody has set other instructions than the workbench takes, last digits differ.
    assert results[2] == "equal" or os.environ["OPENBLAS_CORETYPE"] != "Nehalem", said.out
    assert all(one.startswith(("equal", "the same within")) for one in results), said.out


def test_an_exported_session_can_be_read_by_people_and_comes_back(say, example, tmp_path):
    said = say("session", "export", example, "--out", tmp_path / "x.zip")
    assert said.code == 0, said.err
    with zipfile.ZipFile(tmp_path / "x.zip") as archive:
        assert {"summary.txt", "summary.json", "statistics.csv", "scene.html"} < set(
            archive.namelist()
        )
        text = archive.read("summary.txt").decode()
        assert "picked: 2" in text and "Ada reports: part-2 was picked" in text
        scene = archive.read("scene.html").decode()
    assert "__VISER_EMBED_DATA__" in scene and len(scene) > 500_000
    head = scene[: scene.index("<body")]
    assert 'src="http' not in head and 'href="http' not in head, "it needs nothing from elsewhere"
    said = say("session", "import", tmp_path / "x.zip", "--sessions", tmp_path / "there")
    assert said.code == 0 and (tmp_path / "there/x/scene.html").exists()
    assert say("session", "verify", tmp_path / "there/x").code == 0
    assert say("session", "show", tmp_path / "there/x").out.count("Sent") > 30
    said = say("session", "import", tmp_path / "x.zip", "--sessions", tmp_path / "there")
    assert said.code == 2 and "is there already" in said.problem


def test_what_was_approved_is_exported_with_its_certificate_which_can_be_checked(
    say, example, tmp_path
):
    say("session", "export", example, "--out", tmp_path / "x.zip", "--no-scene")
    with zipfile.ZipFile(tmp_path / "x.zip") as archive:
        (name,) = [one for one in archive.namelist() if one.startswith("certificates/")]
        log = json.loads(archive.read("summary.json"))["log"]
        assert [(one["kind"], one["certificate"]) for one in log if "certificate" in one] == [
            ("JobEnded", name)
        ]
        assert f"proven: {name}" in archive.read("summary.txt").decode()
        version = json.loads(archive.read("summary.json"))["workbench"]
    assert say("session", "import", tmp_path / "x.zip", "--sessions", tmp_path / "there").code == 0
    certificate = tmp_path / "there" / "x" / name
    assert json.loads(certificate.read_text())["made_with"] == {"workbench": version}
    with closing(Journal(example)) as journal:
        cell = cell_of(journal)
    assert check(cell, read_certificate(certificate)).holds
    certificate.write_text(certificate.read_text().replace('"seed": ', '"seed": 1'))
    with pytest.raises(FileError, match="was changed after"):
        read_certificate(certificate)


def test_a_plan_that_nobody_approved_has_no_certificate(example):
    """The same session before its approval."""
    with closing(Journal(example)) as journal:
        rows = list(journal.entries())
        first = next(k for k, row in enumerate(rows) if row.kind == "Approve")
        assert not list(certificates(rows[:first], journal.read, only_approved=True))
        assert len(list(certificates(rows[: first + 1], journal.read, only_approved=True))) == 1


def test_a_zip_file_without_a_name_makes_no_folder(say, example, tmp_path):
    say("session", "export", example, "--out", tmp_path / "x.zip")
    (tmp_path / "x.zip").rename(tmp_path / "...zip")
    said = say("session", "import", tmp_path / "...zip", "--sessions", tmp_path / "there")
    assert said.code == 2 and "no name that a folder could have" in said.problem
    assert not (tmp_path / "there").exists()


@pytest.fixture
def exported(say, example, tmp_path) -> Path:
    say("session", "export", example, "--out", tmp_path / "x.zip", "--no-scene")
    return tmp_path / "x.zip"


def forged(source: Path, name: str, content: bytes) -> None:
    with zipfile.ZipFile(source) as old:
        files = {one: old.read(one) for one in old.namelist()} | {name: content}
    with zipfile.ZipFile(source, "w") as new:
        for one, data in files.items():
            new.writestr(one, data)


def with_statement(database: bytes, path: Path, statement: str) -> bytes:
    path.write_bytes(database)
    connection = sqlite3.connect(path)
    connection.execute("DROP TRIGGER entries_stay")
    connection.execute(statement)
    connection.commit()
    connection.close()
    return path.read_bytes()


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("UPDATE entries SET body = x'00' WHERE number = 3", "entry 3 was changed"),
        ("UPDATE entries SET kind = 'Note' WHERE number = 1", "entry 1 was changed"),
        ("CREATE VIEW v AS SELECT 1", "does not hold the journal of a session"),
        (
            "CREATE TRIGGER t AFTER INSERT ON entries BEGIN DELETE FROM files; END",
            "does not hold the journal of a session",
        ),
        ("PRAGMA user_version = 99", "newer workbench"),
    ],
)
def test_a_changed_journal_does_not_come_back(say, exported, tmp_path, statement, expected):
    with zipfile.ZipFile(exported) as archive:
        database = archive.read("journal.sqlite")
    forged(exported, "journal.sqlite", with_statement(database, tmp_path / "db", statement))
    said = say("session", "import", exported, "--sessions", tmp_path / "there")
    assert said.code != 0 and expected in said.problem
    assert list((tmp_path / "there").iterdir()) == []


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("../evil", b"x", "no plain path"),
        ("extra.py", b"x", "holds 'extra.py'"),
        ("journal.sqlite", b"no database", "is no journal"),
    ],
)
def test_other_things_in_the_file_do_not_come_in(say, exported, tmp_path, name, content, expected):
    forged(exported, name, content)
    said = say("session", "import", exported, "--sessions", tmp_path / "there")
    assert said.code != 0 and expected in said.problem
    assert list((tmp_path / "there").iterdir()) == []


def test_a_session_that_was_changed_is_not_exported(say, example, tmp_path):
    next(file for file in (example / "files").rglob("*/*")).write_bytes(b"something else")
    said = say("session", "export", example, "--out", tmp_path / "x.zip", "--no-scene")
    assert said.code == 1 and "a changed session is not exported" in said.problem
    assert not (tmp_path / "x.zip").exists()


@pytest.fixture
def many(tmp_path) -> Path:
    """Sessions of today, and of 10, 20 and 30 days ago, and the example."""
    root, cell = tmp_path / "many", read_cell("tx2_90")
    for days in (0, 10, 20, 30):
        new_session(root, cell, time.time() - days * DAY).close()
    shutil.copytree(EXAMPLE, root / "example")
    return root


@pytest.mark.parametrize(
    ("options", "left"),
    [
        (("--keep", 2), 2),
        (("--older-than-days", 15), 2),
        (("--keep", 3, "--older-than-days", 15), 3),
        (("--keep", 0), 0),
        (("--keep", 9), 4),
    ],
)
def test_old_sessions_are_removed_and_the_example_stays(say, many, options, left):
    said = say("session", "prune", "--sessions", many, *options, "--yes")
    assert said.code == 0
    names = sorted(one.name for one in many.iterdir())
    assert len(names) == left + 1 and names[-1] == "example"
    assert ("freed" in said.out) == (left < 4)


def test_a_folder_whose_name_is_no_time_is_left_alone(say, many):
    newest = sorted(many.iterdir())[-2]
    newest.rename(many / "20261399-250000-yumi")
    assert say("session", "prune", "--sessions", many, "--keep", 0, "--yes").code == 0
    assert sorted(one.name for one in many.iterdir()) == ["20261399-250000-yumi", "example"]


def test_a_session_that_cannot_be_removed_is_named(say, many):
    target = sorted(many.iterdir())[0]
    target.rename(many.parent / "elsewhere")
    target.symlink_to(many.parent / "elsewhere")
    said = say("session", "prune", "--sessions", many, "--keep", 0, "--yes")
    assert said.code == 2 and target.name in said.problem and "not removed" in said.problem


def test_nothing_is_removed_unasked_or_while_it_goes_on(say, many):
    said = say("session", "prune", "--sessions", many, "--keep", 0)
    assert said.code == 2 and "say --yes" in said.problem
    assert "say what to keep" in say("session", "prune", "--sessions", many).problem
    newest = sorted(many.iterdir())[-2]
    going_on = Journal(newest)
    going_on.append("note", b"still here")
    assert say("session", "prune", "--sessions", many, "--keep", 0, "--yes").code == 0
    assert sorted(one.name for one in many.iterdir()) == [newest.name, "example"]
    going_on.close()


def test_a_recorded_session_is_looked_at_moment_by_moment(example):
    journal = Journal(example)
    history = History(journal)
    assert history.count == journal.count == history.state.number
    seen = []
    end = history.subscribe(lambda old, new: seen.append((old.phase, new.phase)))
    history.go(0)
    assert (history.state.phase, history.entry) == ("idle", None)
    history.go(8)
    assert history.entry.kind == "Approve" and history.state.approval.actor == "demo"
    history.go(10**9)
    assert history.number == history.count - 1
    assert seen == [("done", "idle"), ("idle", "approved"), ("approved", "done")]
    end()
    history.go(0)
    assert len(seen) == 3
    with pytest.raises(CommandRefused, match="recorded session"):
        history.do(object(), "ada")
    journal.close()


def test_old_scans_are_forgotten_by_the_page(example, monkeypatch):
    monkeypatch.setattr("workbench.app.review.history.MOST_SCANS", 0)
    journal = Journal(example)
    history = History(journal)
    states = [history.state for number in range(history.count) if not history.go(number)]
    assert any(state.phase == "scanned" for state in states)
    assert all(state.scan is None for state in states[3:4])
    journal.close()


def test_the_example_is_not_written_to_by_looking():
    assert not list(EXAMPLE.glob("*-wal")), os.listdir(EXAMPLE)


def test_a_session_is_written_for_foxglove(say, example, tmp_path):
    reader = pytest.importorskip("mcap.reader", reason="mcap is not installed")
    said = say("session", "export", example, "--out", tmp_path / "x.mcap", "--mcap")
    assert said.code == 0 and said.out.startswith(f"{tmp_path / 'x.mcap'}: 0.")
    with (tmp_path / "x.mcap").open("rb") as file:
        read = reader.make_reader(file)
        summary, described = read.get_summary(), list(read.iter_metadata())
    assert {"/scan", "/tf", "/joints", "/plan", "/verdicts", "/log"} < {
        channel.topic for channel in summary.channels.values()
    }
    assert described[0].name == "session" and described[0].metadata["cell"] == "yumi"
    said = say("session", "export", example, "--out", tmp_path / "no/x.mcap", "--mcap")
    assert said.code == 2 and "No such file" in said.problem


def test_a_changed_session_is_not_written_for_foxglove(say, example, tmp_path):
    pytest.importorskip("mcap", reason="mcap is not installed")
    victim = max((example / "files").rglob("*"), key=lambda one: one.stat().st_size)
    content = victim.read_bytes()
    victim.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
    said = say("session", "export", example, "--out", tmp_path / "x.mcap", "--mcap")
    assert said.code == 1 and "a changed session is not exported" in said.problem
    assert list(tmp_path.iterdir()) == [example.parent]


def test_without_the_library_it_is_named(say, example, tmp_path, monkeypatch):
    for name in ("mcap", "mcap.writer"):
        monkeypatch.setitem(sys.modules, name, None)
    for name in ("workbench.extras.mcap.session", "workbench.extras.mcap.writing"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    said = say("session", "export", example, "--out", tmp_path / "x.mcap", "--mcap")
    assert said.code == 2 and "pip install 'workbench[mcap]'" in said.problem

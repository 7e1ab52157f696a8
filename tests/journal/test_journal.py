"""The journal keeps what it was given, and shows when somebody changed it."""

import hashlib
import os
import signal
import sqlite3
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from workbench.journal.journal import Journal
from workbench.model.errors import JournalError

WRITER = """
import hashlib, sys
from pathlib import Path
from workbench.journal.journal import Journal

journal = Journal(Path(sys.argv[1]))
print("open", flush=True)
while True:
    content = f"content {journal.count}".encode() * 500
    digest = hashlib.sha256(content).hexdigest()
    print(journal.append("note", str(journal.count).encode(), {digest: content}), flush=True)
"""


def as_file(content: bytes) -> dict[str, bytes]:
    return {hashlib.sha256(content).hexdigest(): content}


@pytest.fixture
def journal(tmp_path):
    opened = Journal(tmp_path / "session", patience=0.05)
    yield opened
    opened.close()


def tamper(journal: Journal, *statements: str) -> None:
    """Change the database as somebody with an SQL shell would."""
    connection = sqlite3.connect(journal.folder / "journal.sqlite", isolation_level=None)
    connection.execute("DROP TRIGGER IF EXISTS entries_stay")
    connection.execute("DROP TRIGGER IF EXISTS entries_remain")
    for statement in statements:
        connection.execute(statement)
    connection.close()


def with_three_entries(journal: Journal) -> Journal:
    for number in range(3):
        journal.append("note", f"body {number}".encode(), as_file(f"file {number}".encode()))
    return journal


@settings(
    max_examples=15,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(bodies=st.lists(st.tuples(st.text(min_size=1), st.binary(), st.binary()), max_size=5))
def test_what_was_appended_comes_back_after_opening_again(tmp_path_factory, bodies):
    folder = tmp_path_factory.mktemp("session")
    journal = Journal(folder)
    for kind, body, content in bodies:
        journal.append(kind, body, as_file(content))
    head = journal.head
    journal.close()
    again = Journal(folder)
    rows = list(again.entries())
    assert [(row.kind, row.body, again.read(row.files[0])) for row in rows] == bodies
    assert [row.number for row in rows] == list(range(1, len(bodies) + 1))
    assert again.head == head
    assert bool(again.verify()) == (not bodies)
    again.close()


def test_numbers_go_on_after_opening_again(journal):
    with_three_entries(journal).close()
    again = Journal(journal.folder)
    assert again.append("note", b"fourth") == 4
    assert [row.number for row in again.entries(after=2)] == [3, 4]
    again.close()


def test_a_changed_body_is_found(journal):
    tamper(with_three_entries(journal), "UPDATE entries SET body = x'00' WHERE number = 2")
    assert journal.verify() == ("entry 2 was changed after it was written",)


def test_a_changed_body_with_a_matching_new_hash_is_found_by_the_next_entry(journal):
    tamper(with_three_entries(journal), "UPDATE entries SET hash = 'abc' WHERE number = 2")
    assert "entry 3 does not follow from the one before it" in journal.verify()


def test_a_removed_entry_is_found_in_the_middle_and_at_the_end(journal):
    with_three_entries(journal)
    tamper(journal, "DELETE FROM entries WHERE number = 2")
    assert "entry 2 is missing before entry 3" in journal.verify()
    tamper(journal, "DELETE FROM entries WHERE number = 3")
    assert "the entries 2 to 3 are missing at the end" in journal.verify()


def test_a_file_taken_from_an_entry_is_found(journal):
    tamper(with_three_entries(journal), "DELETE FROM entry_files WHERE entry = 1")
    assert journal.verify() == ("entry 1 was changed after it was written",)


def test_a_changed_or_missing_file_is_found(journal):
    with_three_entries(journal)
    changed, missing = sorted((journal.folder / "files").rglob("*/*"))[:2]
    changed.write_bytes(b"something else")
    missing.unlink()
    problems = journal.verify()
    assert len(problems) == 2
    assert any("changed after it was written" in problem for problem in problems)
    assert any("cannot be read" in problem for problem in problems)


@pytest.mark.parametrize("put", [os.mkfifo, lambda path: path.symlink_to("/dev/zero"), Path.mkdir])
def test_what_is_no_file_is_told_and_not_waited_at(journal, put):
    content = b"a scan"
    digest = hashlib.sha256(content).hexdigest()
    journal.append("scan", b"", {digest: content})
    path = journal.folder / "files" / digest[:2] / digest
    path.unlink()
    put(path)
    assert journal.verify() == (f"entry {journal.count}: {path}: is no file",)
    with pytest.raises(JournalError, match="is no file"):
        journal.read(digest)


def test_the_database_itself_refuses_changes(journal):
    with_three_entries(journal)
    connection = sqlite3.connect(journal.folder / "journal.sqlite")
    for statement in ("UPDATE entries SET kind = 'x'", "DELETE FROM entries"):
        with pytest.raises(sqlite3.IntegrityError, match="only ever appended"):
            connection.execute(statement)
    connection.close()


def test_a_locked_database_refuses_the_entry_and_the_next_one_takes_its_number(journal):
    journal.append("note", b"first")
    other = sqlite3.connect(journal.folder / "journal.sqlite", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    with pytest.raises(JournalError, match="locked"):
        journal.append("note", b"lost")
    other.execute("ROLLBACK")
    other.close()
    assert journal.append("note", b"second") == 2
    assert [row.body for row in journal.entries()] == [b"first", b"second"]


def test_a_second_process_writing_to_the_session_is_refused(journal):
    second = Journal(journal.folder)
    journal.append("note", b"first")
    with pytest.raises(JournalError, match="another process writes"):
        second.append("note", b"in between")
    second.close()
    assert journal.append("note", b"second") == 2


def test_content_that_is_not_what_its_digest_says_is_refused(journal):
    with pytest.raises(JournalError, match="has the digest"):
        journal.append("note", b"", {"0" * 64: b"content"})
    with pytest.raises(JournalError, match="not a SHA-256"):
        journal.append("note", b"", {"../../etc/passwd": b"content"})
    assert journal.count == 0


def test_a_journal_of_a_newer_workbench_is_left_alone(journal):
    journal.close()
    connection = sqlite3.connect(journal.folder / "journal.sqlite")
    connection.execute("PRAGMA user_version = 99")
    connection.close()
    with pytest.raises(JournalError, match="version 99"):
        Journal(journal.folder)


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "session").write_text("not a folder")
    with pytest.raises(JournalError, match="cannot hold a journal"):
        Journal(tmp_path / "session")


def test_threads_append_at_once_and_a_reader_sees_whole_entries(journal):
    def write(thread: int) -> None:
        for number in range(10):
            journal.append("note", f"{thread} {number}".encode())

    threads = [threading.Thread(target=write, args=(thread,)) for thread in range(4)]
    for thread in threads:
        thread.start()
    seen = [len(list(journal.entries())) for _ in range(5)]
    for thread in threads:
        thread.join()
    assert seen == sorted(seen)
    assert len({row.body for row in journal.entries()}) == 40
    assert journal.verify() == ()


@pytest.mark.parametrize("entries", [0, 1, 3, 8, 20])
def test_a_killed_writer_leaves_every_reported_entry_whole(tmp_path, entries):
    folder = tmp_path / "session"
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(folder)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).parents[2],
    )
    assert writer.stdout is not None
    reported = 0
    for _ in range(1 + entries):
        line = writer.stdout.readline().strip()
        reported = int(line) if line.isdigit() else 0
    writer.send_signal(signal.SIGKILL)
    writer.wait()
    lines = [line for line in writer.stdout.read().split("\n") if line.isdigit()]
    writer.stdout.close()
    reported = max([reported, *map(int, lines)])
    journal = Journal(folder)
    # The entry in work may have reached the disk before its number reached us.
    assert journal.count in (reported, reported + 1)
    assert journal.append("note", b"life goes on") == journal.count
    assert journal.verify() == ()
    journal.close()


def test_an_empty_journal_is_not_called_whole(journal):
    (problem,) = journal.verify()
    assert problem.startswith("there is no entry")


CLAIMER = """
import sys, time
from pathlib import Path
from workbench.journal.journal import Journal

Journal(Path(sys.argv[1])).claim(1_790_000_000.0)
print("claimed", flush=True)
time.sleep(600)
"""


class TestTheFolderOfAnotherProgram:
    @pytest.fixture
    def other(self, journal):
        process = subprocess.Popen(
            [sys.executable, "-c", CLAIMER, str(journal.folder)], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout.readline() == "claimed\n"
        yield process
        process.kill()
        process.communicate()

    def test_is_not_claimed_and_says_who_has_it(self, journal, other):
        with pytest.raises(JournalError) as caught:
            journal.claim(0.0)
        assert f"process {other.pid} on " in str(caught.value)
        assert "since 2026-09-21 14:13:20 UTC" in str(caught.value)

    def test_is_free_when_that_one_was_killed(self, journal, other):
        other.kill()
        other.wait()
        journal.claim(0.0)

    def test_may_hold_nonsense_about_its_owner(self, journal, other):
        (journal.folder / "writer.lock").write_bytes(b'{"process": [], "since": 1e300}')
        with pytest.raises(JournalError, match="another program"):
            journal.claim(0.0)


def test_a_claim_ends_with_the_journal(journal):
    journal.claim(0.0)
    journal.claim(1.0)
    second = Journal(journal.folder)
    with pytest.raises(JournalError, match="is written to by process"):
        second.claim(2.0)
    journal.close()
    second.claim(3.0)
    second.close()

"""Approvals of plans on the command line: once a plan, after it was shown, whoever else writes."""

import json
import multiprocessing
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from workbench.app.records.approvals import ApprovalRecord
from workbench.model.errors import CommandRefused, JournalError
from workbench.model.release import Approval, Receipt

NOW, MINUTES = 1_760_000_000.0, 300.0
FACTS = {"Plan": "a" * 64, "Controller": "127.0.0.1 port 1025"}


def approval(digest="a" * 64, actor="Ada"):
    return Approval(digest, "b", "c", "d", actor, NOW, NOW + MINUTES, is_unwatched=True)


@pytest.fixture
def record(tmp_path):
    return ApprovalRecord(tmp_path / "approvals")


def entries(record):
    with closing(sqlite3.connect(record.folder / "journal.sqlite")) as connection:
        rows = connection.execute("SELECT kind, body FROM entries ORDER BY number").fetchall()
    return [(kind, json.loads(body)) for kind, body in rows]


def take(folder: str) -> str:
    """In a process of its own."""
    try:
        ApprovalRecord(Path(folder)).take(approval())
    except (CommandRefused, JournalError) as error:
        return str(error)
    return ""


def test_it_says_who_when_which_plan_and_that_nobody_has_watched_it(record):
    record.show("a" * 64, "Ada", NOW, FACTS)
    record.check_shown("a" * 64, "ada ", NOW + 1, MINUTES, FACTS)
    record.take(approval())
    receipt = Receipt(NOW, "right", "in", "inR#", 1, 2)
    record.end(approval(), (receipt,), "the controller closed the link")
    (_, shown), (_, word), (_, ended) = entries(record)
    assert (shown["actor"], shown["at"], shown["facts"]) == ("Ada", NOW, FACTS)
    assert (word["plan_digest"], word["actor"], word["at"]) == ("a" * 64, "Ada", NOW)
    assert word["is_unwatched"] is True
    assert ended["is_unwatched"] is True
    assert ended["receipts"][0]["sent"] == "inR#"
    assert ended["problem"] == "the controller closed the link"


def test_a_row_is_taken_whole_or_not_at_all(record):
    first = replace(approval(), row=(("e" * 64, "f"), ("0" * 64, "1")))
    second = first.onward()
    third = second.onward()
    assert third.onward() is None
    assert [one.plan_digest[0] for one in (first, second, third)] == ["a", "e", "0"]
    assert (second.first, third.first) == (first.digest, first.digest) and first.first == ""
    assert {one.until for one in (second, third)} == {first.until}
    assert second.people == first.people
    record.take(second)
    with pytest.raises(CommandRefused, match="has gone out"):
        record.take(first, second, third)
    assert [kind for kind, _ in entries(record)] == ["Approval"]
    record.end(second, (), "the row had ended before")
    record.take(first, second, third)
    assert len(entries(record)) == 5


def test_a_plan_goes_out_once(record):
    record.take(approval())
    for again in (
        lambda: record.take(approval(actor="Bob")),
        lambda: record.show("a" * 64, "Bob", NOW, FACTS),
        lambda: record.check_shown("a" * 64, "Ada", NOW + 2 * MINUTES, MINUTES, FACTS),
    ):
        with pytest.raises(CommandRefused, match=r"approved by Ada before .* another --seed"):
            again()
    record.take(approval("e" * 64))


def test_a_plan_of_which_nothing_arrived_may_be_approved_again(record):
    record.take(approval())
    record.end(approval(), (), "nobody answers")
    record.take(approval())
    record.end(approval(), (Receipt(NOW, "right", "in", "x", 1, 2),), "")
    with pytest.raises(CommandRefused, match="before"):
        record.take(approval())


def test_of_many_processes_at_the_same_moment_one_approves(record):
    record.show("a" * 64, "Ada", NOW, FACTS)
    with multiprocessing.get_context("spawn").Pool(4) as pool:
        said = pool.map(take, [str(record.folder)] * 12, chunksize=3)
    assert said.count("") == 1
    assert sum(kind == "Approval" for kind, _ in entries(record)) == 1


@pytest.mark.parametrize(
    ("digest", "actor", "later", "facts", "says"),
    [
        ("b" * 64, "Ada", 1.0, FACTS, "was not shown"),
        ("a" * 64, "Bob", 1.0, FACTS, "was not shown to Bob"),
        ("a" * 64, "Ada", MINUTES, FACTS, "more than 5 minutes"),
        ("a" * 64, "Ada", -1.0, FACTS, "more than 5 minutes"),
        ("a" * 64, "Ada", 1.0, FACTS | {"Controller": "10.0.0.1 port 1025"}, r"\(controller\)"),
    ],
)
def test_who_has_not_read_this_approves_nothing(record, digest, actor, later, facts, says):
    record.show("a" * 64, "Ada", NOW, FACTS)
    with pytest.raises(CommandRefused, match=says):
        record.check_shown(digest, actor, NOW + later, MINUTES, facts)


def test_a_record_that_was_changed_is_not_believed(record):
    record.take(approval())
    with closing(sqlite3.connect(record.folder / "journal.sqlite")) as connection, connection:
        connection.execute("DROP TRIGGER IF EXISTS entries_stay")
        triggers = connection.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'")
        for (name,) in triggers.fetchall():
            connection.execute(f"DROP TRIGGER {name}")
        connection.execute("UPDATE entries SET kind = 'Shown'")
    with pytest.raises(CommandRefused, match="was changed"):
        record.take(approval())

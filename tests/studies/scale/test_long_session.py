"""A session that is written as long as wanted is one that the rules admit."""

import shutil
from collections import Counter
from contextlib import closing
from pathlib import Path

import pytest

from workbench.app.records.replay import replay
from workbench.app.records.sessions import cell_of, new_session
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.errors import InputError
from workbench.studies.scale.session import SessionWriter

EXAMPLE = Path(__file__).resolve().parents[3] / "sessions" / "example"


def test_a_cycle_is_recorded_again_and_again_and_replays(tmp_path):
    shutil.copytree(EXAMPLE, tmp_path / "example")
    with closing(Journal(tmp_path / "example")) as recorded:
        writer = SessionWriter(recorded, tmp_path / "long")
        writer.write(2 * recorded.count)
        count = 2 * recorded.count
    with closing(writer.journal) as journal:
        assert journal.count == count and journal.verify() == ()
        entries = [entry for entry, _ in replay(journal, cell_of(journal))]
    kinds = Counter(type(entry.command).__name__ for entry in entries)
    assert kinds["TakeScan"] >= 2 and kinds["LinkEnded"] >= 1
    assert [entry.at for entry in entries] == sorted(entry.at for entry in entries)


def test_a_session_without_a_cycle_is_refused(tmp_path):
    with (
        closing(new_session(tmp_path, read_cell("yumi"), 0.0)) as recorded,
        pytest.raises(InputError, match="no cycle was recorded"),
    ):
        SessionWriter(recorded, tmp_path / "long")

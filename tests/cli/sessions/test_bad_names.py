"""Sessions named by what no folder can be called, and zip files that hold no journal."""

import zipfile

import pytest

LONG = "x" * 300


@pytest.mark.parametrize(
    "words",
    [
        ("session", "show", LONG),
        ("session", "verify", LONG),
        ("session", "export", LONG, "--out", "x.zip"),
        ("serve", "--session", LONG),
        ("serve", "--after", LONG),
        ("statistics", LONG),
        ("evidence", LONG),
    ],
)
def test_a_name_that_no_folder_has_is_bad_input(say, words):
    said = say(*words)
    assert said.code == 2
    assert "is not the folder of a session" in said.err
    assert "Traceback" not in said.err


def test_a_list_of_what_cannot_be_there_is_empty(say):
    assert say("session", "list", "--sessions", LONG).code == 0


@pytest.mark.parametrize("content", [b"no database at all", b"SQLite format 3\x00" * 99])
def test_a_zip_file_whose_journal_is_no_database_is_bad_input(say, tmp_path, content):
    with zipfile.ZipFile(tmp_path / "x.zip", "w") as archive:
        archive.writestr("journal.sqlite", content)
    said = say("session", "import", tmp_path / "x.zip", "--sessions", tmp_path / "there")
    assert said.code == 2
    assert "its journal.sqlite is no journal" in said.err

"""Cases of a session: listed, copied, and taken along with it."""

import json
import shutil
from contextlib import closing
from pathlib import Path

import pytest

from workbench.app.core.people import Role
from workbench.app.records.case_folder import FOLDER, keep_case
from workbench.app.records.cases import read_case
from workbench.app.records.replay import replay
from workbench.app.records.sessions import cell_of
from workbench.journal.journal import Journal

EXAMPLE = Path(__file__).resolve().parents[3] / "sessions" / "example"


@pytest.fixture(scope="module")
def kept(tmp_path_factory) -> Path:
    """The example, in which somebody has kept what was found."""
    session = Path(shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("kept") / "example"))
    with closing(Journal(session)) as journal:
        states = [state for _, state in replay(journal, cell_of(journal))]
    state = next(state for state in states if state.searches)
    about = {"actor": "Ada", "role": Role.ENGINEER, "at": 1_700_000_000.0}
    keep_case(session, state, "it lies deeper", "listed alone", **about)
    return session


@pytest.fixture
def session(kept, tmp_path) -> Path:
    return Path(shutil.copytree(kept, tmp_path / "here" / "example"))


def test_cases_are_listed_and_copied_once(say, session, tmp_path):
    said = say("session", "cases", session)
    assert said.code == 0, said.err
    assert all(word in said.out for word in ("it lies deeper", "Ada", "2023-11-14 22:13"))
    out = tmp_path / "all"
    assert "1 of 1 cases copied" in say("session", "cases", session, "--out", out).out
    assert "0 of 1 cases copied" in say("session", "cases", session, "--out", out).out
    (file,) = out.iterdir()
    assert read_case(file).comment == "it lies deeper"
    (row,) = json.loads(say("session", "cases", session, "--json").out)["cases"]
    assert row["case"] == file.name and row["is_complete"] and row["changed"] == 0


def test_a_damaged_case_is_told_and_holds_up_no_other(say, session, tmp_path):
    (file,) = (session / FOLDER).iterdir()
    (session / FOLDER / file.name.replace("20231114", "20231113")).write_bytes(b"nothing")
    said = say("session", "cases", session, "--out", tmp_path / "all")
    assert said.code == 2 and "no zip file" in said.problem
    assert [one.name for one in (tmp_path / "all").iterdir()] == [file.name]


def test_what_is_no_session_has_no_cases(say, tmp_path):
    said = say("session", "cases", tmp_path)
    assert said.code == 2 and "is not the folder of a session" in said.problem


def test_cases_go_along_with_their_session(say, session, tmp_path):
    (file,) = (session / FOLDER).iterdir()
    assert say("session", "export", session, "--out", tmp_path / "x.zip", "--no-scene").code == 0
    assert say("session", "import", tmp_path / "x.zip", "--sessions", tmp_path / "there").code == 0
    assert (tmp_path / "there/x" / FOLDER / file.name).read_bytes() == file.read_bytes()

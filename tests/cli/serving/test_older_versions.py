"""What an older version wrote is read by this one: an upgrade loses nothing.

`of_0_1.zip` holds the example session and a file of users, as early states of 0.1 wrote them.  It
is never made anew; a version that changes a format adds another beside it.
"""

import zipfile
from contextlib import closing
from pathlib import Path

import pytest
from idle import Idle

from workbench.app.core.commands import SendPlan
from workbench.app.core.people import Person, Role
from workbench.app.core.state import Phase
from workbench.app.records.sessions import cell_of
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused
from workbench.web.access.store import Store
from workbench.web.access.users import Users


@pytest.fixture
def kept(tmp_path) -> Path:
    with zipfile.ZipFile(Path(__file__).with_name("of_0_1.zip")) as archive:
        archive.extractall(tmp_path)
    return tmp_path


def test_a_session_is_verified_shown_exported_and_comes_back(say, kept):
    said = say("session", "verify", kept / "session")
    assert "55 entries, unchanged since they were written" in said.out, said.err
    for words in (
        ("session", "show", kept / "session"),
        ("statistics", kept / "session"),
        ("session", "export", kept / "session", "--out", kept / "out.zip"),
        ("session", "import", kept / "out.zip", "--sessions", kept / "back"),
        ("session", "verify", kept / "back" / "out"),
        ("evidence", kept / "session", "--out", kept / "evidence.zip"),
    ):
        said = say(*words)
        assert said.code == 0, (words, said.err)


def test_a_session_is_gone_on_with_and_what_was_approved_is_not_sent_again(kept):
    journal = Journal(kept / "session")
    bench = Bench(cell_of(journal), journal, effects=Idle)
    try:
        state = bench.state
        assert state.cell.name == "yumi" and state.parts_placed == 1
        assert state.phase is Phase.DONE and state.plan is not None and state.proof is not None
        with pytest.raises(CommandRefused):
            bench.do(SendPlan(state.plan.digest), "Anna")
    finally:
        bench.close()


def test_users_log_in_as_before(kept):
    with closing(Store(kept / "users.sqlite")) as store:
        users = Users(store)
        assert users.by_password("Anna", "seven brown pallets") == Person("Anna", Role.ENGINEER)
        assert users.by_password("Anna", "seven brown pallet") is None

"""What an older version wrote is read by this one: an upgrade loses nothing.

`of_0_1.zip` holds the example session and a file of users, as early states of 0.1 wrote them;
`of_0_1_0.zip` those of 0.1.0 as it was released from: what ran at the start, a place that says how
the part lies, a plan sent at half its speed step by step, a user who is kept out and a token.
They are never made anew; a version that changes a format adds another beside them.
"""

import zipfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from idle import Idle

from workbench import __version__
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.people import Person, Role
from workbench.app.core.state import Phase
from workbench.app.provenance.gathering import inventory
from workbench.app.records.sessions import cell_of
from workbench.app.records.starts import start, start_before
from workbench.app.runtime.bench import Bench
from workbench.cli.serving.people import roles
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused
from workbench.web.access.store import Store
from workbench.web.access.users import Users

ENTRIES = {"of_0_1": 55, "of_0_1_0": 88}


@pytest.fixture
def unpacked(tmp_path) -> Callable[[str], Path]:
    def unpack(name: str) -> Path:
        with zipfile.ZipFile(Path(__file__).with_name(f"{name}.zip")) as archive:
            archive.extractall(tmp_path)
        return tmp_path

    return unpack


@pytest.mark.parametrize("name", ENTRIES)
def test_a_session_is_verified_shown_exported_and_comes_back(say, unpacked, name):
    kept = unpacked(name)
    said = say("session", "verify", kept / "session")
    assert f"{ENTRIES[name]} entries, unchanged since they were written" in said.out, said.err
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


@pytest.mark.parametrize("name", ENTRIES)
def test_a_session_is_gone_on_with_and_what_was_approved_is_not_sent_again(unpacked, name):
    journal = Journal(unpacked(name) / "session")
    bench = Bench(cell_of(journal), journal, effects=Idle)
    try:
        state = bench.state
        assert state.cell.name.startswith("yumi") and state.parts_placed == 1
        assert state.phase is Phase.DONE and state.plan is not None and state.proof is not None
        with pytest.raises(CommandRefused):
            bench.do(SendPlan(state.plan.digest), "Anna")
    finally:
        bench.close()


def test_how_it_was_sent_is_known_and_places_still_say_how_parts_lie(unpacked):
    with closing(Journal(unpacked("of_0_1_0") / "session")) as journal:
        cell = cell_of(journal)
        approvals = [row.body for row in journal.entries() if row.kind == "Approve"]
        bench = Bench(cell, journal, effects=Idle)
    assert all(place.part for arm in cell.arms for place in arm.part_places)
    assert [b'"speed_share":0.5,"is_stepped":true' in body for body in approvals] == [True]
    assert bench.state.let == 6


def test_the_first_start_after_an_upgrade_tells_that_the_workbench_is_another(unpacked):
    kept = unpacked("of_0_1_0")
    with closing(Journal(kept / "session")) as journal:
        cell = cell_of(journal)
    before = start_before(kept, cell.name)
    assert before is not None
    told = start(inventory(cell, roles(kept / "users.sqlite")), before)
    assert f"workbench 0.1.0 is now {__version__}" in map(str, told.changes)
    # Digests of cell and parts are made as they were then, and the people are the same.
    assert before.ran.cell_digest == cell.digest
    words = " ".join(map(str, told.changes))
    assert not [word for word in ("cell", "user", "pose") if word in words]


@pytest.mark.parametrize("name", ENTRIES)
def test_users_log_in_as_before(unpacked, name):
    with closing(Store(unpacked(name) / "users.sqlite")) as store:
        users = Users(store)
        assert users.by_password("Anna", "seven brown pallets") == Person("Anna", Role.ENGINEER)
        assert users.by_password("Anna", "seven brown pallet") is None


def test_who_was_kept_out_still_is_and_programs_come_in_by_their_tokens(unpacked):
    with closing(Store(unpacked("of_0_1_0") / "users.sqlite")) as store:
        users = Users(store)
        assert users.by_password("Otto", "eight green pallets") == Person("Otto", Role.OPERATOR)
        assert users.by_password("Vera", "nine white pallets") is None
        token = "wb_xEFnHmvvdbt11pcMfpn0V3TL3jrZQUjOOFnh5snEF-I"
        assert users.by_token(token) == Person("Anna", Role.ENGINEER)

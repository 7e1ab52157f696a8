"""`workbench backup` and `restore`: what was kept comes back, and nothing bad comes in."""

import json
import shutil
import time
import zipfile
from contextlib import closing
from pathlib import Path

import pytest

from workbench.app.core.people import Role
from workbench.app.records.sessions import new_session
from workbench.formats.cells.reading import read_cell
from workbench.web.access.passwords import NOBODYS
from workbench.web.access.store import Store
from workbench.web.access.users import Users

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A working directory with a cell and its part of its own, and a session."""
    home = tmp_path / "home"
    for name in ("robots/tx2_90", "parts/puck"):
        shutil.copytree(ROOT / name, home / name)
    monkeypatch.chdir(home)
    new_session(home / "sessions", read_cell("tx2_90"), time.time()).close()
    return home


def content(home: Path) -> dict[str, bytes]:
    return {
        file.relative_to(home).as_posix(): file.read_bytes()
        for file in home.rglob("*")
        if file.is_file()
    }


def with_files(source: Path, target: Path, **changes: bytes | None) -> None:
    """A copy of a zip file, some of it otherwise."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        files = {name: old.read(name) for name in old.namelist()} | changes
        for name, data in files.items():
            if data is not None:
                new.writestr(name, data)


def test_what_was_kept_comes_back(say, home, tmp_path):
    (session,) = (home / "sessions").iterdir()
    (session / "cases").mkdir()
    (session / "cases" / "20231114-221320-tx2_90-3.zip").write_bytes(b"a case")
    assert say("backup", tmp_path / "b.zip", "--with-sessions").code == 0
    before = content(home)
    shutil.rmtree(home / "parts")
    shutil.rmtree(home / "sessions")
    cell = home / "robots/tx2_90/cell.toml"
    cell.write_text(cell.read_text().replace("speed", "#speed", 1))
    (home / "robots/tx2_90/mine.txt").write_text("made since")
    said = say("restore", tmp_path / "b.zip")
    assert said.code == 0 and "replaced" in said.out and "new" in said.out
    (session,) = (home / "sessions").iterdir()
    assert say("session", "verify", session).code == 0
    again = content(home)
    assert again.keys() == before.keys()
    assert {k for k in before if before[k] != again[k]} <= {
        (session / "journal.sqlite").relative_to(home).as_posix()
    }
    assert say("restore", tmp_path / "b.zip").out.count("the same") == 2


def test_a_trial_changes_nothing(say, home, tmp_path):
    say("backup", tmp_path / "b.zip")
    shutil.rmtree(home / "parts/puck")
    before = content(home)
    said = say("restore", tmp_path / "b.zip", "--dry-run")
    assert said.code == 0 and "would be restored" in said.out and "new" in said.out
    assert content(home) == before


def test_sessions_are_kept_only_when_wanted_and_never_replaced(say, home, tmp_path):
    say("backup", tmp_path / "b.zip")
    assert not any(
        name.startswith("sessions") for name in zipfile.ZipFile(tmp_path / "b.zip").namelist()
    )
    say("backup", tmp_path / "c.zip", "--with-sessions")
    before = content(home)
    assert "left as it is" in say("restore", tmp_path / "c.zip").out
    assert content(home) == before


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"robots/tx2_90/cell.toml": b"name = 7"}, "cell.toml"),
        ({"parts/puck/part.toml": b"nonsense"}, "part.toml"),
        ({"backup.json": b"{}"}, "is no backup"),
        ({"backup.json": None}, "is no backup"),
        ({"backup.json": json.dumps({"format": "other/9"}).encode()}, "format 'other/9', expected"),
        ({"etc/passwd": b"root"}, "holds 'etc'"),
        ({"../evil": b"x"}, "no plain path"),
    ],
)
def test_a_backup_with_anything_bad_in_it_changes_nothing(say, home, tmp_path, changes, expected):
    say("backup", tmp_path / "b.zip")
    with_files(tmp_path / "b.zip", tmp_path / "bad.zip", **changes)
    before = content(home)
    said = say("restore", tmp_path / "bad.zip")
    assert said.code == 2 and expected in said.problem
    assert content(home) == before and not (tmp_path / "evil").exists()


def test_a_restore_that_is_interrupted_leaves_all_as_it_was(say, home, tmp_path, monkeypatch):
    say("backup", tmp_path / "b.zip")
    for file in ("robots/tx2_90/cell.toml", "parts/puck/part.toml"):
        (home / file).write_text((home / file).read_text() + "# edited\n")
    before, rename, moves = content(home), Path.rename, []

    def interrupted(path, target):
        moves.append(target)
        if len(moves) == 2:
            raise KeyboardInterrupt
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", interrupted)
    assert say("restore", tmp_path / "b.zip").code == 130
    assert content(home) == before


def test_a_changed_session_in_a_backup_is_found(say, home, tmp_path):
    say("backup", tmp_path / "b.zip", "--with-sessions")
    archive = zipfile.ZipFile(tmp_path / "b.zip")
    name = next(name for name in archive.namelist() if name.endswith(".sqlite"))
    forged = archive.read(name).replace(b"workbench-session/1", b"workbench-session/7")
    archive.close()
    with_files(tmp_path / "b.zip", tmp_path / "bad.zip", **{name: forged})
    said = say("restore", tmp_path / "bad.zip")
    assert said.code != 0 and "entry 1 was changed after it was written" in said.problem


def test_nothing_to_keep_is_refused(say, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = say("backup", tmp_path / "b.zip")
    assert said.code == 2 and "has neither cells" in said.problem
    assert not (tmp_path / "b.zip").exists()


@pytest.fixture
def with_users(home, say):
    """Anna, with a token, and Otto, who is disabled."""
    with closing(Store(home / "sessions/users.sqlite")) as store:
        users = Users(store)
        users.add("Anna", Role.ENGINEER, "correct horse")
        users.add("Otto", Role.OPERATOR, "battery staple")
        users.set_disabled("Otto", True)
        users.make_token("Anna", "gripper")
    return home / "sessions/users.sqlite"


def test_users_come_back_with_passwords_and_tokens_and_nobody_is_overwritten(
    say, with_users, tmp_path
):
    assert say("backup", tmp_path / "b.zip", "--with-users").code == 0
    assert (tmp_path / "b.zip").stat().st_mode & 0o077 == 0, "there are hashes in it"
    with closing(Store(with_users)) as store:
        Users(store).remove("Anna")
        Users(store).set_role("Otto", Role.VIEWER)
    said = say("restore", tmp_path / "b.zip", "--dry-run")
    assert said.code == 0 and "Anna" in said.out
    with closing(Store(with_users)) as store:
        assert [user.name for user in Users(store).all()] == ["Otto"]
    assert say("restore", tmp_path / "b.zip").code == 0
    with closing(Store(with_users)) as store:
        users = Users(store)
        anna, otto = users.all()
        assert (anna.role, [token.name for token in anna.tokens]) == (Role.ENGINEER, ["gripper"])
        assert users.by_password("Anna", "correct horse") == anna.person
        assert (otto.role, otto.is_disabled) == (Role.VIEWER, True), "who is there stays"


def test_users_are_left_out_unless_asked_for(say, with_users, tmp_path):
    assert say("backup", tmp_path / "b.zip").code == 0
    assert "users.json" not in zipfile.ZipFile(tmp_path / "b.zip").namelist()


def _user(name: str) -> bytes:
    user = {"name": name, "role": "viewer", "hash": NOBODYS, "is_disabled": False, "tokens": []}
    return json.dumps(user).encode()


@pytest.mark.parametrize(
    ("users", "says"),
    [
        (b"[]", "format"),
        (b"{", "users"),
        (b'{"format": "workbench-users/1", "users": [{}]}', "number 1"),
        (
            b'{"format": "workbench-users/1", "users": [{"name": "Eve", "role": "engineer", '
            b'"hash": "$argon2id$v=19$m=4194304,t=9,p=4$YSBzYWx0$AAAA", "is_disabled": false, '
            b'"tokens": []}]}',
            "no hash",
        ),
        (
            b'{"format": "workbench-users/1", "users": [%s, %s]}' % (_user("Eve"), _user("EVE")),
            "number 2 is there twice",
        ),
    ],
)
def test_users_that_nobody_has_kept_are_refused(say, with_users, tmp_path, users, says):
    assert say("backup", tmp_path / "b.zip").code == 0
    with_files(tmp_path / "b.zip", tmp_path / "bad.zip", **{"users.json": users})
    said = say("restore", tmp_path / "bad.zip")
    assert said.code == 2 and says in said.problem

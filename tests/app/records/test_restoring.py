"""A backup looked into and restored by a process of its own."""

import shutil
import zipfile
from contextlib import nullcontext

import pytest

from workbench.app.records.keeping import WITHOUT_SESSIONS, write_backup
from workbench.app.records.restoring import (
    BACKUPS,
    KEPT_USERS,
    Thing,
    look_apart,
    restore_and_log,
    restore_apart,
)
from workbench.formats.files.change_log import LOG
from workbench.formats.files.shipped import find
from workbench.model.errors import CommandRefused, InputError


@pytest.fixture
def home(tmp_path):
    for kind, name in (("robots", "tx2_90"), ("parts", "puck")):
        shutil.copytree(find(kind, name), tmp_path / "home" / kind / name)
    return tmp_path / "home"


def content(home):
    return {file: file.read_bytes() for file in home.rglob("*") if file.is_file()}


def test_looking_changes_nothing_and_restoring_what_was_told(home, tmp_path):
    kept = tmp_path / "kept.zip"
    write_backup(home, kept, WITHOUT_SESSIONS, {})
    first = content(home)
    (home / "robots" / "tx2_90" / "cell.toml").write_text("mine")
    before = content(home)
    told = look_apart(kept, home)
    assert told == (Thing("robots", "tx2_90", "replaced"), Thing("parts", "puck", "the same"))
    assert content(home) == before
    assert restore_apart(kept, home) == told
    assert content(home) == first


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"../../out": b"x"}, "no plain path"),
        ({"parts/puck/part.toml": b"name = 3"}, "name"),
        ({"strange": b"x"}, "which no backup does"),
        ({KEPT_USERS: b"{}"}, "restore it from a shell"),
        ({"robots/tx2_90/bomb.stl": b"\0" * 2**28}, "unpacks to more than"),
    ],
)
def test_what_is_broken_or_hostile_is_refused_whole(home, tmp_path, changed, says):
    kept, bad = tmp_path / "kept.zip", tmp_path / "bad.zip"
    write_backup(home, kept, WITHOUT_SESSIONS, {})
    with zipfile.ZipFile(kept) as old, zipfile.ZipFile(bad, "w", zipfile.ZIP_DEFLATED) as new:
        for name, data in ({name: old.read(name) for name in old.namelist()} | changed).items():
            new.writestr(name, data)
    (home / "robots" / "tx2_90" / "cell.toml").write_text("mine")
    before = content(home)
    with pytest.raises(InputError, match=says) as refused:
        restore_apart(bad, home)
    assert str(home) not in str(refused.value)
    assert content(home) == before


def test_what_is_replaced_is_kept_first_and_who_restored_is_in_the_log(home, tmp_path, monkeypatch):
    kept = tmp_path / "kept.zip"
    write_backup(home, kept, WITHOUT_SESSIONS, {})
    monkeypatch.chdir(home)
    checked = []

    def check():
        checked.append(BACKUPS.exists())
        with pytest.raises(CommandRefused, match="somebody restores a backup just now"):
            restore_and_log(lambda: nullcontext(kept), "kept.zip", "Bob", lambda: None)

    before = restore_and_log(lambda: nullcontext(kept), "kept.zip", "Ada", check)
    assert checked == [False, True], "before anything is written, and once more after the backup"
    assert before.is_file()
    (line,) = (BACKUPS / LOG).read_text().splitlines()
    assert '"Ada"' in line and before.name in line

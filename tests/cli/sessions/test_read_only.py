"""Sessions on media that nothing can be written to: verified, shown, replayed, packed."""

import os
import shutil
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from workbench.journal.journal import Journal
from workbench.model.errors import JournalError

ROOT = Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / "sessions" / "example"

MOUNTED = 'mount --bind "$0" "$0" && mount -o remount,ro,bind "$0" && exec "$@"'


def on_read_only(folder, *words):
    """Run a command that sees the folder as on a read-only medium."""
    command = ["unshare", "--map-root-user", "--mount", "sh", "-c", MOUNTED, str(folder)]
    return subprocess.run(
        [*command, *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )


@pytest.fixture
def medium(tmp_path):
    if shutil.which("unshare") is None or on_read_only(tmp_path, "true").returncode:
        pytest.skip("this machine does not let us mount anything")
    return Path(shutil.copytree(EXAMPLE, tmp_path / "medium"))


@pytest.mark.extensive
@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("verify",), "85 entries, unchanged"),
        (("show",), "cycle finished"),
        (("export", "--no-scene", "--out", "{}"), "MB"),
    ],
)
def test_a_session_is_read_where_nothing_can_be_written(medium, tmp_path, words, says):
    workbench = [sys.executable, "-m", "workbench", "session", words[0], medium]
    rest = [word.format(tmp_path / "out.zip") for word in words[1:]]
    done = on_read_only(medium, *workbench, *rest)
    assert done.returncode == 0, done.stderr
    assert says in done.stdout


def test_what_a_power_cut_left_beside_the_database_is_read_too(tmp_path, medium):
    writing = tmp_path / "writing"
    with closing(Journal(writing)) as journal:
        for number in range(7):
            journal.append("A", b"%d" % number)
        # As it lies while it is written to: most of it is not in the database yet.
        shutil.rmtree(medium)
        shutil.copytree(writing, medium)
    code = (
        "import sys; from pathlib import Path; from workbench.journal.journal import Journal\n"
        "journal = Journal(Path(sys.argv[1]))\n"
        "print(journal.count, journal.verify())\n"
        "try: journal.append('B', b'')\n"
        "except Exception as error: print(type(error).__name__, error)\n"
        "journal.close()\n"
    )
    done = on_read_only(medium, sys.executable, "-c", code, medium)
    first, second = done.stdout.splitlines()
    assert first == "7 ()"
    assert second.startswith("JournalError") and "nothing can be written there" in second


def test_what_cannot_be_written_leaves_nothing_behind(tmp_path, monkeypatch):
    folder = Path(shutil.copytree(EXAMPLE, tmp_path / "medium"))
    monkeypatch.setattr(os, "access", lambda path, how: False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    with closing(Journal(folder)) as journal:
        assert journal.verify() == ()
        assert len(list((tmp_path / "temporary").iterdir())) == 1
        with pytest.raises(JournalError, match="nothing can be written there"):
            journal.append("A", b"")
    assert list((tmp_path / "temporary").iterdir()) == []
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before

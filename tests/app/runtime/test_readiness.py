"""What is compiled is made ready once, by one process, with progress, and never stops anybody."""

import logging
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import pytest
from waiting import PATIENCE, wait_until

import workbench
from workbench.app.runtime import compiled_code, readiness
from workbench.app.runtime.compiled_code import is_ready
from workbench.app.runtime.readiness import NOTE, make_ready

HERE = Path(__file__).parents[1]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Nothing is compiled there yet, and who compiles says there what it does."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "compiled"))
    monkeypatch.setenv("TINY_FOLDER", str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", f"{HERE}:{HERE.parents[1]}")
    monkeypatch.setattr(readiness, "WARM_UP", "tiny_warm_up")
    monkeypatch.setattr(readiness, "take_shipped", lambda: None)
    return tmp_path


def begun(folder, use):
    return list(folder.glob(f"{use}-*"))


def test_everything_is_made_ready_once_and_told_with_the_share_done(folder):
    told = []
    assert not is_ready("seeing") and not is_ready("planning")
    assert make_ready(lambda done, note: told.append((done, note)))
    assert told[0] == (0.0, NOTE) and told[-1] == (1.0, NOTE)
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert {0.25} < {done for done, _ in told}
    assert is_ready("seeing") and is_ready("planning")


def test_what_is_ready_is_told_nothing_of_and_starts_no_process(folder, monkeypatch):
    make_ready(lambda done, note: None)
    monkeypatch.setattr(subprocess, "Popen", None)
    told = []
    assert make_ready(lambda done, note: told.append(note))
    assert told == []


def test_only_what_is_used_is_made_ready(folder):
    assert make_ready(lambda done, note: None, ("planning",))
    assert is_ready("planning") and not is_ready("seeing")


def test_other_sources_are_not_ready(folder, monkeypatch, tmp_path):
    make_ready(lambda done, note: None, ("planning",))
    copy = tmp_path / "workbench"
    shutil.copytree(Path(workbench.__file__).parent / "planning", copy / "planning")
    monkeypatch.setattr(compiled_code, "_package", lambda: copy)
    assert not is_ready("planning")
    compiled_code.mark_ready("planning")
    assert is_ready("planning")
    with (copy / "planning" / "collision" / "distances" / "gjk.py").open("a") as file:
        file.write("# changed\n")
    assert not is_ready("planning")


@pytest.mark.extensive
def test_what_was_compiled_of_other_sources_is_forgotten(folder, monkeypatch, tmp_path):
    """Also in files that did not change: code of those that did was compiled into them."""
    package = tmp_path / "package"
    (package / "planning").mkdir(parents=True)
    inner, outer = package / "planning" / "inner.py", package / "planning" / "outer.py"
    inner.write_text("from numba import njit\n@njit(cache=True)\ndef one(): return 1\n")
    outer.write_text(
        "from numba import njit\nfrom inner import one\n"
        "@njit(cache=True)\ndef two(): return one() + one()\n"
    )

    def said():
        code = f"import sys; sys.path.insert(0, {str(inner.parent)!r}); import outer\n"
        ended = subprocess.run(
            [sys.executable, "-c", f"{code}print(outer.two())"], capture_output=True, text=True
        )
        return int(ended.stdout)

    monkeypatch.setattr(compiled_code, "_package", lambda: package)
    assert said() == 2
    inner.write_text(inner.read_text().replace("return 1", "return 21"))
    assert said() == 2, "numba has learned to see it: then this can go"
    make_ready(lambda done, note: None)
    assert said() == 42
    inner.write_text(inner.read_text().replace("return 21", "return 4"))
    compiled_code.forget_the_old()
    assert said() == 8
    kept = sorted(tmp_path.rglob("outer*.nbc"))
    compiled_code.forget_the_old()
    assert kept and sorted(tmp_path.rglob("outer*.nbc")) == kept, "it is of these sources"


@pytest.mark.extensive
def test_a_script_runs_nothing_that_was_compiled_before_an_update(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    place = next(iter(compiled_code._find_caches()))
    place.mkdir(parents=True)
    old = place / "gjk.distance-1.py311.nbi"
    old.write_bytes(b"names a module that is gone")
    code = "import workbench as wb; wb.plan"
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
    assert not old.exists()


@pytest.fixture
def loop(monkeypatch, tmp_path):
    """The one compiled file of a package of its own, beside which code is kept."""
    package = tmp_path / "package"
    (package / "planning").mkdir(parents=True)
    (package / "__pycache__").mkdir()
    monkeypatch.setattr(compiled_code, "_package", lambda: package)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    return package / "planning" / "loop.py"


def test_what_was_compiled_beside_the_sources_is_taken_from_there(loop, monkeypatch, tmp_path):
    """So it is with a wheel that somebody else has installed."""
    loop.write_text("from numba import njit\n@njit(cache=True)\ndef one(): return 1\n")
    code = "import loop; loop.one(); print(sum(loop.one.stats.cache_hits.values()))"

    def found():
        about = os.environ | {"PYTHONPATH": str(loop.parent)}
        return int(subprocess.check_output([sys.executable, "-c", code], env=about))

    assert found() == 0
    for use in compiled_code.USES:
        compiled_code.mark_ready(use)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "own"))
    monkeypatch.setattr(subprocess, "Popen", None)
    assert not is_ready("seeing")
    assert make_ready(lambda done, note: None)
    monkeypatch.undo()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "own"))
    assert found() == 1


def test_what_was_compiled_of_other_sources_is_not_taken(loop, monkeypatch, tmp_path):
    loop.write_text("from numba import njit\n")
    for use in compiled_code.USES:
        compiled_code.mark_ready(use)
    loop.write_text("from numba import njit\nONE = 1\n")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "own"))
    compiled_code.take_shipped()
    assert not is_ready("seeing")


def test_a_library_that_prints_no_text_stops_nobody(folder):
    (folder / "garbled").touch()
    assert make_ready(lambda done, note: None, ("seeing",))


def test_what_cannot_be_compiled_ahead_stops_nobody_and_why_is_logged(folder, caplog):
    (folder / "broken").touch()
    with caplog.at_level(logging.WARNING):
        assert not make_ready(lambda done, note: None, ("seeing",))
    assert "ValueError: no compiler" in caplog.text
    (folder / "broken").unlink()
    assert make_ready(lambda done, note: None, ("seeing",))


def test_two_that_need_it_at_the_same_time_have_it_compiled_once(folder):
    (folder / "hold").touch()
    done = []
    threads = [
        threading.Thread(target=lambda: done.append(make_ready(lambda *_: None, ("seeing",))))
        for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    wait_until(lambda: begun(folder, "seeing"))
    (folder / "hold").unlink()
    for thread in threads:
        thread.join()
    assert done == [True, True]
    assert len(begun(folder, "seeing")) == 1


def test_who_compiles_ends_with_whom_it_compiles_for(folder):
    (folder / "hold").touch()
    program = textwrap.dedent(
        """
        from workbench.app.runtime import readiness
        readiness.WARM_UP = "tiny_warm_up"
        readiness.take_shipped = lambda: None
        readiness.make_ready(lambda done, note: print(done, flush=True), ("seeing",))
        """
    )
    waiting = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    wait_until(lambda: begun(folder, "seeing"))
    compiling = int(begun(folder, "seeing")[0].name.rpartition("-")[2])
    waiting.kill()
    waiting.communicate()
    assert waiting.returncode == -signal.SIGKILL
    wait_until(lambda: not _lives(compiling))
    (folder / "hold").unlink()
    assert make_ready(lambda done, note: None, ("seeing",))


def _lives(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.fixture
def installed(tmp_path):
    """A package that somebody else has installed: there is no room for what is compiled."""
    package = tmp_path / "installed" / "workbench"
    package.mkdir(parents=True)
    for file in ("__init__.py", "environment.py"):
        shutil.copy(Path(workbench.__file__).parent / file, package)
    (package / "__pycache__").write_text("a file, so that not even root can make the folder")
    loops = "from numba import njit\n@njit(cache=True)\ndef add(a, b):\n    return a + b\n"
    (package / "loops.py").write_text(loops)
    return package.parent


def kept_at(installed, **about):
    """Where a compiled function is kept, and whether it is there."""
    code = (
        "import os; from workbench.loops import add; add(1, 2); path = add.stats.cache_path; "
        "print(path); print(any(name.endswith('.nbc') for name in os.listdir(path)))"
    )
    known = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    said = subprocess.run(
        [sys.executable, "-c", code],
        env=known | {"PYTHONPATH": str(installed)} | about,
        cwd=installed,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=True,
    )
    path, is_kept = said.stdout.splitlines()
    assert is_kept == "True"
    return Path(path)


def test_where_the_package_cannot_be_written_code_is_kept_with_the_user(installed, tmp_path):
    kept = kept_at(installed, HOME=str(tmp_path / "ada"))
    assert kept.is_relative_to(tmp_path / "ada" / ".cache" / "workbench")
    kept = kept_at(installed, HOME=str(tmp_path), XDG_CACHE_HOME=str(tmp_path / "elsewhere"))
    assert kept.is_relative_to(tmp_path / "elsewhere" / "workbench")


def test_what_the_user_says_about_where_code_is_kept_counts(installed, tmp_path):
    kept = kept_at(installed, NUMBA_CACHE_DIR=str(tmp_path / "said"))
    assert kept.is_relative_to(tmp_path / "said")


def test_a_user_without_a_home_keeps_code_as_long_as_the_process_runs(installed, tmp_path):
    (tmp_path / "nowhere").write_text("no folder")
    (tmp_path / "tmp").mkdir()
    home = str(tmp_path / "nowhere" / "home")
    kept = kept_at(installed, HOME=home, TMPDIR=str(tmp_path / "tmp"))
    assert kept.is_relative_to(tmp_path / "tmp")
    assert list((tmp_path / "tmp").iterdir()) == []

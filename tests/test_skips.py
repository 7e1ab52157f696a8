"""A run ends with what it has skipped and why, in one process and in several."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = """
import pytest

@pytest.mark.skipif(True, reason="the recording is not here")
@pytest.mark.parametrize("number", [1, 2])
def test_of_a_recording(number): ...

def test_of_a_browser():
    pytest.skip("no browser here")

def test_of_nothing(): ...
"""


@pytest.mark.parametrize("workers", ["0", "2"])
def test_every_skip_is_listed_under_its_reason(tmp_path, workers):
    shutil.copy(Path(__file__).with_name("conftest.py"), tmp_path)
    (tmp_path / "test_some.py").write_text(TESTS)
    (tmp_path / "test_whole.py").write_text('import pytest\npytest.importorskip("no_such_thing")')
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    words = (
        "-m",
        "pytest",
        "-p",
        "xdist",
        "-n",
        workers,
        "-p",
        "no:cacheprovider",
        "-p",
        "no:dash",
        ".",
    )
    ran = subprocess.run(
        [sys.executable, *words],
        cwd=tmp_path,
        env=os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    told = ran.stdout.partition("skipped, and why")[2].splitlines()
    lines = [line for line in told if line.startswith(("    ", "1", "2"))]
    assert lines == [
        "1: could not import 'no_such_thing': No module named 'no_such_thing'",
        "    test_whole.py",
        "1: no browser here",
        "    test_some.py::test_of_a_browser",
        "2: the recording is not here",
        "    test_some.py::test_of_a_recording[1]",
        "    test_some.py::test_of_a_recording[2]",
    ], ran.stdout + ran.stderr


def test_a_run_without_skips_has_no_such_section(tmp_path):
    shutil.copy(Path(__file__).with_name("conftest.py"), tmp_path)
    (tmp_path / "test_some.py").write_text("def test_of_nothing(): ...")
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    words = ("-m", "pytest", "-p", "no:cacheprovider", "-p", "no:dash", ".")
    ran = subprocess.run(
        [sys.executable, *words],
        cwd=tmp_path,
        env=os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "1 passed" in ran.stdout and "skipped" not in ran.stdout

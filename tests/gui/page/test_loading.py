"""Libraries that are loaded ahead leave the exit code of a process as it is."""

import subprocess
import sys

import pytest

CODE = """
import sys, time
from workbench.gui.page.loading import loaded_ahead
with loaded_ahead():
    while {begun!r} not in sys.modules:
        time.sleep(0.001)
"""


@pytest.mark.extensive
@pytest.mark.parametrize("begun", ["open3d", "open3d.core", "dash", "open3d.ml"])
def test_a_process_that_ends_while_a_library_is_loaded_ends_with_0(begun):
    words = [sys.executable, "-c", CODE.format(begun=begun)]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert (ended.returncode, ended.stderr) == (0, "")

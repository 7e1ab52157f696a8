"""The unit for systemd is one that systemd understands, every line of it."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

UNIT = Path(__file__).resolve().parents[2] / "setup" / "workbench.service"


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="no systemd here")
def test_systemd_has_nothing_to_say_about_the_unit(tmp_path):
    # Where the workbench would be installed there may be nothing; any program will do.
    text = UNIT.read_text().replace("/opt/workbench/bin/workbench", sys.executable)
    assert sys.executable in text
    copy = tmp_path / "workbench.service"
    copy.write_text(text)
    said = subprocess.run(
        ["systemd-analyze", "verify", str(copy)], capture_output=True, text=True, check=False
    )
    assert (said.returncode, said.stdout, said.stderr) == (0, "", "")

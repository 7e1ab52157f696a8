"""The page of a new part, followed literally."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "new_part.md"


def test_the_page_leads_from_a_cad_file_to_a_proven_plan(tmp_path):
    blocks = re.findall(r"```sh\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 5
    (tmp_path / ".venv").symlink_to(sys.prefix)
    (tmp_path / "docs").mkdir()
    shutil.copy(ROOT / "docs" / "bracket.step", tmp_path / "docs")
    shutil.copytree(ROOT / "robots" / "yumi", tmp_path / "robots" / "yumi")
    shutil.copytree(ROOT / "parts", tmp_path / "parts")
    ran = subprocess.run(
        ["bash", "-euxo", "pipefail", "-c", "".join(blocks)],
        cwd=tmp_path,
        env={**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        timeout=800,
    )
    assert ran.returncode == 0, ran.stdout[-2000:] + ran.stderr[-4000:]
    assert "size 40, 24, 15 mm" in ran.stdout
    assert "nothing speaks against this part" in ran.stdout
    assert "proof holds" in ran.stdout
    assert (tmp_path / "plan.json").exists()

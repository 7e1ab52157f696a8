"""The wheel: holds what it needs, and plans far away from the checkout."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, timeout=120)
    (built,) = folder.glob("*.whl")
    return built


def test_it_holds_code_and_data_and_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"workbench"}
    for expected in (
        "workbench/cli/main.py",
        "workbench/shipped/robots/yumi/cell.toml",
        "workbench/shipped/robots/yumi/yumi.urdf",
        "workbench/shipped/parts/keyed_cylinder/grasps.toml",
        "workbench/shipped/static/page.css",
    ):
        assert expected in names
    assert not [name for name in names if "__pycache__" in name or name.endswith(".pyc")]


def test_unpacked_elsewhere_it_finds_its_own_cell_and_plans(wheel, tmp_path):
    installed, empty = tmp_path / "installed", tmp_path / "empty"
    empty.mkdir()
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(installed)
    poses = ROOT / "tests" / "cells" / "public_yumi" / "Poses.txt"
    # -P and the path come before the editable install, which leads to the checkout.
    environment = {**os.environ, "PYTHONPATH": str(installed), "PYTHONSAFEPATH": "1"}

    def run(*words: str) -> str:
        return subprocess.run(
            [sys.executable, *words],
            cwd=empty,
            env=environment,
            check=True,
            capture_output=True,
            text=True,
            timeout=250,
        ).stdout

    where = "from workbench.formats.shipped import find; print(find('robots', 'yumi'))"
    assert run("-c", where).strip().startswith(str(installed))
    said = run("-m", "workbench", "plan", "yumi", "--poses", str(poses), "--out", "plan.json")
    assert "the proof holds" in said
    assert "the proof holds" in run("-m", "workbench", "verify", "plan.json")

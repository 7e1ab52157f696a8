"""The wheel: holds what it needs, and plans far away from the checkout."""

import json
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
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, timeout=600)
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


@pytest.fixture(scope="module")
def venv(wheel, tmp_path_factory) -> Path:
    """An environment of its own with nothing but the wheel; dependencies are those of the tests."""
    folder = tmp_path_factory.mktemp("installed")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True, timeout=600)
    python = folder / "bin" / "python"
    ask = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(subprocess.check_output([python, "-c", ask], text=True, timeout=600).strip())
    # Paths in a .pth file lend packages, but not the editable install of the checkout.
    lent = [path for path in sys.path if path.endswith("site-packages")]
    (site / "dependencies.pth").write_text("\n".join(lent) + "\n")
    install = ["install", "--quiet", "--no-deps", "--no-index", str(wheel)]
    command = [sys.executable, "-m", "pip", "--python", str(python), *install]
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    return folder


def test_installed_elsewhere_it_runs_the_demo_on_its_own_cell(venv, tmp_path):
    def run(command: str, *words: str) -> str:
        return subprocess.run(
            [venv / "bin" / command, *words],
            cwd=tmp_path,
            check=True,
            capture_output=True,
            text=True,
            timeout=800,
        ).stdout

    where = "from workbench.formats.shipped import find; print(find('robots', 'yumi'))"
    assert run("python", "-c", where).strip().startswith(str(venv))
    told = json.loads(run("workbench", "demo", "--json"))
    assert told["ok"], told

"""The core where no extra is installed, nor what only extras need."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from waiting import PATIENCE

from workbench.model.errors import InputError
from workbench.plugins.extras import LIBRARIES, from_extra, not_installed

ROOT = Path(__file__).resolve().parents[2]
PIP = f"{sys.executable} -m pip install"
LACKING = ROOT / "tests" / "without_extras"


def lacking(*words: object) -> list[str]:
    return [sys.executable, "-m", "workbench", *map(str, words)]


@pytest.fixture
def world(tmp_path):
    paths = (str(LACKING), str(ROOT), os.environ.get("PYTHONPATH", ""))
    return {"env": os.environ | {"PYTHONPATH": os.pathsep.join(paths)}, "cwd": tmp_path}


def typed(world, *words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        lacking(*words), **world, capture_output=True, text=True, timeout=PATIENCE, check=False
    )


def test_from_a_check_of_the_cell_to_a_proven_plan(world):
    for words in (
        ("cell", "check", "yumi"),
        ("scan", "yumi", "--out", "scan.ply", "--seed", 1),
        ("localize", "yumi", "--scan", "scan.ply", "--out", "poses.json"),
        ("plan", "yumi", "--poses", "poses.json", "--out", "plan.json"),
        ("verify", "plan.json"),
    ):
        done = typed(world, *words)
        assert done.returncode == 0, (words, done.stderr)


def test_the_page_is_served(world):
    words = lacking("serve", "--port", 0)
    with subprocess.Popen(
        words, **world, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as page:
        assert any("http://" in line for line in iter(page.stdout.readline, ""))
        page.send_signal(signal.SIGINT)
        assert page.wait(PATIENCE) == 0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ("serve", "--port", 0, "--opcua", 4840),
            f"--opcua needs the library asyncua: {PIP} 'workbench[opcua]'",
        ),
        (
            ("serve", "--port", 0, "--modbus", 5020),
            f"--modbus needs the library pymodbus: {PIP} 'workbench[modbus]'",
        ),
        (
            ("opcua", "list"),
            f"this needs the library asyncua: {PIP} 'workbench[opcua]'",
        ),
        (("evidence", "folder"), "this needs workbench.extras.evidence, which is not installed"),
        (
            ("part", "from-scans", "folder", "--out", "model.ply"),
            "this needs workbench.extras.reconstruction, which is not installed",
        ),
        (
            ("import", "klampt", "world.xml", "--out", "mine"),
            "this needs workbench.extras.klampt, which is not installed",
        ),
        (("study", "bop", "folder"), "this needs workbench.extras.bop, which is not installed"),
    ],
)
def test_what_lacks_is_named(world, words, says):
    done = typed(world, *words)
    assert done.returncode == 2
    assert f"workbench: {says}" in done.stderr


def test_an_extra_that_is_there_gives_its_function():
    pytest.importorskip("pymodbus")
    assert from_extra("modbus.serving:serve_modbus", "").__name__ == "serve_modbus"
    with pytest.raises(ModuleNotFoundError, match="no_such_module"):
        from_extra("modbus.no_such_module:serve", "this needs")


@pytest.mark.parametrize(
    "missing, says",
    [
        ("asyncua.ua", f"the library asyncua: {PIP} 'workbench[opcua]'"),
        ("cryptography", f"the library cryptography: {PIP} 'workbench[opcua]'"),
        ("workbench.extras", f"the library asyncua: {PIP} 'workbench[opcua]'"),
    ],
)
def test_what_is_missing_is_named_and_not_what_is_there(monkeypatch, missing, says):
    def fails(name):
        raise ModuleNotFoundError(name, name=missing)

    monkeypatch.setattr("workbench.plugins.extras.importlib.import_module", fails)
    with pytest.raises(InputError) as error:
        from_extra("opcua.serving:serve_opcua", "--opcua needs")
    assert str(error.value) == f"--opcua needs {says}"


def test_a_library_that_no_extra_brings_is_named_alone(monkeypatch):
    def fails(name):
        raise ModuleNotFoundError(name, name="open3d")

    monkeypatch.setattr("workbench.plugins.extras.importlib.import_module", fails)
    with pytest.raises(InputError, match="needs the library open3d, which is not"):
        from_extra("reconstruction.commands:reconstruct")


def test_whatever_an_extra_needs_lacks_in_these_tests():
    lacks = (LACKING / "sitecustomize.py").read_text(encoding="utf-8")
    assert [library for library in LIBRARIES.values() if f'"{library}"' not in lacks] == []


def test_a_checkout_without_metadata_names_the_command_that_installs_it():
    assert str(not_installed()) == f"the workbench is not installed: {PIP} {ROOT}"

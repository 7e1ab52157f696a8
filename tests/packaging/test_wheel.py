"""The wheel: holds what it needs, and plans far away from the checkout."""

import contextlib
import hashlib
import json
import os
import pty
import shutil
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import pytest

from workbench.app.runtime.readiness import NOTE

ROOT = Path(__file__).resolve().parents[2]

PATIENCE = 3600
"""[s] For a whole cycle, which a busy machine takes its time for."""

UNWANTED = ("NUMBA_CACHE_DIR", "PYTHONPATH")
"""What would have the installed package compile, or be, somewhere else."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    compiling = [sys.executable, "-m", "workbench", "compile"]
    subprocess.run(compiling, cwd=ROOT, env=surroundings(), check=True, timeout=PATIENCE)
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
        "workbench/shipped/static/tables.css",
        "workbench/words/catalogs/de.po",
    ):
        assert expected in names
    kept = {name.rpartition(".")[2] for name in names if "__pycache__" in name}
    assert kept == {"nbi", "nbc", "ready"}


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="not a checkout")
def test_a_commit_gives_the_same_wheel_byte_by_byte(tmp_path):
    digests = set()
    for umask in (0o022, 0o077):
        copy = tmp_path / f"copy_{umask}"
        subprocess.run(["git", "clone", "-q", ROOT, copy], check=True, umask=umask, timeout=600)
        command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", "out"]
        subprocess.run(command, cwd=copy, check=True, capture_output=True, umask=umask, timeout=600)
        (built,) = copy.glob("out/*.whl")
        digests.add(hashlib.sha256(built.read_bytes()).hexdigest())
    assert len(digests) == 1


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


@pytest.fixture(scope="module")
def first_demo(venv, tmp_path_factory):
    """What the first demo printed, and what a terminal showed."""
    ours, theirs = pty.openpty()
    shown = bytearray()

    def watch():
        # The terminal ends with an error when nobody can write to it any more.
        with contextlib.suppress(OSError):
            while read := os.read(ours, 4096):
                shown.extend(read)

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        ended = subprocess.run(
            [venv / "bin" / "workbench", "demo", "--json"],
            cwd=tmp_path_factory.mktemp("elsewhere"),
            env=surroundings() | {"TERM": "xterm", "COLUMNS": "200"},
            stdout=subprocess.PIPE,
            stderr=theirs,
            timeout=PATIENCE,
        )
    finally:
        os.close(theirs)
        watcher.join()
        os.close(ours)
    assert ended.returncode == 0, shown.decode(errors="replace")[-2000:]
    return json.loads(ended.stdout), shown.decode(errors="replace")


def surroundings():
    return {name: value for name, value in os.environ.items() if name not in UNWANTED}


def said_in(venv, code, **about):
    return subprocess.run(
        [venv / "bin" / "python", "-c", code],
        cwd=venv,
        env=surroundings() | about,
        check=True,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    ).stdout


@pytest.mark.timeout(PATIENCE)
def test_installed_elsewhere_it_runs_the_demo_at_once_on_its_own_cell(venv, first_demo):
    where = "from workbench.formats.files.shipped import find; print(find('robots', 'yumi'))"
    assert said_in(venv, where).strip().startswith(str(venv))
    told, _ = first_demo
    assert told["ok"], told


@pytest.mark.timeout(PATIENCE)
def test_the_first_demo_waits_for_no_compiler(first_demo):
    _, shown = first_demo
    assert "find parts" in shown
    assert str(NOTE) not in shown


@pytest.mark.extensive
@pytest.mark.timeout(PATIENCE)
def test_who_may_not_write_where_it_is_installed_waits_for_none_either(venv, first_demo, tmp_path):
    own = tmp_path / "own"
    code = (
        "from workbench.app.runtime.readiness import make_ready; told = []\n"
        "print(make_ready(lambda done, note: told.append(note)), told)\n"
    )
    assert said_in(venv, code, NUMBA_CACHE_DIR=str(own)) == "True []\n"
    assert said_in(venv, COMPILED, NUMBA_CACHE_DIR=str(own)).count("compiled ") > 50


@pytest.fixture(scope="module")
def acme_device(venv, first_demo, tmp_path_factory):
    """Acme's package installed beside it, and the port of what stands for its scanner."""
    folder = tmp_path_factory.mktemp("acme")
    source = ROOT / "tests" / "plugins" / "acme"
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=source, check=True, capture_output=True, timeout=600)
    (built,) = folder.glob("*.whl")
    install = ["install", "--quiet", "--no-deps", "--no-index", str(built)]
    command = [sys.executable, "-m", "pip", "--python", str(venv / "bin" / "python"), *install]
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    device = subprocess.Popen(
        [venv / "bin" / "python", "-m", "acme_cell.device", "yumi"],
        cwd=folder,
        env=surroundings(),
        stdout=subprocess.PIPE,
        text=True,
    )
    yield int(device.stdout.readline())
    device.terminate()
    device.wait(600)
    device.stdout.close()


@pytest.mark.extensive
@pytest.mark.timeout(PATIENCE)
def test_a_package_of_somebody_else_runs_the_demo_with_its_own_devices(venv, acme_device, tmp_path):
    where = "from workbench.formats.files.shipped import find; print(find('robots', 'yumi'))"
    cell = tmp_path / "cell"
    shutil.copytree(said_in(venv, where).strip(), cell)
    text = (cell / "cell.toml").read_text()
    for old, new in (
        ('protocol = "abb-socket/2"', 'protocol = "acme-json"'),
        ('planner = "rrtconnect"', 'planner = "acme-vias"'),
        ("[scanner]", f'[scanner]\nsource = "acme"\naddress = "127.0.0.1:{acme_device}"'),
        ("[controller]", '[localizer]\nname = "acme-twice"\n\n[controller]'),
    ):
        assert old in text
        text = text.replace(old, new, 1)
    (cell / "cell.toml").write_text(text)
    workbench = [venv / "bin" / "workbench"]
    run = {"cwd": tmp_path, "env": surroundings(), "text": True, "timeout": PATIENCE}
    listed = json.loads(subprocess.check_output([*workbench, "plugins", "--json"], **run))
    theirs = [one for one in listed["plugins"] if one["package"] == "acme-cell"]
    assert len(theirs) == 6 and not any(one["problem"] for one in theirs)
    demo = [*workbench, "demo", "--cell", str(cell), "--speed", "50", "--json"]
    ended = subprocess.run(demo, capture_output=True, **run)
    assert ended.returncode == 0, ended.stdout[-3000:] + ended.stderr[-3000:]
    told = json.loads(ended.stdout)
    assert told["ok"] and told["cycles"][0]["parts_placed"] >= 1


COMPILED = """
import importlib, pkgutil
from pathlib import Path
from numba.core.dispatcher import Dispatcher
from workbench import formats, perception, planning
from workbench.app.runtime.compiled_code import USES, is_ready

assert all(map(is_ready, USES))
for layer in (formats, perception, planning):
    for found in pkgutil.walk_packages(layer.__path__, layer.__name__ + "."):
        module = importlib.import_module(found.name)
        for one in vars(module).values():
            is_own = isinstance(one, Dispatcher) and one.py_func.__module__ == found.name
            # What is inlined is compiled with what calls it.
            if is_own and one.targetoptions.get("inline") != "always":
                name = f"{one.py_func.__name__}-{one.py_func.__code__.co_firstlineno}.*.nbc"
                kept = list(Path(one.stats.cache_path).glob("*." + name))
                print("compiled" if kept else "left out:", found.name, one.py_func.__name__)
"""


@pytest.mark.extensive
@pytest.mark.timeout(PATIENCE)
def test_all_that_is_compiled_was_compiled_before_the_first_task(venv, first_demo):
    said = said_in(venv, COMPILED).splitlines()
    assert len(said) > 50
    assert [line for line in said if not line.startswith("compiled ")] == []

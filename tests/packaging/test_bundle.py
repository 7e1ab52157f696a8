"""The bundle: one folder that installs a distribution where there is no network."""

import hashlib
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SETUP = Path(__file__).resolve().parents[2] / "setup"

PROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"
[project]
name = "tiny"
version = "1.0"
[project.optional-dependencies]
more = []
old = ["there-is-no-wheel-of-this"]
test = ["this-is-for-developers"]
[project.scripts]
tiny = "tiny:main"
"""


@pytest.fixture(scope="module")
def packed(tmp_path_factory, request) -> Path:
    monkeypatch = pytest.MonkeyPatch()
    request.addfinalizer(monkeypatch.undo)
    monkeypatch.syspath_prepend(str(SETUP))
    import bundle  # pyright: ignore[reportMissingImports]

    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    monkeypatch.setattr(bundle, "ONLY_FOR", {"old": f"python_version < '{python}'"})

    project = tmp_path_factory.mktemp("project")
    (project / "pyproject.toml").write_text(PROJECT)
    (project / "tiny.py").write_text("def main():\n    print('it runs')\n")
    (project / "constraints.txt").write_text("")
    folder = tmp_path_factory.mktemp("bundle")
    assert bundle.fill(folder, project, project / "constraints.txt", [python]) == "tiny-1.0"
    return folder


@pytest.fixture
def bundle(packed, tmp_path) -> Path:
    return Path(shutil.copytree(packed, tmp_path / "bundle"))


def without_network() -> list[str]:
    """What a command begins with that sees no network, where that can be had here."""
    alone = ["unshare", "--user", "--map-root-user", "--net"]
    if shutil.which("unshare") and subprocess.run([*alone, "true"], check=False).returncode == 0:
        return alone
    return []


def install(bundle: Path, into: Path):
    return subprocess.run(
        [*without_network(), "sh", str(bundle / "install.sh"), str(into)],
        env={"PATH": "/usr/bin:/bin", "PYTHON": sys.executable},
        capture_output=True,
        text=True,
        timeout=1200,
    )


def test_it_installs_with_extras_but_those_for_developers(bundle, tmp_path):
    first, more, old = (bundle / "requirements.txt").read_text().splitlines()
    assert (first, more, old.split(";")[0]) == (
        "tiny",
        "tiny[more]; python_version >= '3.11'",
        "tiny[old]",
    )
    said = install(bundle, tmp_path / "here")
    assert said.returncode == 0, said.stderr
    assert str(tmp_path / "here") in said.stdout
    ran = subprocess.run([tmp_path / "here" / "bin" / "tiny"], capture_output=True, text=True)
    assert ran.stdout == "it runs\n"


@pytest.mark.parametrize("name", ["requirements.txt", "constraints.txt", "wheels/*.whl"])
def test_a_file_that_was_changed_on_the_way_installs_nothing(bundle, tmp_path, name):
    (file,) = bundle.glob(name)
    file.write_bytes(file.read_bytes() + b"#")
    said = install(bundle, tmp_path / "here")
    assert said.returncode == 2 and "nothing was installed" in said.stderr
    assert not (tmp_path / "here").exists()


def test_a_wheel_that_was_added_on_the_way_installs_nothing(bundle, tmp_path):
    (own,) = (bundle / "wheels").glob("*.whl")
    shutil.copy(own, own.with_name(own.name.replace("1.0", "1.1")))
    said = install(bundle, tmp_path / "here")
    assert said.returncode == 2 and "wheels that were not packed" in said.stderr
    assert not (tmp_path / "here").exists()


def test_an_installation_that_fails_leaves_nothing_behind(bundle, tmp_path):
    (bundle / "requirements.txt").write_text("not-in-the-bundle\n")
    names = [path for path in sorted(bundle.rglob("*")) if path.is_file()]
    sums = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(bundle)}\n"
        for path in names
        if path.name != "SHA256SUMS"
    ]
    (bundle / "SHA256SUMS").write_text("".join(sums))
    said = install(bundle, tmp_path / "here")
    assert said.returncode not in (0, 2) and "not-in-the-bundle" in said.stderr
    assert not (tmp_path / "here").exists()


def test_what_is_there_is_left_alone(bundle, tmp_path):
    (tmp_path / "here").mkdir()
    said = install(bundle, tmp_path / "here")
    assert said.returncode == 2 and "is there already" in said.stderr
    assert not any((tmp_path / "here").iterdir())


def test_without_a_python_that_fits_it_says_what_to_install(bundle, tmp_path):
    said = subprocess.run(
        ["sh", str(bundle / "install.sh"), str(tmp_path / "here")],
        env={"PATH": "/usr/bin:/bin", "PYTHON": "no-such-python"},
        capture_output=True,
        text=True,
    )
    assert said.returncode == 2 and "Python 3.11, 3.12 or 3.13" in said.stderr

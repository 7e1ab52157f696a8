"""Acme's package, installed for these tests alone."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from installed_package import Plugged

from workbench.plugins import found

ACME = Path(__file__).parent / "acme"

# Its own tests are run as its maker would run them: see `test_pages`.
collect_ignore = ["acme"]


@pytest.fixture(scope="package")
def acme_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where `pip install` has put the package."""
    folder = tmp_path_factory.mktemp("acme")
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index"]
    command += ["--no-build-isolation", "--target", str(folder), str(ACME)]
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    return folder


@pytest.fixture
def acme(acme_folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """It is there, in this process."""
    monkeypatch.syspath_prepend(str(acme_folder))
    Plugged.forget()
    yield
    monkeypatch.undo()
    for name in [name for name in sys.modules if name.partition(".")[0] == "acme_cell"]:
        del sys.modules[name]
    Plugged.forget()


@pytest.fixture
def plugged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Plugged]:
    """Installs packages that a test writes."""
    yield Plugged(tmp_path / "site", monkeypatch)
    monkeypatch.undo()
    found._foreign.cache_clear()
    found._load.cache_clear()

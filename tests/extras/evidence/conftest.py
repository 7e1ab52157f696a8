"""One bundle for all, and the small cell."""

import shutil
import zipfile
from pathlib import Path

import pytest
from samples import cell, samples  # noqa: F401
from tampering import AT, OURS, Opened, anchors_of

from workbench.extras.evidence.bundle import write_bundle
from workbench.journal.journal import Journal

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """A bundle, the script that came with it, and anchors of the journal."""
    folder = tmp_path_factory.mktemp("evidence")
    shutil.copytree(ROOT / "sessions" / "example", folder / "example")
    journal = Journal(folder / "example")
    try:
        write_bundle(journal, folder / "bundle.zip", AT, OURS)
    finally:
        journal.close()
    with zipfile.ZipFile(folder / "bundle.zip") as archive:
        archive.extract("verify.py", folder)
    (folder / "anchors").write_text(anchors_of(Opened(folder / "bundle.zip")))
    return folder

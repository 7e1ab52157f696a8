"""Commands of a page, followed literally in one process, which has the compiled code already."""

import shlex
from pathlib import Path

import pytest

from workbench.cli.main import main

ROOT = Path(__file__).resolve().parents[1]


def follow(block: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the commands of a block in a folder that has the shipped robots and parts."""
    for name in ("robots", "parts"):
        (folder / name).symlink_to(ROOT / name)
    monkeypatch.chdir(folder)
    for program, *words in map(shlex.split, block.splitlines()):
        assert program == ".venv/bin/workbench"
        assert main(words) == 0, words

"""Where code lies: folders that name ideas, few files in each, and tests beside them."""

import ast
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "workbench"
FOLDERS = sorted(path.parent for path in PACKAGE.rglob("__init__.py"))
MOST_FILES = 16
MOST_LINES = 400

WHOLE = {"browser", "cells", "examples", "foreign", "golden", "packaging", "portable", "robots"}
"""What is tried as a whole lies in folders of its own."""

every_folder = pytest.mark.parametrize(
    "folder", FOLDERS, ids=lambda path: str(path.relative_to(ROOT))
)


@every_folder
def test_a_folder_holds_few_files_and_says_what_they_are(folder):
    files = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
    assert len(files) <= MOST_FILES, [path.name for path in files]
    assert ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8")))


def test_no_folder_is_without_a_docstring():
    assert {path.parent for path in PACKAGE.rglob("*.py")} == set(FOLDERS)


def test_no_file_is_long():
    long = [
        (str(path.relative_to(ROOT)), count)
        for top in (PACKAGE, ROOT / "tests", ROOT / "docs")
        for path in top.rglob("*.py")
        if (count := len(path.read_text(encoding="utf-8").splitlines())) > MOST_LINES
    ]
    assert long == []


def test_tests_lie_as_the_code_does():
    tests = ROOT / "tests"
    for file in tests.rglob("test_*.py"):
        folder = file.parent.relative_to(tests)
        is_foreign = any(
            (up / "pyproject.toml").is_file() for up in file.parents if tests in up.parents
        )
        if folder.parts and folder.parts[0] not in WHOLE and not is_foreign:
            assert (PACKAGE / folder / "__init__.py").is_file(), f"tests/{folder} has no such code"


def test_the_tree_in_the_documents_is_that_of_the_code(monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path, str(ROOT / "docs")])
    from make_tree import PAGE, whole

    page = PAGE.read_text(encoding="utf-8")
    assert whole(page) == page, "python docs/make_tree.py makes it anew"


def test_the_picture_of_the_layers_is_that_of_the_code(monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path, str(ROOT / "docs")])
    from make_layers import PICTURE, drawing

    told = PICTURE.read_text(encoding="utf-8")
    assert told == drawing(), "python docs/make_layers.py draws it anew"


def test_arrows_that_follow_from_others_are_left_out(monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path, str(ROOT / "docs")])
    from make_layers import without_detours

    graph = {"top": {"middle", "other", "bottom"}, "middle": {"bottom"}, "other": set()}
    arrows = without_detours({**graph, "bottom": set[str]()})
    assert arrows == [("top", "middle"), ("top", "other"), ("middle", "bottom")]


OF_ABB = ("devices/abb_", "devices/rapid/", "formats/rapid/")
OF_ALL_MAKERS = ("formats/poses/conventions.py", "cli/arguments/cell.py")
"""How the pendants of nine makers write a pose."""


def test_no_maker_of_robots_is_known_outside_of_its_own_folders():
    known = [
        str(path.relative_to(PACKAGE))
        for path in PACKAGE.rglob("*.py")
        if not path.relative_to(PACKAGE).as_posix().startswith(OF_ABB + OF_ALL_MAKERS)
        and re.search(r"\babb\b|abb[_-]", path.read_text(encoding="utf-8"), re.I)
    ]
    assert known == []

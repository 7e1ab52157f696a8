"""What the documents say is there, and what is there stands in the documents."""

import ast
import re
import typing
from pathlib import Path

import pytest

from workbench.app import commands
from workbench.app.state import Phase
from workbench.cli import arguments
from workbench.model.candidate import Reason

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (page.parent / link).exists()]
    assert missing == []


def test_every_room_is_described():
    rooms = {path.parent.name for path in (ROOT / "workbench").glob("*/__init__.py")}
    assert len(rooms) == 11
    for room in rooms:
        assert f"| `{room}` |" in ARCHITECTURE


def test_every_file_that_is_named_exists():
    named = set(re.findall(r"`((?:[a-z_]+/)+[a-z_]+\.(?:py|toml|md))", ARCHITECTURE))
    assert len(named) > 20
    for name in named:
        assert (ROOT / "workbench" / name).exists() or (ROOT / name).exists(), name


def test_every_name_after_a_colon_is_in_its_file():
    named = re.findall(r"`((?:[a-z_]+/)+[a-z_]+\.py):([A-Za-z_]+)", ARCHITECTURE)
    assert named
    for file, name in named:
        tree = ast.parse((ROOT / "workbench" / file).read_text(encoding="utf-8"))
        assert name in {
            node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)
        }, f"{file}:{name}"


def test_every_command_phase_and_verdict_is_listed():
    asked = {one.__name__ for one in typing.get_args(commands.Command)}
    assert len(asked) > 10
    for name in (*asked, *Phase):
        assert f"`{name}`" in ARCHITECTURE, name
    for reason in Reason:
        assert reason.name in ARCHITECTURE


def test_every_typed_command_stands_in_the_readme():
    verbs = [typing.get_args(one)[1].name for one in typing.get_args(arguments.Arguments)]
    assert len(verbs) == 22
    for verb in verbs:
        assert f"workbench {verb}" in README


def test_every_make_target_of_the_readme_exists():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in set(re.findall(r"make ([a-z]+) ", README)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target

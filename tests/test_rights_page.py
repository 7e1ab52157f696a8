"""The lists of rights in the documents are those of the code."""

import re
from pathlib import Path

from workbench.app.core.commands import COMMANDS

PAGE = (Path(__file__).parents[1] / "docs" / "rights.md").read_text(encoding="utf-8")


def listed(name: str) -> list[str]:
    """The commands behind a name, on its line and those that continue it."""
    (found,) = re.findall(rf"^- {name}: (.*(?:\n  .*)*)", PAGE, re.MULTILINE)
    return re.findall(r"`(\w+)`", found)


def test_every_command_of_people_stands_there_with_its_rights():
    people = [command for command in COMMANDS if not command.right.by_machine]
    for role in ("operator", "engineer"):
        assert listed(role) == [one.__name__ for one in people if one.right.role == role]
    assert listed("always") == [one.__name__ for one in people if one.right.without_control]
    assert {one.right.role for one in people} == {"operator", "engineer"}

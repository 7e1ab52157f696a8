"""The list of rights in the documents is that of the code."""

from pathlib import Path

from workbench.app.core.command import Right
from workbench.app.core.commands import COMMANDS

PAGE = Path(__file__).parents[1] / "docs" / "rights.md"


def row(command: type, right: Right) -> str:
    always = ", always" if right.without_control else ""
    return f"- `{command.__name__}` ({right.role}{always}): {right.says}"


def test_every_command_of_people_stands_there_with_its_rights():
    stands = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line[:3] == "- `"]
    expected = [row(command, command.right) for command in COMMANDS if not command.right.by_machine]
    assert stands == expected

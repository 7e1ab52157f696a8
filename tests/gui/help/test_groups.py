"""The help of the groups: each group that the page makes has its own, and a section to read on."""

import ast
import re
from pathlib import Path

import pytest

from workbench.gui.help.groups import HELP, help_html
from workbench.web.page.manual import FILES

ROOT = Path(__file__).resolve().parents[3]


def called(node):
    function = node.func
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def groups():
    """The names of all groups of the page, by the calls that make them."""
    for file in sorted((ROOT / "workbench" / "gui").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and called(node) in ("group", "add_folder", "help_html"):
                yield from (
                    one.value for one in node.args if isinstance(getattr(one, "value", None), str)
                )


def test_every_group_has_help_and_there_is_none_for_others():
    assert set(groups()) == set(HELP)
    assert len(HELP) > 20


@pytest.mark.parametrize("name", HELP)
def test_help_is_three_sentences_or_four_and_leads_to_a_section_of_the_manual(name):
    text, section = HELP[name]
    assert len(re.findall(r"[.](?: |$)", text)) in (3, 4)
    manual = "".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in FILES)
    headings = re.findall(r"^## (.*)$", manual, re.MULTILINE)
    assert section in [
        re.sub(r"[^a-z0-9 -]", "", one.lower()).replace(" ", "-") for one in headings
    ]
    assert f'href="/manual#{section}"' in help_html(name)

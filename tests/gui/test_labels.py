"""Documents and page use the same words: what is bold in a manual stands on a control."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

MANUALS = (
    "operator.md",
    "setting_up.md",
    "new_part.md",
    "access.md",
    "integrator.md",
    "scanners.md",
    "calibration.md",
    "robot_links.md",
)
"""What they set in bold, and end without a full stop, is a label."""

NUMBER, UNIT = re.compile(r"\d+ · "), re.compile(r" \[\w+\]$")
PLACE = re.compile(r"\{\w+(?::[^{}]*)?\}")


def labels() -> Iterator[str]:
    """Every text that the page's code may show, as a regular expression."""
    for file in sorted((ROOT / "workbench" / "gui").rglob("*.py")):
        nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
        told = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        for node in nodes:
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                # What stands alone is a docstring.
                for text in NUMBER.sub("", node.value).split(", ") if id(node) not in told else ():
                    pieces = PLACE.split(UNIT.sub("", text))
                    yield r"\w+".join(map(re.escape, pieces))
            elif isinstance(node, ast.JoinedStr):
                yield "".join(
                    re.escape(str(one.value)) if isinstance(one, ast.Constant) else r"\w+"
                    for one in node.values
                )
    for file in sorted((ROOT / "static").glob("*.html")):
        for text in re.findall(r">([^<>]+)<", file.read_text(encoding="utf-8")):
            yield re.escape(text.strip())


@pytest.fixture(scope="module")
def known() -> re.Pattern[str]:
    found = sorted(one for one in set(labels()) if re.search("[A-Za-z]{2}", one))
    return re.compile("|".join(found))


def named(manual: str) -> Iterator[str]:
    """What a manual calls a control."""
    text = (ROOT / "docs" / manual).read_text(encoding="utf-8")
    for bold in re.findall(r"\*\*([A-Z][^*]*[^*.])\*\*", text):
        yield from re.sub(r"\s+", " ", bold).split(" > ")


@pytest.mark.parametrize("manual", MANUALS)
def test_what_manuals_tell_to_press_is_on_the_page(manual, known):
    missing = [name for name in named(manual) if not known.fullmatch(name)]
    assert missing == []


def test_a_manual_names_many_controls_and_a_made_up_name_is_noticed(known):
    assert len({*named("operator.md"), *named("setting_up.md")}) > 60
    assert not known.fullmatch("Frobnicate") and known.fullmatch("Left picked")

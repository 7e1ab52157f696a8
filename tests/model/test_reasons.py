"""Whoever adds a reason of a verdict finds here what still lacks it."""

import re
from pathlib import Path

import pytest

from workbench.gui.shared.colours import VERDICTS
from workbench.model.candidate import Reason
from workbench.model.messages.verdicts import ReasonText

DOCS = Path(__file__).parents[2] / "docs"


def test_each_reason_has_words_and_a_colour():
    assert [reason.name for reason in Reason] == [text.name for text in ReasonText]
    assert set(VERDICTS) == set(Reason)


def test_the_architecture_lists_the_reasons():
    text = (DOCS / "architecture.md").read_text()
    paragraph = text[text.index("Verdicts are a closed set") :].split("\n\n")[0]
    assert set(re.findall(r"\b[A-Z]+(?:_[A-Z]+)*\b", paragraph)) == {each.name for each in Reason}


@pytest.mark.parametrize("reason", Reason)
def test_the_guide_explains_each_reason_in_the_words_of_the_page(reason):
    text = (DOCS / "setting_up.md").read_text()
    names = re.findall(r"^- \*\*(.+?)\*\*: ", text, re.MULTILINE)
    assert str(reason.message) in {name for each in names for name in each.split(", ")}

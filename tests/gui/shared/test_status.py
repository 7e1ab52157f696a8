"""The status above the tabs, and the warning below it."""

import re
from dataclasses import replace

import pytest

from workbench.app.core.state import Phase, State
from workbench.formats.cells.reading import read_cell
from workbench.gui.shared import views
from workbench.words.words import words_of


@pytest.mark.parametrize("language", ["de", "it", "fr", "es", "zh"])
def test_the_warning_of_other_software_is_read_in_every_language(language):
    since = "session 20260101-yumi"
    state = State(read_cell("yumi"), changed=("the cell differs",), changed_since=since)
    said = words_of(language).html(views.changes_html(state))
    assert "20260101-yumi" in said
    assert not {"nothing", "before", "differs"} & set(re.findall("[a-z]+", said))


def test_a_long_status_is_set_smaller_and_a_fault_is_not(view_of):
    state = State(read_cell("yumi"), message="plan " * 30)
    assert "wb-long" in views.status_html(view_of(state))
    assert "wb-long" not in views.status_html(view_of(replace(state, message="short")))
    failed = replace(state, phase=Phase.FAULT, fault="no answer " * 20)
    assert "wb-long" not in views.status_html(view_of(failed))

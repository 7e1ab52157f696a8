"""When a backup may be restored from the page, and what is told of it."""

from dataclasses import replace

import pytest

from workbench.app.core.state import Phase, State
from workbench.app.records.restoring import Thing
from workbench.formats.cells.reading import read_cell
from workbench.gui.statistics.views import changes_any, not_restored, things_html
from workbench.model.messages.work import LinkText


@pytest.fixture
def state():
    cell = read_cell("yumi")
    return State(cell, saved=cell.digest)


def test_it_is_refused_where_something_relies_on_what_is_there(state):
    assert not_restored(state, LinkText.STANDS()) == ""
    assert "a plan is approved" in not_restored(
        replace(state, phase=Phase.APPROVED), LinkText.STANDS()
    )
    assert "the robot moves" in not_restored(state, LinkText.MOVES(arm="right"))
    assert "nobody has saved" in not_restored(replace(state, saved="another"), None)


def test_what_would_change_is_told_thing_by_thing():
    things = (Thing("robots", "yumi", "replaced"), Thing("parts", "<b>", "the same"))
    said = things_html("kept.zip", things)
    assert "Cell yumi" in said and "is replaced" in said and "<b>" not in said
    assert changes_any(things) and not changes_any(things[1:])

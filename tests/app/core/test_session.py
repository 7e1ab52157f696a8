"""Notes of people in a session."""

import pytest
from line import Line, refused

from workbench.app.core.session import WriteNote


def test_a_note_is_the_last_thing_that_happened_and_changes_nothing_else(cell):
    line = Line(cell)
    before = line.state
    after = line.do(WriteNote("pads of the left gripper changed"))
    assert str(after.message) == "ada notes: pads of the left gripper changed"
    assert (after.phase, after.cell, after.plan) == (before.phase, before.cell, before.plan)
    assert not line.effects


@pytest.mark.parametrize("text", ["", "  ", "two\nlines", "x" * 201, 7])
def test_an_empty_or_unprintable_note_is_refused(cell, text):
    assert refused(Line(cell), WriteNote(text))

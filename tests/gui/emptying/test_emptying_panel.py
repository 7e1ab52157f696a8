"""The tab in which piles are emptied, without a browser."""

from dataclasses import replace

from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.gui.emptying.panel import EmptyingPanel


def test_a_part_that_was_just_made_is_the_one_to_be_emptied(visitor, states, view_of):
    panel = EmptyingPanel(visitor)
    before = view_of(states.idle)
    panel.show(None, before)
    bolt = read_part(find("parts", "bolt"))
    cell = states.idle.cell
    more = view_of(replace(states.idle, cell=replace(cell, parts=(*cell.parts, bolt))))
    panel.show(before, more)
    assert panel._kind.value == "bolt"


def test_the_film_has_controls_once_a_pile_was_emptied(visitor, states, view_of):
    panel = EmptyingPanel(visitor)
    panel.show(None, view_of(states.idle))
    assert not panel._film._group.visible

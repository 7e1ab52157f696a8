"""Fields of a grasp that are typed and not applied: nothing that a person presses drops them."""

from dataclasses import replace

import pytest
from few_grasps import HAND, PART, grasp_now, with_grasps

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.people import Role
from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.gui.cell.panel import CellPanel
from workbench.gui.grasps.panel import GraspsPanel

APPLY_FIRST = 'Apply or revert the fields of grasp "side" first, in the tab Grasps'


OTHER = replace(HAND, name="top")


@pytest.fixture
def typed(bench, visitor):
    """The tab with another opening typed for the first of two grasps, and not applied."""
    with_grasps(bench, HAND, OTHER)
    panel = GraspsPanel(visitor)
    panel._draw()
    panel._fields._opening.value = 33.0
    return panel


def test_what_is_typed_for_a_grasp_stays_when_another_one_is_clicked_on(typed, visitor):
    typed._chose(1)
    assert typed._editing.entry.name == "side" and typed._fields._opening.value == 33.0
    assert 'grasp "side" first' in visitor.client.told[-1]
    typed._fields._fill(typed._fields._seen)
    typed._chose(1)
    assert typed._editing.entry.name == "top"


def test_numbers_of_a_pose_stay_when_another_grasp_is_clicked_on(typed):
    typed._fields._fill(typed._fields._seen)
    typed._pose._position.value = (0.0, 0.0, 3.0)
    typed._chose(1)
    assert typed._editing.entry.name == "side"
    assert typed._pose._position.value == (0.0, 0.0, 3.0)
    typed._chose(0)  # drops them
    typed._chose(1)
    assert typed._editing.entry.name == "top"


def test_a_grasp_that_is_added_is_chosen_unless_something_is_typed(typed, bench):
    typed._editing.add((replace(HAND, name="new"),), "a new grasp")
    assert typed._editing.entry.name == "side"
    typed._fields._fill(typed._fields._seen)
    typed._editing.add((replace(HAND, name="newer"),), "a new grasp")
    assert typed._editing.entry.name == "newer"


def test_what_is_typed_for_a_grasp_stays_when_another_part_is_chosen(typed, bench):
    cell = bench.state.cell
    bolt = read_part(find("parts", "bolt"))
    both = replace(cell, parts=(*cell.parts, bolt))
    bench.do(ChangeCell(both, "another part"), "Ada", Role.ENGINEER)
    typed._draw()
    typed._fields._opening.value = 33.0
    typed._part.value = bolt.name
    assert typed._part.value == typed._editing.part.name == PART
    assert typed._fields._opening.value == 33.0


def test_the_tab_cell_saves_nothing_while_a_grasp_is_typed(typed, bench, visitor):
    cell, before = CellPanel(visitor), bench.state
    cell._save_cell()
    assert bench.state is before and 'grasp "side" first' in visitor.client.told[-1]


def test_what_is_typed_for_a_grasp_is_applied_or_reverted_before_it_is_saved(bench, visitor):
    with_grasps(bench, HAND)
    panel = GraspsPanel(visitor)
    panel._draw()
    save, changes, fields = panel._library._save, panel._library._changes, panel._fields
    assert not save.disabled
    fields._name.value = "another name"
    assert save.disabled and save.hint == APPLY_FIRST
    assert "Apply or revert" in changes.content
    panel._library._save_library()
    assert "apply or revert" in visitor.client.told[-1]
    fields._take()
    assert grasp_now(bench).name == "another name" and not save.disabled
    panel._pose._position.value = (0.0, 0.0, 3.0)
    assert save.disabled and "Move it there" in changes.content
    panel._chose(0)
    assert not save.disabled and panel._pose._position.value == (0.0, 0.0, 20.0)

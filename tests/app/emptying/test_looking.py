"""From where a pile is scanned in simulation: each view of a scanner on an arm, and the paths."""

import pytest
from arm_scanner_cell import on_arm_cell, with_lower_view

from workbench.app.emptying.empty import empty_pile
from workbench.app.emptying.looking import from_next_view, scan_pile
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.derived.by_view import view_name
from workbench.model.prediction import PileTask
from workbench.perception.simulation.piles import pile_of


@pytest.fixture(scope="module")
def cell() -> Cell:
    return with_lower_view(on_arm_cell(), merges=True)


def test_a_merged_scan_is_from_each_view_and_the_arm_stands_at_the_last_one(cell):
    lying = pile_of(cell, "", 3, seed=1)
    look = scan_pile(cell, lying, seed=1)
    assert [view.name for view in look.scan.views] == ["bin", "low"]
    assert (look.scans, view_name(look.cell)) == (2, "low")
    assert look.motion > 0.1
    again = scan_pile(look.cell, lying, seed=2)
    assert [view.name for view in again.scan.views] == ["low", "bin"]
    # There is no view that it has not been scanned from.
    assert from_next_view(cell, seed=1) == (cell, 0.0)


def test_a_view_to_which_no_path_leads_is_left_out(cell):
    # There the hand is in the bin, which counts as full.
    deep = with_lower_view(on_arm_cell(), by=0.35, merges=True)
    look = scan_pile(deep, pile_of(cell, "", 2, seed=1), seed=1)
    assert (look.scans, look.motion, look.cell) == (1, 0.0, deep)


def test_without_merging_the_next_view_follows_by_a_proven_path():
    cell = with_lower_view(on_arm_cell())
    look = scan_pile(cell, pile_of(cell, "", 2, seed=1), seed=1)
    assert (look.scans, look.scan.views) == (1, ())
    following, seconds = from_next_view(cell, seed=1)
    assert view_name(following) == "low" and seconds > 0.1
    standing = read_cell("yumi")
    assert from_next_view(standing, seed=1) == (standing, 0.0)


@pytest.mark.extensive
def test_a_pile_is_emptied_by_merged_scans(cell):
    task = PileTask("", "", 3, 4, seen="scan")
    pile = empty_pile(cell, task, pile_of(cell, "", 3, seed=4))
    assert pile.taken == 3 and pile.touches == 0
    # Each plan has had a scan from both views, and their paths count.
    assert pile.scans == 2 * pile.cycles

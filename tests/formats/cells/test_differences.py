"""What differs between two cells is told in an order that does not change from run to run."""

from dataclasses import replace

import pinocchio as pin

from workbench.formats.cells.differences import difference
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Fixture


def test_fixtures_are_told_in_the_order_of_the_cells():
    cell = replace(read_cell("tx2_90"), fixtures=())
    names = [f"fixture {number}" for number in range(20)]
    full = replace(cell, fixtures=tuple(Fixture(n, pin.SE3.Identity(), ()) for n in names))
    gone = "fixture 0 was removed; fixture 1 was removed; fixture 2 was removed"
    assert str(difference(full, cell)) == f"{gone}; 17 more differences"
    come = "fixture 0 was added; fixture 1 was added; fixture 2 was added"
    assert str(difference(cell, full)) == f"{come}; 17 more differences"


def test_a_bin_that_loses_its_walls_is_told_and_one_that_gets_some():
    cell = read_cell("yumi")
    table = replace(cell, bin=replace(cell.bin, has_walls=False))
    assert str(difference(cell, table)) == "the bin has no walls any more"
    assert str(difference(table, cell)) == "the bin has walls now"

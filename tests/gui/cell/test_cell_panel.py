"""The tab of the cell: what is typed for a save goes with it."""

from dataclasses import replace

from workbench.app.core.commands import ChangeCell
from workbench.app.runtime.live import Live
from workbench.gui.cell.panel import CellPanel
from workbench.gui.shared.look import View
from workbench.gui.shared.things import moved
from workbench.model.geometry import pose_from_rpy


def test_a_remark_goes_once_it_is_saved(bench, visitor):
    def shown(state) -> View:
        return View(state, Live(), visitor.look.now, (), 0.0)

    panel = CellPanel(visitor)
    cell = bench.state.cell
    there = pose_from_rpy((0.0, 0.0, 0.01)) * cell.bin.T_world_bin
    changed = bench.do(ChangeCell(moved(cell, "bin", there), "the bin is moved"), "Ada")
    panel.show(None, shown(changed))
    panel._remark.value = "the bin was moved"
    panel._saved()
    told = replace(changed, message="saving")
    panel.show(shown(changed), shown(told))
    assert panel._remark.value == "the bin was moved", "it is not in the file yet"
    panel.show(shown(told), shown(replace(changed, saved=changed.cell.digest)))
    assert panel._remark.value == ""


def test_a_remark_that_was_not_saved_stays(bench, visitor):
    panel = CellPanel(visitor)
    panel._remark.value = "nothing has changed"
    panel._saved()
    assert visitor.client.told
    panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))
    assert panel._remark.value == "nothing has changed"

"""The tab of the cell: what is typed for a save goes with it."""

from dataclasses import replace

import numpy as np

from workbench.app.core.cell.changes import ChangeCell, UndoCell
from workbench.app.core.people import Role
from workbench.app.runtime.live import Live
from workbench.gui.cell.panel import CellPanel
from workbench.gui.shared.look import View
from workbench.gui.shared.movable_frames import move_frame
from workbench.model.geometry import pose_from_rpy


def test_a_tcp_is_moved_by_numbers_in_the_frame_of_its_flange_and_undone(bench, visitor):
    panel = CellPanel(visitor)
    thing = f"TCP {bench.state.cell.arms[0].tool.name}"
    assert thing in panel._thing.options
    panel._thing.value = thing
    panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))
    was = bench.state.cell.arms[0].tool.T_flange_tcp
    inputs = panel._inputs
    assert np.allclose(np.array(inputs._position.value) / 1000, was.translation, atol=1e-5)
    x, y, z = inputs._position.value
    inputs._position.value = (x, y, z + 5.0)
    inputs._end(inputs._typed_pose())
    assert visitor.client.told == []
    for arm in bench.state.cell.arms:
        for tool in (arm.tool, *arm.tools):
            assert np.allclose(
                tool.T_flange_tcp.translation - was.translation, (0, 0, 0.005), atol=1e-5
            )
            assert np.allclose(tool.T_flange_tcp.rotation, was.rotation, atol=1e-6)
    bench.do(UndoCell(), "Ada", Role.ENGINEER)
    assert bench.state.cell.arms[0].tool.T_flange_tcp.isApprox(was, 1e-9)


def test_a_thing_is_told_in_the_world_again_after_a_tcp(bench, visitor):
    panel = CellPanel(visitor)
    cell = bench.state.cell
    panel._thing.value = f"TCP {cell.arms[0].tool.name}"
    panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))
    panel._thing.value = "bin"
    panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))
    shown = np.array(panel._inputs._position.value) / 1000
    assert np.allclose(shown, cell.bin.T_world_bin.translation, atol=1e-5)


def test_a_remark_goes_once_it_is_saved(bench, visitor):
    def shown(state) -> View:
        return View(state, Live(), visitor.look.now, (), 0.0)

    panel = CellPanel(visitor)
    cell = bench.state.cell
    there = pose_from_rpy((0.0, 0.0, 0.01)) * cell.bin.T_world_bin
    changed = bench.do(ChangeCell(move_frame(cell, "bin", there), "the bin is moved"), "Ada")
    panel.show(None, shown(changed))
    panel._remark.value = "the bin was moved"
    panel._save_cell()
    told = replace(changed, message="saving")
    panel.show(shown(changed), shown(told))
    assert panel._remark.value == "the bin was moved", "it is not in the file yet"
    panel.show(shown(told), shown(replace(changed, saved=changed.cell.digest)))
    assert panel._remark.value == ""


def test_a_remark_that_was_not_saved_stays(bench, visitor):
    panel = CellPanel(visitor)
    panel._remark.value = "nothing has changed"
    panel._save_cell()
    assert visitor.client.told
    panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))
    assert panel._remark.value == "nothing has changed"


def test_the_steps_of_commissioning_show_what_is_next(bench, visitor):
    panel = CellPanel(visitor)
    panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))
    lines = panel._steps.content.split("<li ")[1:]
    assert [line.split('"')[1] for line in lines].count("wb-next") == 1
    assert "Take a scan" in next(line for line in lines if 'class="wb-next"' in line)
    assert "icon-tabler-rotate-clockwise" in lines[3]


def test_typed_numbers_are_used_or_dropped_before_the_cell_is_saved(bench, visitor):
    panel = CellPanel(visitor)
    panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))
    before, (x, y, z) = bench.state, panel._inputs._position.value
    assert visitor.not_applied() == ""
    panel._inputs._position.value = (x, y, z + 5.0)
    panel._save_cell()
    assert bench.state is before and "press Move it there first" in visitor.client.told[-1]
    panel._thing.value = "scanner"
    assert visitor.not_applied() == ""

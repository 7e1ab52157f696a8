"""Changes of the cell: what they leave standing, how they are undone, how the file follows."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from idle import Idle
from waiting import wait_until

from workbench.app.core.cell.changes import (
    MOST_UNDO,
    CellRead,
    ChangeCell,
    RedoCell,
    SaveCell,
    UndoCell,
)
from workbench.app.core.command import Entry
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.effects import UseCell, WriteCell
from workbench.app.core.people import CELL_FILE
from workbench.app.core.state import Phase, State
from workbench.app.records.forms import large_arrays, restore_value
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.app.runtime.watch import CellWatch
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.cell import Cell
from workbench.model.digest import canonical
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection


def with_bin_at(cell: Cell, x: float) -> Cell:
    return replace(cell, bin=replace(cell.bin, T_world_bin=pose_from_rpy((x, 0, 0))))


@pytest.fixture
def approved(cell, samples) -> State:
    return samples.approved(cell)


def after(state: State, command, actor="ada", at=1.0):
    check_allowed(state, command, actor, at)
    return decide(state, Entry(state.number + 1, at, actor, command))


def test_a_change_takes_plan_and_approval_away_and_leaves_the_scan(approved):
    other = with_bin_at(approved.cell, 0.5)
    state, effects = after(approved, ChangeCell(other, "the bin is moved"))
    assert (state.phase, state.message) == (Phase.SCANNED, "the bin is moved")
    assert state.scan is approved.scan
    assert (state.plan, state.proof, state.approval, state.detections) == (None,) * 4
    assert [type(effect) for effect in effects] == [UseCell]
    assert effects[0].cell is state.cell
    for command in (Approve(approved.plan.digest), SendPlan(approved.plan.digest)):
        with pytest.raises(CommandRefused):
            check_allowed(state, command, "ada", 2.0)


def test_a_moved_scanner_takes_the_scan_away_too(approved):
    mount = replace(approved.cell.scanner, T_world_scanner=pose_from_rpy((0, 0, 2)))
    state, _ = after(approved, ChangeCell(replace(approved.cell, scanner=mount), "moved"))
    assert (state.phase, state.scan) == (Phase.IDLE, None)


def test_undo_and_redo_walk_along_the_changes(approved):
    state, cells = approved, [approved.cell]
    for x in (0.1, 0.2, 0.3):
        cells.append(with_bin_at(approved.cell, x))
        state, _ = after(state, ChangeCell(cells[-1], f"to {x}"))
    for expected in (2, 1, 0):
        state, effects = after(state, UndoCell())
        assert state.cell.digest == cells[expected].digest == effects[0].cell.digest
        assert str(state.message) == f"undone: to 0.{expected + 1}"
    with pytest.raises(CommandRefused, match="no change of the cell to undo"):
        after(state, UndoCell())
    for expected in (1, 2, 3):
        state, _ = after(state, RedoCell())
        assert state.cell.digest == cells[expected].digest
        assert str(state.message) == f"made again: to 0.{expected}"
    with pytest.raises(CommandRefused, match="no change of the cell to redo"):
        after(state, RedoCell())
    state, _ = after(state, UndoCell())
    state, _ = after(state, ChangeCell(with_bin_at(approved.cell, 0.9), "elsewhere"))
    assert state.undone == ()


def test_undo_forgets_what_is_very_old(approved):
    state = approved
    for number in range(MOST_UNDO + 5):
        state, _ = after(state, ChangeCell(with_bin_at(state.cell, 0.01 * (number + 1)), "on"))
    assert len(state.before) == MOST_UNDO


def test_the_running_cell_keeps_its_controller(approved):
    other = with_bin_at(approved.cell, 0.5)
    other = replace(other, controller=replace(other.controller, port=9))
    state, _ = after(approved, ChangeCell(other, "moved"))
    assert state.cell.controller == approved.cell.controller


def test_saving_writes_the_cell_and_the_file_answers(approved):
    with pytest.raises(CommandRefused, match="saved already"):
        after(approved, SaveCell(""))
    moved, _ = after(approved, ChangeCell(with_bin_at(approved.cell, 0.5), "moved"))
    state, effects = after(moved, SaveCell("why"))
    assert isinstance(effects[0], WriteCell)
    assert (effects[0].cell, effects[0].remark, effects[0].actor) == (moved.cell, "why", "ada")
    saved, effects = after(state, CellRead(moved.cell, is_saved=True), CELL_FILE)
    assert saved.saved == moved.cell.digest and effects == ()
    assert saved.scan is moved.scan


def test_a_change_made_while_the_cell_is_written_is_kept(approved):
    moved, _ = after(approved, ChangeCell(with_bin_at(approved.cell, 0.5), "moved"))
    saving, effects = after(moved, SaveCell(""))
    written = effects[0].cell
    meanwhile, _ = after(saving, ChangeCell(with_bin_at(approved.cell, 0.6), "moved again"))
    saved, _ = after(meanwhile, CellRead(written, is_saved=True, written=written.digest), CELL_FILE)
    assert saved.cell is meanwhile.cell
    assert saved.saved == written.digest, "the newer change is not in the file"
    assert "without the changes made meanwhile" in str(saved.message)


def test_a_file_that_others_wrote_is_a_change_and_can_be_undone(approved):
    other = with_bin_at(approved.cell, 0.7)
    state, _ = after(approved, CellRead(other), CELL_FILE)
    assert state.cell.digest == state.saved == other.digest
    assert state.plan is None and "read again" in str(state.message)
    back, _ = after(state, UndoCell())
    assert back.cell.digest == approved.cell.digest != back.saved


def test_a_broken_file_leaves_the_cell_and_says_why(approved):
    state, effects = after(approved, CellRead(problem="key bin: is missing"), CELL_FILE)
    assert state.cell is approved.cell and state.plan is approved.plan and effects == ()
    assert state.cell_problem == "key bin: is missing" and "stays as it was" in str(state.message)
    mended, _ = after(state, CellRead(approved.cell), CELL_FILE)
    assert mended.cell_problem == ""


def test_what_is_moved_out_of_the_room_is_refused(approved):
    cell = approved.cell
    far = pose_from_rpy((0, 0, 21))
    (arm, *arms) = cell.arms
    for changed, named in (
        (with_bin_at(cell, 1e300), "bin"),
        (replace(cell, scanner=replace(cell.scanner, T_world_scanner=far)), "scanner"),
        (replace(cell, T_world_robot=far), "robot"),
        (replace(cell, arms=(replace(arm, Ts_world_place=(far,)), *arms)), "a place of the"),
        (replace(cell, arms=(replace(arm, home=np.asarray(arm.home) + 99), *arms)), "its limits"),
    ):
        with pytest.raises(CommandRefused, match=named):
            check_allowed(approved, ChangeCell(changed, "x"), "ada", 1.0)
    gone = (Detection(cell.parts[0].name, far),)
    with pytest.raises(CommandRefused, match="part-1: 21 m away"):
        check_allowed(approved, UseDetections(gone), "ada", 1.0)


@pytest.mark.parametrize("says", ["x" * 201, "a\nb", 7])
def test_words_are_checked(approved, says):
    with pytest.raises(CommandRefused, match="must be a text"):
        check_allowed(approved, ChangeCell(with_bin_at(approved.cell, 0.5), says), "ada", 1.0)


def test_nobody_changes_the_cell_while_something_is_sent(approved):
    sending = replace(approved, phase=Phase.SENDING)
    other = with_bin_at(approved.cell, 0.5)
    for command, actor in ((ChangeCell(other, "x"), "ada"), (CellRead(other), CELL_FILE)):
        with pytest.raises(CommandRefused, match="on its way to the robot"):
            check_allowed(sending, command, actor, 1.0)


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_a_cell_comes_back_from_the_journal(name):
    cell = read_cell(name)
    form = json.loads(json.dumps(canonical(cell)))
    again = restore_value(Cell, form, large_arrays(cell).__getitem__)
    assert again.digest == cell.digest
    np.testing.assert_array_equal(again.arms[0].home, cell.arms[0].home)


def test_a_session_with_changes_is_computed_again(cell, tmp_path):
    bench = Bench(cell, Journal(tmp_path / "s"), effects=Idle)
    bench.do(ChangeCell(with_bin_at(cell, 0.5), "moved"), "ada")
    bench.do(ChangeCell(with_bin_at(cell, 0.6), "moved"), "ada")
    bench.do(UndoCell(), "ada")
    *_, (_, last) = replay(bench._journal, cell)
    assert last.cell.digest == bench.state.cell.digest == with_bin_at(cell, 0.5).digest
    bench.close()
    again = Bench(cell, Journal(tmp_path / "s"), effects=Idle)
    assert again.state.cell.digest == with_bin_at(cell, 0.5).digest
    again.close()


class Noted:
    """A bench as far as the watch knows it."""

    def __init__(self, state: State):
        self.state, self.live = state, Live()
        self.commands: list[CellRead] = []

    def do(self, command, actor):
        assert actor == CELL_FILE
        check_allowed(self.state, command, actor, 1.0)
        self.commands.append(command)
        self.state, _ = decide(self.state, Entry(self.state.number + 1, 1.0, actor, command))


@pytest.mark.parametrize("name", ["arm.STL", "arm.dae", "arm.glb", "taught.pcd"])
def test_every_kind_of_mesh_is_watched(tmp_path, cell, name):
    watch = CellWatch(tmp_path / "cell.toml", Noted(State(cell)), every=60.0)
    try:
        before = watch._stamp()
        (tmp_path / name).write_text("a mesh")
        assert watch._stamp() != before
    finally:
        watch.close()


def write_at_once(path: Path, text: str) -> None:
    """Nobody sees half of it: a busy machine may pause between emptying a file and filling it."""
    written = path.with_suffix(".written")
    written.write_text(text)
    written.replace(path)


def test_the_file_is_read_again_when_it_was_written(tmp_path):
    from shutil import copytree

    from workbench.formats.files.shipped import find

    copytree(find("robots", "yumi"), tmp_path / "yumi")
    path = tmp_path / "yumi" / "cell.toml"
    cell, text = read_cell(path), path.read_text()
    bench = Noted(State(cell, saved=cell.digest))
    watch = CellWatch(path, bench, every=0.02)
    write_at_once(path, text.replace("position_mm = [410, 0, -5]", "position_mm = [420, 0, -5]"))
    wait_until(lambda: bench.state.cell.digest != cell.digest)
    assert bench.state.cell.bin.T_world_bin.translation[0] == 0.42
    write_at_once(path, text.replace("[bin]", "[bim]"))
    wait_until(lambda: bench.state.cell_problem != "")
    assert "bin" in bench.state.cell_problem
    assert bench.state.cell.bin.T_world_bin.translation[0] == 0.42, "the last good cell stays"
    write_at_once(path, text)
    wait_until(lambda: bench.state.cell.digest == cell.digest)
    assert bench.state.cell_problem == ""
    watch.close()
    assert len(bench.commands) == 3


def test_a_cell_that_was_changed_meanwhile_is_not_replaced(approved):
    mine = ChangeCell(with_bin_at(approved.cell, 0.5), "mine", was=approved.cell.digest)
    theirs, _ = after(approved, ChangeCell(with_bin_at(approved.cell, 0.7), "theirs"))
    with pytest.raises(CommandRefused, match="changed by somebody else"):
        after(theirs, mine)
    state, _ = after(approved, mine)
    assert state.cell.digest == mine.cell.digest

"""Bins chosen: what is void then, what has to wait, and that sessions are computed again."""

from dataclasses import replace

import pytest
from idle import Idle
from line import Line

from workbench.app.core.cell.bins import ChooseBin
from workbench.app.core.cell.changes import CellRead, ChangeCell, RedoCell, SaveCell, UndoCell
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.effects import WriteCell
from workbench.app.core.people import CELL_FILE, WORKER, Role
from workbench.app.core.state import EditedCell, Phase
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.derived.by_bin import with_bin
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.message import plain
from workbench.model.recipes.recipe import Recipe


@pytest.fixture
def line(cell) -> Line:
    right = replace(cell.bin, name="right", number=1)
    away = pose_from_rpy((0, 2.0, 0)) * cell.bin.T_world_bin
    left = replace(right, name="left", number=2, T_world_bin=away)
    recipes = (Recipe(1, "to the left", bin="left"), Recipe(2, "plain"))
    return Line(replace(cell, bin=right, other_bins=(left,), recipes=recipes))


def test_another_bin_voids_the_scan_and_the_parts_found(line, samples):
    line.do(TakeScan())
    line.ended(samples.scan(line.state.number))
    line.do(FindParts())
    line.ended(samples.detections())
    before = line.state.cell.digest
    state = line.do(ChooseBin("left"))
    assert (state.cell.bin.name, state.phase, state.detections) == ("left", Phase.IDLE, None)
    assert state.scan is None
    assert "bin left" in str(state.message)
    assert line.do(ChooseBin("left")).cell is state.cell
    state = line.do(ChooseBin("right"))
    assert state.cell.digest == before and state.whole is None


def test_a_file_that_loses_the_chosen_bin_is_used_as_it_stands(line, samples):
    whole = line.state.cell
    line.do(ChooseBin("left"))
    line.do(TakeScan())
    line.ended(samples.scan())
    without = replace(whole, other_bins=(), recipes=())
    state = line.do(CellRead(without), CELL_FILE)
    assert (state.cell.digest, state.whole, state.scan) == (without.digest, None, None)
    assert "the cell is used as its file states it" in str(state.message)


def test_a_session_in_which_bins_are_chosen_is_computed_again(line, samples, tmp_path):
    cell, journal = line.state.cell, Journal(tmp_path / "session")
    bench = Bench(cell, journal, effects=Idle)
    for name in ("left", "right", "left"):
        bench.do(ChooseBin(name), "ada", Role.OPERATOR)
        bench.do(TakeScan(), "ada")
        bench.do(JobEnded(bench.state.number, samples.scan()), WORKER)
    last = bench.state
    bench.close()
    *_, (_, again) = replay(Journal(tmp_path / "session"), cell)
    assert digest_of(again) == digest_of(last) and again.cell.bin.name == "left"


def test_a_recipe_takes_its_bin_along_and_others_keep_the_one_that_is_chosen(line):
    assert line.do(ChooseRecipe(1)).cell.bin.name == "left"
    assert line.do(ChooseRecipe(2)).cell.bin.name == "left"
    state = line.do(ChooseRecipe(0))
    assert state.cell.bin.name == "left" and state.whole is not None
    assert line.do(ChooseBin("right")).whole is None


def test_unknown_bins_are_refused(line):
    with pytest.raises(CommandRefused, match="has no bin third; it has right, left"):
        line.do(ChooseBin("third"))
    with pytest.raises(CommandRefused, match="has no bin ''; it has right, left"):
        line.do(ChooseBin(""))


def moved(cell, by=0.01):
    """The cell with its chosen bin elsewhere."""
    T = pose_from_rpy((by, 0, 0)) * cell.bin.T_world_bin
    return replace(cell, bin=replace(cell.bin, T_world_bin=T))


def test_the_cell_is_changed_undone_and_saved_while_another_bin_is_chosen(line):
    line.state = replace(line.state, saved=line.state.cell.digest)
    first = line.do(ChooseBin("left")).cell
    cell = moved(first)
    state = line.do(ChangeCell(cell, "to where it is seen"))
    assert (state.cell.digest, state.cell.bin.name) == (cell.digest, "left")
    assert state.whole.digest == with_bin(cell, "right").digest and not state.is_saved
    assert line.effects[-1].cell.digest == cell.digest
    assert line.do(UndoCell()).cell.digest == first.digest and line.state.is_saved
    assert line.do(RedoCell()).cell.digest == cell.digest
    line.do(SaveCell(""))
    (write,) = [effect for effect in line.effects if isinstance(effect, WriteCell)]
    assert write.cell.digest == with_bin(cell, "right").digest
    read = CellRead(write.cell, is_saved=True, written=write.cell.digest)
    state = line.do(read, CELL_FILE)
    assert state.is_saved and state.cell.digest == cell.digest
    assert line.do(ChooseBin("right")).whole is None
    assert line.state.cell.digest == write.cell.digest


def test_a_change_keeps_the_bins_that_the_cell_has(line):
    line.do(ChooseBin("left"))
    alone = replace(line.state.cell, other_bins=())
    with pytest.raises(CommandRefused, match="has one bin only"):
        line.do(ChangeCell(alone, ""))


def test_an_undo_to_a_cell_without_the_chosen_bin_chooses_its_first(line, samples):
    whole = line.state.cell
    alone = replace(whole, other_bins=(), recipes=())
    line.state = replace(line.state, before=(EditedCell(alone, plain("added")),))
    line.do(ChooseBin("left"))
    line.do(TakeScan())
    line.ended(samples.scan())
    state = line.do(UndoCell())
    assert (state.cell.digest, state.whole, state.scan) == (alone.digest, None, None)
    assert line.do(RedoCell()).cell.digest == whole.digest


def test_a_recipe_has_to_go_first(line):
    line.do(ChooseRecipe(1))
    with pytest.raises(CommandRefused, match="while recipe 1 is chosen"):
        line.do(SaveCell(""))

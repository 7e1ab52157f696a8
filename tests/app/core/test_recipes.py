"""Recipes chosen: what is void then, what has to wait, and that sessions are computed again."""

from dataclasses import replace

import numpy as np
import pytest
from idle import Idle

from workbench.app.core.cell.changes import CellRead, ChangeCell, SaveCell, UndoCell
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.command import Entry
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.effects import StartJob, UseCell
from workbench.app.core.people import CELL_FILE, WORKER, Role
from workbench.app.core.state import Phase, State
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.digest import canonical, digest_of
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.part_edits import with_part
from workbench.model.recipes.recipe import Recipe
from workbench.model.scan import Detection

SLOW = Recipe(2, "slow", parts=("peg",), strategy="right", threshold=0.1, speed=0.2)
TOP = Recipe(9, "top", grasps=("top",))


@pytest.fixture(scope="module")
def with_recipes(cell):
    return replace(cell, recipes=(SLOW, TOP))


@pytest.fixture
def approved(with_recipes, samples) -> State:
    return samples.approved(with_recipes)


def after(state: State, command, actor="ada", role=Role.ENGINEER):
    check_allowed(state, command, actor, 1.0, role=role)
    return decide(state, Entry(state.number + 1, 1.0, actor, command))


def test_an_operator_chooses_a_recipe_and_only_the_scan_stays(approved):
    state, effects = after(approved, ChooseRecipe(2), role=Role.OPERATOR)
    assert (state.phase, str(state.message)) == (Phase.SCANNED, "recipe 2 slow is chosen")
    assert state.scan is approved.scan
    assert (state.plan, state.proof, state.approval, state.detections) == (None,) * 4
    assert "recipe 2 slow was chosen" in str(state.stale)
    assert (state.cell.recipe, state.cell.policy.speed, state.cell.policy.threshold) == (
        2,
        0.2,
        0.1,
    )
    (effect,) = effects
    assert isinstance(effect, UseCell) and effect.cell is state.cell


def test_without_a_recipe_the_cell_is_again_what_it_was(approved):
    state, _ = after(approved, ChooseRecipe(2))
    other, _ = after(state, ChooseRecipe(9))
    assert (other.cell.recipe, other.cell.policy.speed) == (9, approved.cell.policy.speed)
    none, _ = after(other, ChooseRecipe(0))
    assert (none.cell.digest, none.whole) == (approved.cell.digest, None)
    assert str(none.message) == "no recipe is chosen"


def test_the_recipe_that_is_chosen_already_voids_nothing(approved):
    state, _ = after(approved, ChooseRecipe(0))
    assert (state.plan, state.approval) == (approved.plan, approved.approval)
    chosen, _ = after(approved, ChooseRecipe(2))
    again, effects = after(chosen, ChooseRecipe(2))
    assert (again.cell, effects) == (chosen.cell, ())


def test_an_unknown_recipe_is_refused_with_those_that_there_are(approved):
    with pytest.raises(CommandRefused, match="no recipe 3; it has 2 slow, 9 top"):
        after(approved, ChooseRecipe(3))
    for number in (-1, 70_000, 2.0, "2", True):
        with pytest.raises(CommandRefused, match="number"):
            after(approved, ChooseRecipe(number))


def test_no_recipe_is_chosen_while_a_plan_is_sent_or_a_task_runs(approved):
    with pytest.raises(CommandRefused, match="the choice of a recipe"):
        after(replace(approved, phase=Phase.SENDING), ChooseRecipe(2))
    planning, _ = after(approved, MakePlan())
    with pytest.raises(CommandRefused, match="the choice of a recipe"):
        after(planning, ChooseRecipe(2))


def test_the_cell_is_not_changed_while_a_recipe_is_chosen(approved):
    state, _ = after(approved, ChooseRecipe(2))
    moved = replace(state.cell, bin=replace(state.cell.bin, wall=0.004))
    for command in (ChangeCell(moved, "thicker walls"), UndoCell(), SaveCell("")):
        with pytest.raises(CommandRefused, match="while recipe 2 is chosen"):
            after(state, command)
    assert state.is_saved
    none, _ = after(state, ChooseRecipe(0))
    after(none, ChangeCell(replace(moved, recipe=0), "thicker walls"))


def test_a_recipe_that_does_not_fit_the_changed_cell_any_more_is_refused(approved):
    library = approved.cell.parts[0].library
    (grasp,) = library.entries
    other = with_part(
        approved.cell, "peg", library=replace(library, entries=(replace(grasp, name="side"),))
    )
    state, _ = after(approved, ChangeCell(other, "another name"))
    with pytest.raises(CommandRefused, match="recipe 9 top does not fit the cell: grasp top"):
        after(state, ChooseRecipe(9))


def test_parts_on_a_pallet_that_the_recipe_does_not_know_have_to_go_first(approved):
    pin = replace(approved.cell.parts[0], name="pin")
    cell = replace(approved.cell, parts=(*approved.cell.parts, pin))
    state = replace(approved, cell=cell, placed=(Detection("pin", pose_from_rpy((0, 0, 0))),))
    with pytest.raises(CommandRefused, match="a part pin stands on a pallet"):
        after(state, ChooseRecipe(2))
    after(state, ChooseRecipe(9))


def test_a_plan_for_which_nobody_names_strategy_or_threshold_takes_those_of_the_recipe(approved):
    def asked(state, command):
        _, (effect,) = after(state, command)
        assert isinstance(effect, StartJob)
        return effect.arguments["strategy"], effect.arguments["threshold"]

    usual = approved.cell.policy.threshold
    assert asked(approved, MakePlan("", None)) == ("auto", usual)
    chosen, _ = after(approved, ChooseRecipe(2))
    chosen = replace(chosen, phase=Phase.LOCALIZED, detections=approved.detections)
    assert asked(chosen, MakePlan("", None)) == ("right", 0.1)
    assert asked(chosen, MakePlan("auto", 0.3)) == ("auto", 0.3)


def test_the_recipe_stays_chosen_when_the_cell_file_changes(approved):
    chosen, _ = after(approved, ChooseRecipe(2))
    same, _ = after(chosen, CellRead(approved.cell), CELL_FILE)
    assert (same.cell.digest, same.whole.digest) == (chosen.cell.digest, approved.cell.digest)
    wider = replace(approved.cell, bin=replace(approved.cell.bin, size=np.array([0.5, 0.3, 0.2])))
    state, effects = after(chosen, CellRead(wider), CELL_FILE)
    assert (state.cell.recipe, state.whole.digest) == (2, wider.digest)
    assert state.cell.bin.size[0] == 0.5 and state.cell.policy.speed == 0.2
    assert [effect.cell for effect in effects if isinstance(effect, UseCell)] == [state.cell]
    assert state.is_saved
    gone, effects = after(chosen, CellRead(replace(wider, recipes=(TOP,))), CELL_FILE)
    assert (gone.cell.recipe, gone.whole) == (0, None)
    assert str(gone.message).endswith(
        "no recipe 2; it has 9 top; the cell is used as its file states it"
    )
    assert [effect.cell for effect in effects if isinstance(effect, UseCell)] == [gone.cell]


def test_approvers_of_the_cell_file_count_while_a_recipe_is_chosen(approved):
    chosen, _ = after(approved, ChooseRecipe(2))
    state, effects = after(chosen, CellRead(replace(approved.cell, approvers=3)), CELL_FILE)
    assert (state.cell.approvers, state.whole.approvers, state.cell.recipe) == (3, 3, 2)
    assert [effect.cell for effect in effects] == [state.cell]


def test_a_session_in_which_recipes_are_chosen_is_computed_again(with_recipes, samples, tmp_path):
    journal = Journal(tmp_path / "session")
    bench = Bench(with_recipes, journal, effects=Idle)
    scan = samples.scan()
    for number in (2, 0, 9, 2):
        bench.do(ChooseRecipe(number), "ada", Role.OPERATOR)
        bench.do(TakeScan(), "ada")
        bench.do(JobEnded(bench.state.number, scan), WORKER)
        bench.do(FindParts(), "ada")
        bench.do(JobEnded(bench.state.number, samples.detections()), WORKER)
        bench.do(MakePlan("", None), "ada")
        bench.do(JobEnded(bench.state.number, samples.refused()), WORKER)
    bench.do(ChooseRecipe(0), "ada")
    bench.do(ChangeCell(replace(with_recipes, recipes=(TOP,)), "one recipe less"), "ada")
    bench.do(ChooseRecipe(9), "ada")
    last = bench.state
    bench.close()
    *_, (_, again) = replay(Journal(tmp_path / "session"), with_recipes)
    assert digest_of(again) == digest_of(last)
    assert canonical(again.cell) == canonical(last.cell)
    assert (again.cell.recipe, again.whole.recipes) == (9, (TOP,))

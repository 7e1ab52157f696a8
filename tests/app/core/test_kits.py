"""Kits: what is counted as in them, what may be taken next, and when a new one is begun."""

from dataclasses import replace

import pytest
from dropping import drop_result
from line import Line

from workbench.app.core.cell.changes import CellRead
from workbench.app.core.cell.kits import NewKit, lacks_of
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ReportPick
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.drop_back import PlanDropBack
from workbench.app.core.people import CELL_FILE
from workbench.app.core.state import Phase
from workbench.app.records.record import summary
from workbench.model.errors import CommandRefused
from workbench.model.recipes.kit import KitItem, Wanted, lacking
from workbench.model.recipes.recipe import Recipe
from workbench.model.release import PartReport
from workbench.plugins.robot_link import controller_by

PEGS = Recipe(1, "two pegs", items=(KitItem("peg", 2),))
ONE = Recipe(2, "one peg", items=(KitItem("peg", 1),))


@pytest.fixture
def line(cell) -> Line:
    controller = controller_by("abb-socket/2")
    recipes = (PEGS, ONE, Recipe(3, "plain"))
    line = Line(replace(cell, controller=controller, recipes=recipes))
    line.do(ChooseRecipe(1))
    return line


@pytest.fixture
def by_recipe(samples, line):
    """Samples whose plans are for the cell by its recipe."""
    return replace(samples, cell=line.state.cell)


def found(line, samples) -> None:
    line.do(TakeScan())
    line.ended(samples.scan(line.state.number))
    line.do(FindParts())
    line.ended(samples.detections())


def send(line, samples) -> None:
    found(line, samples)
    line.do(MakePlan())
    digest = line.ended(samples.planned(line.state.scene_digest)).plan.digest
    line.do(WatchPlan(digest))
    line.do(Approve(digest))
    line.do(SendPlan(digest))


def cycle(line, samples, *, is_picked: bool | None = True) -> None:
    send(line, samples)
    parts = (PartReport("right", 0, is_picked),)
    line.do(LinkEnded(parts_placed=int(is_picked is not False), parts=parts))


def refused(line, command) -> str:
    with pytest.raises(CommandRefused) as caught:
        line.do(command)
    return str(caught.value)


def test_each_part_that_came_to_its_place_is_counted_until_the_kit_is_complete(line, by_recipe):
    cycle(line, by_recipe)
    assert lacks_of(line.state) == {"peg": 1}
    assert str(line.state.message).endswith("the kit lacks 1 peg")
    cycle(line, by_recipe)
    assert lacks_of(line.state) == {}
    assert "the kit is complete" in str(line.state.message)


def test_a_planning_may_take_only_what_the_kit_lacks(line, by_recipe):
    send(line, by_recipe)
    planning = next(e for e in line.effects if getattr(e, "name", "") == "plan")
    assert planning.arguments["wanted"] == Wanted({"peg": 2})
    line.do(LinkEnded(parts_placed=1))
    found(line, by_recipe)
    line.do(MakePlan())
    assert line.effects[-1].arguments["wanted"] == Wanted({"peg": 1})


def test_for_a_complete_kit_nothing_is_planned_until_a_new_one_is_begun(line, by_recipe):
    line.do(ChooseRecipe(2))
    by_recipe = replace(by_recipe, cell=line.state.cell)
    cycle(line, by_recipe)
    found(line, by_recipe)
    assert "the kit is complete" in refused(line, MakePlan())
    state = line.do(NewKit())
    assert str(state.message) == "a new kit is begun; 1 kit complete, 0 incomplete before it"
    assert line.do(MakePlan()).job is not None


def test_a_cycle_that_goes_on_by_itself_ends_before_planning_for_a_complete_kit(line, by_recipe):
    line.do(ChooseRecipe(2))
    by_recipe = replace(by_recipe, cell=line.state.cell)
    cycle(line, by_recipe)
    line.do(GoOn())
    line.ended(by_recipe.scan(99))
    state = line.ended(by_recipe.detections())
    assert (state.phase, state.job) == (Phase.LOCALIZED, None)
    assert "the kit is complete" in str(state.message)


def test_parts_of_kinds_that_the_kit_does_not_need_are_not_enough(line, by_recipe):
    found(line, by_recipe)
    other = replace(line.state, detections=(replace(line.state.detections[0], part="pin"),))
    line.state = other
    assert "the kit lacks 2 peg, and none was found" in refused(line, MakePlan())


def test_a_failed_pick_is_not_in_the_kit_whoever_says_so_and_whenever(line, by_recipe):
    cycle(line, by_recipe, is_picked=False)
    assert lacks_of(line.state) == {"peg": 2}
    cycle(line, by_recipe)
    assert lacks_of(line.state) == {"peg": 1}
    line.do(ReportPick(0, is_picked=False, why="it fell"))
    assert lacks_of(line.state) == {"peg": 2}
    line.do(ReportPick(0, is_picked=True))
    assert lacks_of(line.state) == {"peg": 1}


def test_a_person_who_saw_it_fall_on_the_way_has_seen_more_than_the_controller(line, by_recipe):
    send(line, by_recipe)
    line.do(ReportPick(0, is_picked=False))
    line.do(LinkEnded(parts_placed=1, parts=(PartReport("right", 0, True),)))
    assert lacks_of(line.state) == {"peg": 2}


def test_a_word_that_a_part_was_picked_counts_it_once_and_only_when_it_is_there(line, by_recipe):
    send(line, by_recipe)
    line.do(ReportPick(0, is_picked=True))
    assert lacks_of(line.state) == {"peg": 2}, "it hangs in the hand"
    line.do(LinkEnded(parts_placed=1, parts=(PartReport("right", 0, True),)))
    assert lacks_of(line.state) == {"peg": 1}


def test_without_reports_of_parts_all_are_there_only_if_all_were_placed(line, by_recipe):
    send(line, by_recipe)
    line.do(LinkEnded(parts_placed=1))
    assert lacks_of(line.state) == {"peg": 1}
    send(line, by_recipe)
    line.do(LinkEnded(parts_placed=0))
    assert lacks_of(line.state) == {"peg": 1}


def test_after_a_fault_a_part_is_in_the_kit_only_when_a_person_says_so(line, by_recipe):
    send(line, by_recipe)
    line.do(LinkEnded("it broke off", parts=(PartReport("right", 0, True),)))
    assert lacks_of(line.state) == {"peg": 2}
    line.do(AcknowledgeFault())
    line.do(ReportPick(0, is_picked=False))
    line.do(ReportPick(0, is_picked=True))
    assert lacks_of(line.state) == {"peg": 1}


def test_a_row_of_plans_fills_one_kit(line, by_recipe):
    line.joints = {"joint_1": 0.0}
    found(line, by_recipe)
    line.do(MakePlan())
    state = line.ended(by_recipe.row(line.state.scene_digest, picks=2))
    row = tuple(proven.plan.digest for proven in state.row)
    line.do(WatchPlan(state.plan.digest, row=row))
    line.do(Approve(state.plan.digest, row=row))
    line.do(SendPlan(state.plan.digest))
    line.do(LinkEnded(parts_placed=1, parts=(PartReport("right", 0, True),)))
    assert (line.state.phase, lacks_of(line.state)) == (Phase.SENDING, {"peg": 1})
    line.do(LinkEnded(parts_placed=1, parts=(PartReport("right", 0, True),)))
    assert lacks_of(line.state) == {}
    assert len({part.detection for part in line.state.kit.parts}) == 2


def test_a_new_kit_voids_a_plan_for_the_one_before(line, by_recipe):
    cycle(line, by_recipe)
    found(line, by_recipe)
    line.do(MakePlan())
    line.ended(by_recipe.planned(line.state.scene_digest))
    state = line.do(NewKit())
    assert (state.phase, state.plan, state.kit.incomplete) == (Phase.LOCALIZED, None, 1)
    assert state.detections is not None


def test_a_new_kit_needs_a_recipe_with_one_and_something_in_it(line, by_recipe):
    assert "the kit has no part yet" in refused(line, NewKit())
    line.do(ChooseRecipe(3))
    assert "no recipe with a kit is chosen" in refused(line, NewKit())
    assert summary(line.state)["kit"] is None


def test_another_recipe_begins_with_an_empty_kit(line, by_recipe):
    cycle(line, by_recipe)
    assert "take it away and begin a new kit first" in refused(line, ChooseRecipe(2))
    line.do(ChooseRecipe(1))
    assert lacks_of(line.state) == {"peg": 1}, "the same recipe changes nothing"
    line.do(NewKit())
    assert summary(line.state)["kit"] == {
        "recipe": 1, "parts": 0, "complete": 0, "incomplete": 1,
    }  # fmt: skip
    assert line.do(ChooseRecipe(2)).kit.incomplete == 0


def test_in_order_the_first_kind_that_is_lacking_comes_first():
    items = (KitItem("bracket", 1), KitItem("bolt", 2))
    wanted = Wanted(lacking(items, {}), in_order=True)
    assert wanted.allows(["bracket"]) and not wanted.allows(["bolt"])
    wanted = wanted.without(["bracket"])
    assert wanted.allows(["bolt", "bolt"]) and not wanted.allows(["bolt"] * 3)
    assert wanted.without(["bolt", "bolt"]).counts == {}
    assert lacking(items, {"bracket": 3, "bolt": 1}) == {"bolt": 1}


def test_a_new_kit_leaves_a_plan_alone_that_takes_no_part(line, by_recipe):
    cycle(line, by_recipe)
    planned = replace(line.state, phase=Phase.PLANNED, detections=None)
    line.state = planned
    state = line.do(NewKit())
    assert (state.phase, state.plan) == (Phase.PLANNED, planned.plan)


def test_parts_of_a_kit_whose_recipe_is_gone_hold_up_no_other_recipe(line, by_recipe):
    cycle(line, by_recipe)
    other = replace(line.state.whole, recipes=(ONE,))
    state = line.do(CellRead(other), CELL_FILE)
    assert state.cell.recipe == 0 and state.kit.parts
    assert line.do(ChooseRecipe(2)).kit.parts == ()


def test_a_part_that_is_dropped_back_after_a_fault_is_missing_in_the_kit_again(line, by_recipe):
    before = line.state
    send(line, by_recipe)
    line.do(LinkEnded("stopped by ada"))
    line.do(AcknowledgeFault())
    cell = line.state.cell
    line.joints = cell.joint_values({arm.name: arm.home for arm in cell.arms})
    line.do(PlanDropBack("one"))
    digest = line.ended(drop_result(by_recipe, cell)).plan.digest
    line.joints = {}
    for command in (WatchPlan, Approve, SendPlan):
        line.do(command(digest))
    state = line.do(LinkEnded())
    assert state.phase is Phase.DONE and state.parts_placed == 0
    assert lacks_of(state) == lacks_of(before)

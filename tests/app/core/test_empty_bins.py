"""Empty and new bins: what is remembered of them, and the next one chosen by itself."""

from dataclasses import replace

import numpy as np
import pytest
from line import Line, make_plan, refused

from workbench.app.core.cell.bins import ChooseBin, NewBin, bin_numbered, next_bin
from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.outcomes import ReportPick, avoided_parts
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Sent
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import StartJob, UseCell
from workbench.app.core.state import Phase
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.states import StateText
from workbench.model.plan import PlanResult
from workbench.model.recipes.kit import KitItem, KitPart, KitProgress
from workbench.model.recipes.recipe import Recipe
from workbench.model.release import PartReport, Receipt

GOOD_END = LinkEnded("", 1, (PartReport("right", 0, True),), ())


@pytest.fixture
def samples(in_rows):
    cell = in_rows.cell
    right = replace(cell.bin, name="right", number=1)
    away = pose_from_rpy((0, 2.0, 0)) * cell.bin.T_world_bin
    left = replace(right, name="left", number=2, T_world_bin=away)
    return replace(in_rows, cell=replace(cell, bin=right, other_bins=(left,)))


@pytest.fixture
def line(samples) -> Line:
    line = Line(samples.cell)
    line.joints = {"joint_1": 0.0}
    return line


@pytest.fixture
def sending(line, samples) -> Line:
    make_plan(samples, line)
    plan = line.state.plan.digest
    for command in (WatchPlan(plan), Approve(plan), SendPlan(plan)):
        line.do(command)
    line.effects.clear()
    return line


@pytest.fixture
def done(sending) -> Line:
    sending.do(GOOD_END)
    sending.effects.clear()
    return sending


def search(line, samples, detections=()):
    line.do(TakeScan())
    line.ended(samples.scan())
    line.do(FindParts())
    return line.ended(detections)


def begun(line):
    return [effect.name for effect in line.effects if isinstance(effect, StartJob)]


def test_a_bin_is_empty_until_parts_are_found_in_it_or_somebody_says_it_is_new(line, samples):
    assert search(line, samples).empty_bins == ("right",)
    assert search(line, samples, samples.detections()).empty_bins == ()
    search(line, samples)
    line.do(ChooseBin("left"))
    assert search(line, samples).empty_bins == ("right", "left")
    state = line.do(NewBin("right"))
    assert (state.empty_bins, state.phase) == (("left",), Phase.SCANNED)
    assert str(state.message) == "bin right is new"
    state = line.do(NewBin("left"))
    assert (state.empty_bins, state.phase, state.scan) == ((), Phase.IDLE, None)


def test_a_bin_is_empty_when_nothing_in_it_can_be_taken_and_not_when_time_was_short(line, samples):
    search(line, samples, samples.detections())
    line.do(MakePlan())
    late = replace(samples.refused(), verdict=Verdict(Reason.OUT_OF_TIME, Stage.ROUTE))
    assert line.ended(late).empty_bins == ()
    line.do(MakePlan())
    assert line.ended(samples.refused()).empty_bins == ("right",)
    line.do(MakePlan())
    assert line.ended(samples.planned(line.state.scan.digest)).empty_bins == ()


def test_of_a_single_bin_nothing_is_remembered(in_rows):
    line = Line(in_rows.cell)
    assert search(line, in_rows).empty_bins == ()
    assert next_bin(line.state) == ""
    assert "has one bin only" in refused(line, NewBin(""))


def test_a_plan_is_void_once_its_bin_is_new(line, samples):
    make_plan(samples, line)
    state = line.do(NewBin("right"))
    assert (state.phase, state.plan, state.scan) == (Phase.IDLE, None, None)
    assert "bin right is new" in str(state.stale)


def test_while_parts_are_taken_from_it_a_bin_is_not_new_and_another_one_may_be(sending):
    before = sending.do(TakeControl(), "eve")
    assert "bin right is picked from" in refused(sending, NewBin("right"))
    state = sending.do(NewBin("left"), "bob")
    assert (state.phase, state.plan, state.control) == (Phase.SENDING, before.plan, "eve")
    assert sending.do(GOOD_END).phase is Phase.DONE
    assert sending.do(NewBin("right"), "bob").phase is Phase.DONE
    sending.do(TakeScan(), "eve")
    assert "bin right is picked from" in refused(sending, NewBin("right"))


def test_unknown_bins_are_not_new(line):
    for name in ("third", "", "RIGHT"):
        assert "it has right, left" in refused(line, NewBin(name))


def test_a_cycle_goes_on_with_the_next_bin_and_ends_where_all_are_empty(done, samples):
    done.do(GoOn(TakeScan(5, 0), FindParts(5), MakePlan("right", 0.3, 5)))
    done.ended(samples.scan())
    state = done.ended(())
    assert (state.cell.bin.name, state.job.name, state.scan) == ("left", "scan", None)
    assert str(state.message) == (
        "nothing is left to take in bin right; parts are taken from bin left; scanning"
    )
    use, scan = done.effects[-2:]
    assert isinstance(use, UseCell) and use.cell.digest == state.cell.digest
    assert (scan.name, scan.arguments["parts"]) == ("scan", 2)
    done.ended(samples.scan(seed=8))
    done.ended(samples.detections())
    state = done.ended(samples.refused())
    assert (state.cell.bin.name, state.job, state.phase) == ("left", None, Phase.LOCALIZED)
    assert state.empty_bins == ("right", "left")
    assert str(state.message).endswith(
        "nothing is left to take in any bin; no further cycle starts"
    )


def test_a_task_that_fails_or_is_cancelled_chooses_no_bin(done, samples):
    done.do(GoOn())
    done.ended(samples.scan())
    state = done.ended(InputError("the scanner is dark"))
    assert (state.cell.bin.name, state.job, state.empty_bins) == ("right", None, ())


def test_a_bin_that_was_empty_is_tried_where_somebody_has_chosen_it(done, samples):
    done.state = replace(done.state, empty_bins=("right",))
    done.do(GoOn())
    done.ended(samples.scan())
    state = done.do(CancelJob())
    assert (state.cell.bin.name, state.job) == ("right", None)


def test_a_recipe_stays_with_the_bin_that_it_names(line):
    recipes = (Recipe(1, "of the right", bin="right"), Recipe(2, "plain"))
    cell = replace(line.state.cell, recipes=recipes)
    names = [next_bin(replace(line.state, cell=replace(cell, recipe=n))) for n in (0, 1, 2)]
    assert names == ["left", "", "left"]


def test_bins_go_by_number_and_nought_is_the_next_one_that_is_not_empty(line):
    state = line.state
    assert [bin_numbered(state, n) for n in (0, 1, 2, 3)] == ["left", "right", "left", None]
    assert bin_numbered(replace(state, empty_bins=("left",)), 0) is None


def test_while_a_plan_is_sent_no_bin_is_chosen_and_at_its_end_it_is(sending, samples):
    line = sending
    line.do(GoOn(sees_from=2, placed=()))
    line.do(Sent(Receipt(line.now, "", "heard", "", 4, 4, "state", None, step=2)))
    line.ended(samples.scan(seed=7))
    state = line.ended(())
    assert (state.phase, state.cell.bin.name, state.job) == (Phase.SENDING, "right", None)
    state = line.do(GOOD_END)
    assert (state.cell.bin.name, state.job.name, state.ahead) == ("left", "scan", None)
    assert state.empty_bins == ("right",)
    assert state.message.mentions(StateText.CYCLE_FINISHED)
    assert begun(line) == ["scan", "localize", "scan"]


def test_what_is_avoided_is_avoided_in_its_own_bin_alone(done, samples):
    line = done
    line.do(ReportPick(0, False, "slipped"))
    (mark,) = line.state.avoided
    assert mark.bin == "right"
    line.do(ChooseBin("left"))
    moved = tuple(
        replace(d, T_world_part=pose_from_rpy((0, 2.0, 0)) * d.T_world_part)
        for d in samples.detections()
    )
    assert avoided_parts(search(line, samples, moved), line.now) == ()
    assert [entry.scans for entry in line.state.avoided] == [mark.scans]
    line.do(ChooseBin("right"))
    assert len(avoided_parts(search(line, samples, samples.detections()), line.now)) == 1
    assert line.do(NewBin("right")).avoided == ()


BOTH_KINDS = Recipe(1, "one of each", items=(KitItem("peg", 1), KitItem("cap", 1)))


@pytest.fixture
def for_a_kit(done) -> Line:
    """After a cycle in a cell that fills kits of a peg and a cap, and has the peg."""
    cell = done.state.cell
    cap = replace(cell.part("peg"), name="cap")
    cell = replace(cell, parts=(*cell.parts, cap), recipes=(BOTH_KINDS,), recipe=1)
    kit = KitProgress((KitPart("peg", "plan", 0),))
    whole = replace(cell, recipe=0)
    done.state = replace(done.state, cell=cell, whole=whole, kit=kit)
    return done


def test_a_cycle_goes_on_with_the_next_bin_for_what_the_kit_lacks(for_a_kit, samples):
    line = for_a_kit
    line.do(GoOn())
    line.ended(samples.scan())
    state = line.ended(samples.detections())
    assert (state.cell.bin.name, state.job.name, state.empty_bins) == ("left", "scan", ())
    assert str(state.message).startswith("the kit lacks 1 cap, and none was found")
    line.ended(samples.scan(seed=8))
    state = line.ended(samples.detections())
    # None of the bins has any: the cycle ends, and the next one looks into both again.
    assert (state.cell.bin.name, state.job) == ("left", None)
    assert state.kit.bins_without == ("right", "left")
    assert str(state.message).endswith("no further cycle starts")
    line.state = replace(line.state, phase=Phase.DONE)
    assert line.do(GoOn()).kit.bins_without == ()


def test_a_complete_kit_chooses_no_bin(for_a_kit, samples):
    line = for_a_kit
    kit = replace(line.state.kit, parts=(*line.state.kit.parts, KitPart("cap", "plan", 1)))
    line.state = replace(line.state, kit=kit)
    line.do(GoOn())
    line.ended(samples.scan())
    state = line.ended(samples.detections())
    assert (state.cell.bin.name, state.job) == ("right", None)
    assert "the kit is complete" in str(state.message)


@pytest.fixture
def stirs_for_a_kit(for_a_kit) -> Line:
    """The same where the cell's rule is to stir once before the next bin."""
    state = for_a_kit.state
    motion = replace(state.cell.controller.motion, takes_share=True)
    controller = replace(state.cell.controller, motion=motion)
    wide = replace(state.cell.bin, size=np.array([4.0, 4.0, 0.2]))
    policy = replace(state.cell.policy, stirs=1)
    cell = replace(state.cell, bin=wide, controller=controller, policy=policy)
    for_a_kit.state = replace(state, cell=cell, whole=replace(cell, recipe=0))
    return for_a_kit


def nothing_stirs() -> PlanResult:
    return PlanResult((), None, None, Verdict(Reason.OUT_OF_REACH, Stage.ROUTE), {})


def test_what_the_kit_lacks_is_stirred_for_before_the_next_bin(stirs_for_a_kit, samples):
    line = stirs_for_a_kit
    line.do(GoOn())
    line.ended(samples.scan())
    state = line.ended(samples.detections())
    assert (state.cell.bin.name, state.job.name) == ("right", "stir")
    state = line.ended(nothing_stirs())
    assert (state.cell.bin.name, state.job.name) == ("left", "scan")


def test_a_stirring_whose_task_fails_begins_no_other_for_the_kit(stirs_for_a_kit, samples):
    line = stirs_for_a_kit
    line.do(GoOn())
    line.ended(samples.scan())
    line.ended(samples.detections())
    state = line.ended(InputError("the worker has ended"))
    assert (state.cell.bin.name, state.job) == ("right", None)
    assert str(state.message).endswith("no further cycle starts")


@pytest.mark.parametrize("stirs", [0, 1])
def test_while_a_plan_is_sent_no_other_bin_is_chosen_for_the_kit(
    sending, samples, stirs_for_a_kit, stirs
):
    line, known = sending, stirs_for_a_kit.state
    cell = replace(known.cell, policy=replace(known.cell.policy, stirs=stirs))
    whole = replace(cell, recipe=0)
    sent = replace(line.state, phase=Phase.SENDING, cell=cell, whole=whole, kit=known.kit)
    line.state = replace(sent, part_reports=(), outcomes=(), ahead=None, message="")
    line.do(GoOn(sees_from=2, placed=()))
    line.do(Sent(Receipt(line.now, "", "heard", "", 4, 4, "state", None, step=2)))
    line.effects.clear()
    line.ended(samples.scan())
    state = line.ended(samples.detections())
    if stirs:
        assert state.job is not None and state.job.name == "stir"
        state = line.ended(nothing_stirs())
    assert (state.phase, state.cell.bin.name, state.job) == (Phase.SENDING, "right", None)
    assert not any(isinstance(effect, UseCell) for effect in line.effects)

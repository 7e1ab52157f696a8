"""What a hand holds after a stop or a double pick, dropped back: when, and what it voids."""

from dataclasses import replace

import pytest
from dropping import drop_result, keeping_hand
from line import Line, make_plan, refused, send
from samples import Samples

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ReportPick
from workbench.app.core.cycle.scanning import TakeScan, left_pile
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.standing import moved_away, shift_of
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.drop_back import ConfirmHandsEmpty, PlanDropBack
from workbench.app.core.effects import StartJob
from workbench.app.core.hands import arms_that_may_hold, is_drop_next, may_hold
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import Outcome, SentFor, SimulatedPile
from workbench.app.core.state import Phase
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.plan import PlanResult
from workbench.model.release import PickResult
from workbench.model.tools.held_body import HeldAmount, with_held


@pytest.fixture
def cell(make_cell):
    return keeping_hand(make_cell())


@pytest.fixture
def samples(cell):
    return Samples(cell)


def reports(line: Line, cell, off: float = 0.3) -> None:
    """The controller reports all arms at home, but for the right one."""
    values = cell.joint_values({arm.name: arm.home for arm in cell.arms})
    values[cell.arm("right").joints[0]] += off
    line.joints = values


def broken_off(cell, samples) -> Line:
    """A sending has ended in a fault, which somebody has acknowledged."""
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded("stopped by ada"))
    assert not may_hold(line.state)
    line.do(AcknowledgeFault())
    reports(line, cell)
    return line


def send_drop(line: Line, samples, cell) -> None:
    """The drop back that was asked for is planned, approved and sent."""
    digest = line.ended(drop_result(samples, cell)).plan.digest
    line.joints = {}
    for command in (WatchPlan, Approve, SendPlan):
        line.do(command(digest))


def test_after_a_fault_it_is_the_next_step_planned_from_where_the_arm_stands(cell, samples):
    line = broken_off(cell, samples)
    assert line.state.phase is Phase.IDLE and is_drop_next(line.state)
    line.do(PlanDropBack("one", seed=4))
    job = line.effects[-1]
    assert isinstance(job, StartJob) and job.name == "drop"
    assert (job.arguments["arm"], job.arguments["held"], job.arguments["seed"]) == (
        "right",
        "one",
        4,
    )
    joints = cell.arm("right").joints
    assert job.arguments["q"].tolist() == [line.joints[name] for name in joints]


def test_it_is_approved_and_sent_like_every_plan_and_then_a_scan_is_needed(cell, samples):
    line = broken_off(cell, samples)
    line.do(PlanDropBack())
    state = line.ended(drop_result(samples, cell))
    assert state.phase is Phase.PLANNED and state.scan is None and state.detections is None
    assert "can drop back what it holds" in str(state.message)
    digest = state.plan.digest
    line.joints = {}
    for command in (WatchPlan, Approve, SendPlan):
        line.do(command(digest))
    state = line.do(LinkEnded())
    assert state.phase is Phase.DONE and "has dropped back what it held" in str(state.message)
    assert state.parts_placed == 0 and not may_hold(state)
    line.do(TakeScan())
    assert line.ended(samples.scan(1)).phase is Phase.SCANNED


def test_a_scan_after_a_stop_does_not_make_the_hand_empty(cell, samples):
    line = broken_off(cell, samples)
    assert "empty the hands and confirm it" in str(line.state.message)
    line.do(TakeScan())
    state = line.ended(samples.scan(1))
    assert "right" in state.hands_open
    assert may_hold(state) and not is_drop_next(state)
    line.do(PlanDropBack())
    send_drop(line, samples, cell)
    state = line.do(LinkEnded())
    assert "right" not in state.hands_open


def test_parts_that_are_sent_for_anew_end_the_question_what_the_hands_hold(cell, samples):
    line = broken_off(cell, samples)
    assert line.state.hands_open == ()
    reports(line, cell, 0.0)
    line.joints = {}
    line.do(TakeScan())
    line.ended(samples.scan(1))
    assert line.state.hands_open
    line.do(ConfirmHandsEmpty())
    send(line, samples)
    assert line.state.hands_open == ()


def test_a_person_who_has_looked_ends_the_question_what_the_hands_hold(cell, samples):
    line = broken_off(cell, samples)
    state = line.do(ConfirmHandsEmpty())
    assert "ada has seen the hand of right empty" in str(state.message)
    assert not may_hold(state) and not arms_that_may_hold(state)
    line.do(TakeScan())
    state = line.ended(samples.scan(1))
    assert state.hands_open == () and not may_hold(state)
    assert "no hand may hold" in refused(line, ConfirmHandsEmpty())


def test_the_hand_of_an_arm_that_was_open_since_before_a_scan_can_be_seen_empty(cell, samples):
    line = broken_off(cell, samples)
    line.do(TakeScan())
    assert line.ended(samples.scan(1)).hands_open == ("right",)
    assert "no arm 'middle'" in refused(line, ConfirmHandsEmpty("middle"))
    assert line.do(ConfirmHandsEmpty("right")).hands_open == ()


def test_after_a_hand_was_seen_empty_what_the_other_has_placed_stays_taken(cell, samples):
    (plan,) = broken_off(cell, samples).state.unscanned.plans
    pick, lies = plan.picks[0], plan.detections[0]
    left = replace(pick, arm="left", detection=1)
    both = replace(plan, arms=(pick, left), detections=(lies, lies))
    state = Line(read_cell("yumi")).state
    double = Outcome(0, is_picked=True, by="ada", result=PickResult.DOUBLE)
    pile = SimulatedPile(0, 3, "", state.cell.bin.name)
    state = replace(state, phase=Phase.DONE, plan=both, outcomes=(double,), pile=pile, is_over=True)
    line = Line(state.cell)
    line.state = state
    assert left_pile(line.state, TakeScan(parts=3, stays=True)).left == 1
    line.do(ConfirmHandsEmpty("right"))
    assert left_pile(line.state, TakeScan(parts=3, stays=True)).left == 1


def test_a_plan_that_was_never_sent_leaves_no_hand_open(cell, samples):
    line = Line(cell)
    make_plan(samples, line)
    line.do(TakeScan())
    assert line.ended(samples.scan(1)).hands_open == ()


def test_a_double_pick_leaves_the_hand_open_though_all_parts_were_placed(cell, samples):
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded(parts_placed=1))
    line.do(ReportPick(0, True, result=PickResult.DOUBLE))
    line.do(TakeScan())
    state = line.ended(samples.scan(1))
    assert state.hands_open == ("right",) and may_hold(state)


def test_a_recipe_that_leaves_kinds_out_is_no_cell_to_drop_back_in(cell, samples):
    line = broken_off(cell, samples)
    fewer = replace(line.state.cell, parts=())
    line.state = replace(line.state, cell=fewer, whole=line.state.cell)
    assert "which the recipe leaves out" in refused(line, PlanDropBack())


def test_what_was_dropped_back_lies_in_the_simulated_bin(cell, samples):
    line = broken_off(cell, samples)
    line.do(PlanDropBack())
    send_drop(line, samples, cell)
    state = line.do(LinkEnded())
    pile = left_pile(state, TakeScan(stays=True))
    assert pile is None or pile.lifted == ()


def test_a_double_pick_makes_it_the_next_step_and_a_dropped_part_only_offers_it(cell, samples):
    for result, is_next in ((PickResult.DOUBLE, True), (PickResult.DROPPED, False)):
        line = Line(cell)
        send(line, samples)
        line.do(LinkEnded())
        assert not may_hold(line.state)
        line.do(ReportPick(0, result.is_picked, result=result))
        assert may_hold(line.state) and is_drop_next(line.state) is is_next


def test_what_it_cannot_begin_from_is_refused_with_one_sentence(cell, samples):
    line = broken_off(cell, samples)
    assert "one, two or unknown" in refused(line, PlanDropBack("three"))
    assert "no arm 'middle'" in refused(line, PlanDropBack(arm="middle"))
    line.joints = {}
    assert "does not report where arm" in refused(line, PlanDropBack())
    motion = replace(cell.controller.motion, keeps_hand=False)
    other = replace(cell, controller=replace(cell.controller, motion=motion))
    line.state = replace(line.state, cell=other)
    reports(line, cell)
    assert "cannot begin a plan with a part in the hand" in refused(line, PlanDropBack())


def test_without_a_path_the_state_stays_and_says_why(cell, samples):
    line = broken_off(cell, samples)
    line.do(PlanDropBack())
    verdict = Verdict(Reason.IN_COLLISION, Stage.ROUTE)
    state = line.ended(PlanResult((), None, None, verdict, {}))
    assert state.phase is Phase.IDLE and "take the part out by hand" in str(state.message)
    assert is_drop_next(state)


def test_a_fault_on_the_way_is_a_fault_like_any(cell, samples):
    line = broken_off(cell, samples)
    line.do(PlanDropBack())
    send_drop(line, samples, cell)
    assert line.do(LinkEnded("the cable is out")).phase is Phase.FAULT


def test_the_other_hand_has_to_be_empty_by_what_is_known(cell, samples):
    (plan,) = broken_off(cell, samples).state.unscanned.plans
    pick = plan.picks[0]
    both = replace(plan, arms=(pick, replace(pick, arm="left")))
    line = Line(read_cell("yumi"))
    reports(line, line.state.cell)
    line.state = replace(line.state, unscanned=SentFor((both,)))
    refusal = refused(line, PlanDropBack(arm="right"))
    assert "arm left may hold a part, too" in refusal and "empty it by hand" in refusal
    by_link, by_ada = (Outcome(pick.detection, is_picked=True, by=by) for by in (ROBOT_LINK, "ada"))
    line.state = replace(line.state, unscanned=SentFor((both,), (by_link,)))
    assert "arm left may hold a part" in refused(line, PlanDropBack(arm="right"))
    line.state = replace(line.state, unscanned=SentFor((both,), (by_ada,)))
    assert line.do(PlanDropBack(arm="right")).job is not None
    line.state = replace(line.state, job=None, unscanned=SentFor((both,)), hands_emptied=("left",))
    assert line.do(PlanDropBack(arm="right")).job is not None


def test_after_a_drop_back_a_plan_without_a_part_does_not_bring_it_back(cell, samples):
    line = broken_off(cell, samples)
    line.do(PlanDropBack())
    send_drop(line, samples, cell)
    state = line.do(LinkEnded())
    assert state.hands_emptied == ("right",) and not may_hold(state)
    assert not may_hold(replace(state, phase=Phase.IDLE, plan=None, proof=None))
    send(line, samples)
    assert line.state.hands_emptied == ()


def test_a_lift_begins_nearer_to_its_start_than_other_plans_and_by_what_is_held(cell, samples):
    plan = drop_result(samples, cell, "one").plan
    start, arm = plan.arms[0].legs[0].q[0], cell.arm("right")
    joints = cell.joint_values({arm.name: arm.home for arm in cell.arms})
    joints |= dict(zip(arm.joints, start, strict=True))
    policy = replace(cell.policy, margin=0.02, near_margin=0.002)
    cell = replace(cell, policy=policy)
    assert moved_away(cell, plan, joints) is None
    holding = with_held(cell, "right", HeldAmount.ONE)
    turned = {arm.joints[0]: start[0] + 1.0}
    lever = shift_of(holding, holding.arm("right"), start, turned).shift
    assert lever > shift_of(cell, arm, start, turned).shift + 0.01
    joints[arm.joints[0]] += 0.005 / lever
    assert "2.0 mm are allowed" in str(moved_away(cell, plan, joints))
    held = replace(plan.arms[0], legs=plan.arms[0].legs[1:])
    later = replace(plan, arms=(held,), sequence=plan.sequence[1:])
    joints[arm.joints[0]] += held.legs[0].q[0][0] - start[0]
    assert moved_away(cell, later, joints) is None

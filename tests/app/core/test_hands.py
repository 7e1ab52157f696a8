"""Hands that may hold a part: by what was sent, how that ended, and what people have seen."""

from dataclasses import replace

import numpy as np
import pytest
from dropping import keeping_hand
from line import Line, refused, send
from samples import Samples

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ReportPick
from workbench.app.core.cycle.scanning import TakeScan, left_pile
from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.core.drop_back import ConfirmHandsEmpty, PlanDropBack
from workbench.app.core.hands import arms_that_may_hold, is_drop_next, may_hold
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import Outcome, SentFor, SimulatedPile
from workbench.app.core.state import Phase
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.scales import scale_mesh
from workbench.gui.cycle.approval_views import facts_html
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused
from workbench.model.plan import NO_PART, Proven
from workbench.model.release import PartReport


@pytest.fixture
def cell(make_cell):
    return keeping_hand(make_cell())


@pytest.fixture
def samples(cell):
    return Samples(cell)


def slower(cell: Cell) -> Cell:
    return replace(cell, policy=replace(cell.policy, speed=cell.policy.speed / 2))


def two_arms_on_their_way() -> Line:
    """Both arms of a cell take a part each."""
    cell = read_cell("yumi")
    samples = Samples(cell)
    plan = samples.plan("scan")
    parts = (*samples.detections(), *samples.detections(1))
    pick = plan.arms[0]
    both = replace(plan, detections=parts, arms=(pick, replace(pick, arm="left", detection=1)))
    line = Line(cell)
    line.state = replace(line.state, phase=Phase.SENDING, plan=both, proof=samples.proof(both))
    return line


def test_parts_that_were_all_placed_leave_no_hand_open_though_the_cell_changes(cell, samples):
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded(parts_placed=1))
    state = line.do(ChangeCell(slower(cell), "slower"))
    assert state.phase is Phase.IDLE and state.unscanned is not None
    assert not arms_that_may_hold(state) and not may_hold(state) and not is_drop_next(state)
    line.do(TakeScan())
    assert line.ended(samples.scan(1)).hands_open == ()


def test_a_link_that_reports_no_parts_leaves_no_hand_in_doubt_when_its_plan_has_ended(
    cell, samples
):
    line = Line(cell)
    send(line, samples)
    assert arms_that_may_hold(line.state), "while the robot moves"
    line.do(LinkEnded(parts=(PartReport("right", 0, None),)))
    assert not arms_that_may_hold(line.state) and not may_hold(line.state)
    send(line, samples)
    assert line.state.phase is Phase.SENDING, "the next cycle is approved as ever"


def test_a_part_that_was_not_picked_leaves_the_other_hand_empty(samples):
    line = two_arms_on_their_way()
    reports = (PartReport("right", 0, True), PartReport("left", 1, False))
    line.do(LinkEnded(parts_placed=1, parts=reports))
    assert line.state.phase is Phase.DONE and not arms_that_may_hold(line.state)
    line.do(TakeScan())
    assert line.ended(samples.scan(1)).hands_open == ()


def test_of_a_row_only_the_plan_that_broke_off_leaves_a_part_in_a_hand(cell, samples):
    result = samples.row("scan")
    line = Line(cell)
    first, second = Proven(result.plan, result.proof), result.row[0]
    line.state = replace(
        line.state,
        phase=Phase.SENDING,
        plan=replace(second.plan, arms=(replace(second.plan.arms[0], arm="left"),)),
        proof=second.proof,
        sent_before=(first,),
        outcomes=(Outcome(0, True, ROBOT_LINK, is_early=True),),
    )
    line.do(LinkEnded("stopped by ada"))
    assert arms_that_may_hold(line.state) == {"left"}


def test_who_sees_a_part_picked_before_the_stop_has_not_seen_it_leave_the_hand(cell, samples):
    line = Line(cell)
    send(line, samples)
    line.do(ReportPick(0, True))
    line.do(LinkEnded("stopped by ada"))
    state = line.do(AcknowledgeFault())
    assert arms_that_may_hold(state) == {"right"} and is_drop_next(state)
    assert "confirm it, or drop back" in str(state.message)
    state = line.do(ReportPick(0, True))
    assert not arms_that_may_hold(state) and not is_drop_next(state)
    assert "ada has reported that already" in refused(line, ReportPick(0, True))


def test_a_part_that_a_gripper_has_felt_before_the_stop_is_offered_to_be_dropped_back():
    line = two_arms_on_their_way()
    reports = (PartReport("right", 0, True), PartReport("left", 1, None))
    line.do(LinkEnded("stopped by ada", parts=reports))
    line.do(ReportPick(1, False))
    state = line.do(AcknowledgeFault())
    assert arms_that_may_hold(state) == {"right"} and may_hold(state)
    assert not arms_that_may_hold(line.do(ReportPick(0, True)))


def test_arms_that_the_cell_does_not_have_any_more_are_not_asked_for(cell, samples):
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded("stopped by ada"))
    line.do(AcknowledgeFault())
    (arm,) = cell.arms
    other = replace(cell, arms=(replace(arm, name="middle"),))
    line.do(ChangeCell(other, "another arm"))
    line.joints = other.joint_values({"middle": arm.home})
    line.do(PlanDropBack())
    assert line.effects[-1].arguments["arm"] == "middle"


def test_every_approval_but_that_of_a_drop_back_names_hands_that_may_hold_a_part(cell, samples):
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded("stopped by ada"))
    state = line.do(AcknowledgeFault())
    plan = samples.plan("none")
    nothing = replace(plan.arms[0], detection=NO_PART, grasp="", tool="other")
    change = replace(plan, arms=(nothing,), detections=())
    drop = replace(change, arms=(replace(nothing, tool="", held="one"),))
    for made, is_named in ((change, True), (drop, False)):
        shown = replace(state, phase=Phase.PLANNED, plan=made, proof=samples.proof(made))
        html = facts_html(shown, {}, line.now)
        assert ("right may still hold a part" in html) is is_named


def test_a_plan_that_takes_a_part_with_a_hand_that_may_hold_another_is_not_approved(samples):
    line = Line(samples.cell)
    send(line, samples)
    line.do(LinkEnded("stopped by ada"))
    line.do(AcknowledgeFault())
    with pytest.raises(CommandRefused) as refusal:
        send(line, samples)
    said = str(refusal.value)
    assert "hand of arm right" in said and "Drop back" in said and "Hands are empty" in said
    assert line.state.phase is Phase.PLANNED
    line.do(ConfirmHandsEmpty())
    assert line.do(Approve(line.state.plan.digest)).phase is Phase.APPROVED


def test_a_kind_that_the_cell_has_lost_since_is_dropped_back_by_no_plan(cell, samples):
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded("stopped by ada"))
    line.do(AcknowledgeFault())
    peg = cell.parts[0]
    short = replace(peg, mesh=scale_mesh(peg.mesh, 0.5, np.zeros(3)))
    line.do(ChangeCell(replace(cell, parts=(short,)), "a shorter peg"))
    line.joints = cell.joint_values({arm.name: arm.home for arm in cell.arms})
    assert "longer or heavier part than the cell has" in refused(line, PlanDropBack("one"))
    line.do(ChangeCell(cell, "the peg again"))
    assert line.do(PlanDropBack("one")).job is not None


def test_a_simulated_part_that_was_placed_stays_away_though_the_cell_changes(cell, samples):
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded(parts_placed=1))
    line.state = replace(line.state, pile=SimulatedPile(0, 3, "", cell.bin.name))
    state = line.do(ChangeCell(slower(cell), "slower"))
    assert left_pile(state, TakeScan(parts=3, stays=True)).left == 2


def test_a_simulated_part_of_a_row_that_broke_off_lies_in_the_bin_and_those_before_are_away():
    line = two_arms_on_their_way()
    first = line.state.plan
    second = replace(first, arms=first.arms[1:])
    one = replace(first, arms=first.arms[:1])
    line.state = replace(
        line.state,
        phase=Phase.IDLE,
        plan=None,
        unscanned=SentFor((one, second)),
        pile=SimulatedPile(0, 3, "", line.state.cell.bin.name),
    )
    assert left_pile(line.state, TakeScan(parts=3, stays=True)).left == 2


def test_a_sending_that_breaks_off_at_once_leaves_the_longer_part_of_before_in_the_hand(
    cell, samples
):
    line = Line(cell)
    send(line, samples)
    line.do(LinkEnded("stopped by ada"))
    line.do(AcknowledgeFault())
    longest = line.state.largest_sent
    peg = cell.parts[0]
    short = replace(peg, mesh=scale_mesh(peg.mesh, 0.5, np.zeros(3)))
    shorter = replace(cell, parts=(short,))
    line.do(ChangeCell(shorter, "a shorter peg"))
    line.do(ConfirmHandsEmpty())
    # The part is in the hand of another arm.
    line.state = replace(line.state, hands_open=("left",))
    send(line, Samples(shorter))
    assert line.state.largest_sent == longest
    line.do(LinkEnded(parts_placed=1))
    line.state = replace(line.state, hands_open=())
    send(line, Samples(shorter))
    assert line.state.largest_sent[0] < longest[0]

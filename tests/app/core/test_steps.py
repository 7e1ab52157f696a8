"""A plan sent step by step, and slower: who lets what run, and when no longer."""

from dataclasses import replace

import pytest
from line import NOW, Line, planned_line, refused

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.sending import LinkEnded, NextStep, SendPlan, Sent, Stop, step_problem
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.decide import check_allowed
from workbench.app.core.effects import LetStep, Send, StopSending
from workbench.app.core.people import Role
from workbench.app.core.state import Phase
from workbench.model.errors import CommandRefused
from workbench.model.release import Approval, Receipt, Vote
from workbench.plugins.robot_link import spoken_to_by


@pytest.fixture
def line(samples, cell) -> Line:
    one = planned_line(samples, spoken_to_by(cell, "abb-socket/2"))
    one.do(WatchPlan(one.state.plan.digest))
    return one


@pytest.fixture
def sending(line) -> Line:
    digest = line.state.plan.digest
    line.do(Approve(digest, is_stepped=True))
    line.do(SendPlan(digest))
    return line


def waits(line, number):
    line.do(
        Sent(Receipt(line.now, "", "heard", "", 9, 9, f"state waiting {number:02d}", waits=number))
    )


def test_the_approval_says_how_and_is_another_one_by_that(line):
    digest, total = line.state.plan.digest, set()
    for how in (
        {},
        {"speed_share": 0.25},
        {"is_stepped": True},
        {"speed_share": 0.25, "is_stepped": True},
    ):
        state = line.do(Approve(digest, **how))
        assert state.approval.manner == (how.get("speed_share", 1.0), how.get("is_stepped", False))
        total.add(state.approval.digest)
    assert len(total) == 4
    assert str(state.message).endswith(
        "by ada, to be sent at 25% of the planned speed, step by step"
    )
    line.do(SendPlan(digest))
    assert line.effects[-1].approval is state.approval and isinstance(line.effects[-1], Send)


def test_approvals_and_votes_as_they_were_have_the_digests_they_had():
    approval = Approval("p", "q", "c", "s", "ada", 1.0, 2.0, (Vote("p", "eve", 0.5),))
    assert approval.digest == "72af814e77f1bf23aeedbe72e6c588ffaaa6f5a4b746936df526d36fb3159d13"


@pytest.mark.parametrize("share", [0.0499, 1.001, 0, 2, float("nan"), "1", None, True])
def test_no_other_share_is_taken(line, share):
    assert "speed share must lie between 0.05" in refused(
        line, Approve(line.state.plan.digest, share)
    )


def test_step_by_step_is_yes_or_no(line):
    said = refused(line, Approve(line.state.plan.digest, is_stepped="perhaps"))
    assert said == "step by step is either so or not, 'perhaps' is neither"


def test_what_the_link_cannot_do_is_not_approved(samples, cell):
    line = planned_line(samples, spoken_to_by(cell, "abb-socket"))
    line.do(WatchPlan(line.state.plan.digest))
    digest = line.state.plan.digest
    assert "abb-socket cannot send a plan at a share" in refused(line, Approve(digest, 0.5))
    assert "abb-socket cannot send a plan step by step" in refused(
        line, Approve(digest, is_stepped=True)
    )


def test_votes_for_another_manner_do_not_count_together(samples, cell):
    line = planned_line(samples, spoken_to_by(replace(cell, approvers=2), "abb-socket/2"))
    digest = line.state.plan.digest
    line.do(WatchPlan(digest), "operator")
    line.do(Approve(digest, 0.25), "ada")
    assert line.do(Approve(digest), "eve").approval is None
    assert str(line.state.message) == "approved by eve, 1 of 2 people"
    assert "eve has approved already" in refused(line, Approve(digest), "eve")
    # Who changes their mind gives another vote.
    assert line.do(Approve(digest, 0.1), "eve").approval is None
    assert line.do(Approve(digest, 0.1), "ada").approval.people == ("eve", "ada")
    assert line.state.approval.speed_share == 0.1


def test_each_step_runs_by_one_word_of_a_person(sending):
    total = len(sending.state.plan.sequence)
    for number in range(1, total + 1):
        assert "does not wait before a step now" in refused(sending, NextStep(number))
        waits(sending, number)
        assert sending.state.waits == number
        assert f"waits before step {number} of {total}, " in str(sending.state.message)
        for other in (number - 1, number + 1):
            if other:
                assert f"waits before step {number}, not {other}" in refused(
                    sending, NextStep(other)
                )
        assert sending.do(NextStep(number)).waits == 0
        assert sending.effects[-1].number == number and isinstance(sending.effects[-1], LetStep)
        assert str(sending.state.message).endswith("released by ada")
        sending.do(Sent(Receipt(NOW, "", "heard", "", 9, 9, "state running")))
        assert str(sending.state.message).endswith("released by ada")
    assert sum(isinstance(one, LetStep) for one in sending.effects) == total
    assert sending.do(LinkEnded()).phase is Phase.DONE and sending.state.waits == 0


def test_a_report_of_a_step_that_ran_already_lets_nothing_run(sending):
    waits(sending, 1)
    sending.do(NextStep(1))
    for number in (1, 3):
        waits(sending, number)
        assert "does not wait before a step now" in refused(sending, NextStep(number))


def test_nobody_lets_a_step_run_after_the_minutes_of_an_approval(sending):
    minutes = sending.state.cell.policy.approval_minutes * 60
    waits(sending, 1)
    sending.now = NOW + minutes - 1
    sending.do(NextStep(1))
    waits(sending, 2)
    # Counted from the last word of a person.
    sending.now += minutes - 1
    assert step_problem(sending.state, 2, sending.now) is None
    sending.now += 1
    for late in (sending.now, NOW - 1):
        sending.now = late
        assert "the approval holds no longer; stop" in refused(sending, NextStep(2))
    assert isinstance(sending.do(Stop()) and sending.effects[-1], StopSending)


def test_a_plan_in_one_go_has_no_steps_to_let_run(line):
    digest = line.state.plan.digest
    assert "nothing is being sent" in refused(line, NextStep(1))
    line.do(Approve(digest))
    line.do(SendPlan(digest))
    assert refused(line, NextStep(1)) == "the plan is not sent step by step"


def test_who_may_send_may_let_a_step_run(sending):
    waits(sending, 1)
    with pytest.raises(CommandRefused, match="for operators"):
        check_allowed(sending.state, NextStep(1), "eve", NOW, {}, Role.VIEWER)
    sending.state = replace(sending.state, control="ada")
    assert "ada is in control" in refused(sending, NextStep(1), "eve")
    for number in (True, 1.0, "1", None):
        assert "number" in refused(sending, NextStep(number))
    assert sending.do(NextStep(1), "ada").let == 1


def test_what_the_robot_runs_is_told_by_the_step_that_it_reports(line):
    digest = line.state.plan.digest
    line.do(Approve(digest))
    line.do(SendPlan(digest))
    assert (
        str(line.do(Sent(Receipt(NOW, "right", "in", "...", 5, 5))).message)
        == "5 of 5 messages sent"
    )
    state = line.do(Sent(Receipt(NOW, "", "heard", "", 5, 5, "running 02", step=2)))
    assert str(state.message).startswith("the robot runs step 2 of ")
    state = line.do(Sent(Receipt(NOW, "", "heard", "", 5, 5, "running 02")))
    assert str(state.message).startswith("the robot runs step 2 of ")

"""What became of the parts: a reason belongs to the failure that it was typed for."""

import re
from dataclasses import replace

import pytest

from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.picks import Outcome, SentFor
from workbench.app.core.state import Phase, State
from workbench.gui.cycle.outcomes import OutcomeInputs
from workbench.model.release import PickResult, Receipt

PICKED, FAILED = PickResult.PICKED, PickResult.FAILED


@pytest.fixture
def inputs(visitor, states, view_of, monkeypatch):
    """After a plan was sent, with a reason typed; everything that is said is taken."""
    inputs = OutcomeInputs(visitor, "")
    inputs.state = states.done
    monkeypatch.setattr(type(visitor.bench), "state", property(lambda _: inputs.state))
    inputs.show(None, view_of(states.done))
    inputs._why.value = "slipped"
    given = inputs.given = []
    monkeypatch.setattr(visitor, "give", lambda command, name="": given.append(command))
    return inputs


@pytest.fixture
def broken_off(row):
    """Of three plans two were sent, then there was a fault."""
    first, second, third = row.whole_row
    return replace(
        row,
        phase=Phase.FAULT,
        plan=second.plan,
        proof=second.proof,
        sent_before=(first,),
        row=(third,),
    )


def shown(inputs):
    """What stands beside the buttons that can be seen, and what these are called."""
    return [
        (
            re.search(r"part-\d+( \w+)?", one._text.content)[0],
            *(one._buttons[result].label for result in (PICKED, FAILED)),
        )
        for one in inputs._rows
        if one._text.visible
    ]


def press(button):
    for called in button._impl.update_cb:
        called(None)


def test_why_a_pick_failed_is_said_of_that_pick_alone(inputs, states):
    first, second = inputs._rows
    press(first._buttons[FAILED])
    press(second._buttons[FAILED])
    assert [type(one) for one in inputs.given] == [ReportPick, ReportPick]
    assert [one.why for one in inputs.given] == ["slipped", ""]
    assert inputs._why.value == ""


def test_what_was_refused_keeps_its_reason(inputs, visitor, states, monkeypatch):
    monkeypatch.setattr(visitor, "ask", lambda command: False)
    press(inputs._rows[0]._buttons[FAILED])
    assert inputs._why.value == "slipped"


def test_a_new_scan_asks_for_new_reasons(inputs, states, view_of):
    done = view_of(states.done)
    inputs.show(done, view_of(replace(states.done, message="told")))
    assert inputs._why.value == "slipped"
    inputs.show(done, view_of(replace(states.scanned, scan=replace(states.scanned.scan))))
    assert inputs._why.value == ""


def test_every_part_of_every_plan_that_was_sent_is_asked_for(inputs, broken_off, view_of):
    inputs.state = broken_off
    inputs.show(view_of(broken_off), view_of(replace(broken_off, message="told")))
    arms = [one.arm.capitalize() for one in broken_off.plan.arms]
    own = [one.detection for one in broken_off.plan.arms]
    numbers = [*own, *(number + 2 for number in own)]
    assert shown(inputs) == [
        (f"part-{number + 1}", f"{arm} picked", f"{arm} failed")
        for number, arm in zip(numbers, arms * 2, strict=True)
    ]
    for one in inputs._rows:
        press(one._buttons[FAILED])
    assert [one.detection for one in inputs.given] == numbers
    said = Outcome(numbers[1], False, "Ada")
    inputs.show(view_of(broken_off), view_of(replace(broken_off, outcomes=(said,))))
    assert shown(inputs)[1][0] == f"part-{numbers[1] + 1} failed"
    assert [one._buttons[FAILED].disabled for one in inputs._rows] == [False, True, False, False]


def test_after_a_row_one_plan_has_its_own_parts_alone(inputs, broken_off, states, view_of):
    alone = shown(inputs)
    assert len(alone) == len(states.done.plan.arms)
    inputs.show(view_of(states.done), view_of(broken_off))
    assert len(shown(inputs)) == 2 * len(alone)
    inputs.show(view_of(broken_off), view_of(states.done))
    assert shown(inputs) == alone
    inputs.show(view_of(states.done), view_of(states.scanned))
    assert shown(inputs) == []


def test_a_word_is_of_what_was_shown_and_not_of_what_was_sent_since(inputs, broken_off, visitor):
    inputs.state = broken_off
    press(inputs._rows[0]._buttons[FAILED])
    assert inputs.given == []
    assert "another plan was sent meanwhile" in visitor.client.told[-1]
    assert inputs._why.value == "slipped"


def test_the_reason_is_typed_below_all_rows(inputs, broken_off, view_of):
    inputs.show(None, view_of(broken_off))
    assert max(one._buttons[FAILED].order for one in inputs._rows) < inputs._why.order


def test_an_acknowledged_fault_leaves_the_parts_to_be_told_of(inputs, broken_off, view_of):
    sent = SentFor(broken_off.plans[:2], (Outcome(1, True, "Ada"),))
    after = State(broken_off.cell, message="fault acknowledged", unscanned=sent)
    inputs.show(None, view_of(broken_off))
    before = shown(inputs)
    inputs.state = after
    inputs.show(view_of(broken_off), view_of(after))
    assert inputs._folder.visible
    assert [names for _, *names in shown(inputs)] == [names for _, *names in before]
    assert "part-2 picked" in [text for text, *_ in shown(inputs)]
    press(inputs._rows[0]._buttons[FAILED])
    assert [(one.detection, one.why) for one in inputs.given] == [(0, "slipped")]
    scanned = replace(after, phase=Phase.SCANNED, unscanned=None)
    inputs.state = scanned
    inputs.show(view_of(after), view_of(scanned))
    assert not inputs._folder.visible and shown(inputs) == []


def test_a_dropped_part_and_two_in_the_hand_have_a_button_each(inputs, states, view_of):
    first = inputs._rows[0]
    press(first._buttons[PickResult.DROPPED])
    press(first._buttons[PickResult.DOUBLE])
    assert [(one.is_picked, one.result, one.why) for one in inputs.given] == [
        (False, PickResult.DROPPED, "slipped"),
        (True, PickResult.DOUBLE, ""),
    ]
    said = Outcome(first._shown[1], True, "Ada", result=PickResult.DOUBLE)
    inputs.show(view_of(states.done), view_of(replace(states.done, outcomes=(said,))))
    assert "double" in first._text.content and "wb-bad" in first._text.content
    assert [result for result, one in first._buttons.items() if one.disabled] == ["double"]


def test_while_the_robot_moves_only_results_that_can_be_seen_are_offered(inputs, states, view_of):
    plan = states.sending.plan
    first = plan.picks[0]
    numbers = [
        number
        for number, step in enumerate(plan.sequence, 1)
        if any(arm == first.arm and first.leg(leg).holding for arm, leg in step.runs)
    ]

    def offered(state):
        inputs.show(None, view_of(state))
        buttons = inputs._rows[0]._buttons
        assert all(button.hint for button in buttons.values())
        return {result for result, button in buttons.items() if not button.disabled}

    def at_step(number):
        told = Receipt(0.0, "", "heard", "", 4, 4, step=number)
        return replace(states.sending, receipts=(told,))

    assert offered(states.sending) == set()
    assert offered(at_step(numbers[0] - 1)) == set()
    assert offered(at_step(numbers[0])) == {FAILED, PickResult.DROPPED}
    assert offered(states.done) == set(PickResult)


def test_the_parts_of_a_plan_before_in_the_row_have_all_results(inputs, broken_off, view_of):
    inputs.show(None, view_of(replace(broken_off, phase=Phase.SENDING)))
    open_ = [not row._buttons[PICKED].disabled for row in inputs._rows]
    assert open_ == [True, True, False, False]

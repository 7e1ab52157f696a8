"""The buttons that pass control on: a double click is one press."""

import pytest

import workbench.gui.page.control
from workbench.app.core.control import AskForControl, TakeControl
from workbench.app.core.people import Role
from workbench.gui.page.control import DOUBLE_CLICK, SETTLING, ControlStrip
from workbench.gui.shared.viser_server import buttons_of


@pytest.fixture
def clock(monkeypatch):
    """The time that the strip reads [s]; to be set."""
    now = [100.0]
    monkeypatch.setattr(workbench.gui.page.control.time, "monotonic", lambda: now[0])
    return now


@pytest.fixture
def strip(visitor, bench, view_of, clock):
    """Of Ada, who is in control, while Bob and Cem ask for it."""
    bench.do(TakeControl(), "Ada", Role.ENGINEER)
    for name in ("Bob", "Cem"):
        bench.do(AskForControl(), name, Role.OPERATOR)
    strip = ControlStrip(visitor)
    strip.show(None, view_of(bench.state))
    return strip


def click(button):
    for called in button._impl.update_cb:
        called(None)


def dialogs_of(visitor):
    return list(visitor.gui._modal_handle_from_uuid.values())


def button_of(visitor, label):
    """The button with this label."""
    return next(button for button in buttons_of(visitor.gui) if button.label == label)


def test_a_double_click_on_keep_answers_one_person(strip, visitor, bench, view_of, clock):
    click(strip._keep)
    before = bench.state
    strip.show(None, view_of(before))
    assert before.asking == ("Cem",)
    clock[0] += DOUBLE_CLICK / 2
    click(strip._keep)
    assert bench.state is before, "the second click was not about Cem"
    clock[0] += DOUBLE_CLICK
    click(strip._keep)
    assert bench.state.asking == () and bench.state.control == "Ada"


def test_a_press_soon_after_control_has_changed_is_ignored(strip, visitor, bench, view_of, clock):
    before = view_of(bench.state)
    click(strip._give)
    strip.show(before, view_of(bench.state))
    assert bench.state.control == "Bob" and strip._take.visible
    clock[0] += SETTLING * 0.9
    click(strip._take)
    click(strip._ask)
    assert bench.state.control == "Bob" and bench.state.asking == ("Cem",)
    clock[0] += SETTLING
    click(strip._take)
    assert bench.state.control == "Bob", "Ada is asked first"
    click(button_of(visitor, "Take over from Bob"))
    assert bench.state.control == "Ada"


def test_a_request_for_control_makes_no_button_wait(strip, visitor, bench, view_of, clock):
    before = view_of(bench.state)
    bench.do(AskForControl(), "Dan", Role.OPERATOR)
    strip.show(before, view_of(bench.state))
    click(strip._give)
    assert bench.state.control == "Bob"


def test_a_double_click_on_hand_over_and_take_over_is_not_refused(strip, visitor, bench, clock):
    told = len(visitor.client.told)
    click(strip._give)
    click(strip._give)
    assert bench.state.control == "Bob"
    clock[0] += 1.0
    click(strip._take)
    click(strip._take)
    assert bench.state.control == "Bob" and len(dialogs_of(visitor)) == 1
    click(button_of(visitor, "Take over from Bob"))
    assert bench.state.control == "Ada" and dialogs_of(visitor) == []
    assert len(visitor.client.told) == told


def test_the_person_whose_control_is_taken_over_gets_a_note(strip, visitor, bench, view_of):
    before, count = view_of(bench.state), len(visitor.client.told)
    bench.do(TakeControl(), "Eve", Role.ENGINEER)
    strip.show(before, view_of(bench.state))
    assert visitor.client.told[count:] == ["Control was taken over from you."]
    strip.show(view_of(bench.state), view_of(bench.state))
    assert len(visitor.client.told) == count + 1


def test_no_note_of_a_loss_follows_hand_over_and_release(strip, visitor, bench, view_of, clock):
    before, count = view_of(bench.state), len(visitor.client.told)
    click(strip._give)
    strip.show(before, view_of(bench.state))
    assert bench.state.control == "Bob"
    assert len(visitor.client.told) == count, "Ada has given it away"


def test_a_request_says_where_its_buttons_are(strip, visitor):
    assert visitor.client.told[-1] == "Hand over or Keep, in the panel."


def test_a_request_is_answered_in_the_row_of_the_line(visitor, bench, view_of, clock):
    def row():
        shown = (strip._line, strip._ask, strip._back, strip._take, strip._give, strip._keep)
        return [control for control in shown if control.visible]

    bench.do(TakeControl(), "Ada", Role.ENGINEER)
    strip = ControlStrip(visitor)
    strip.show(None, before := view_of(bench.state))
    assert row() == [strip._line, strip._back]
    bench.do(AskForControl(), "Bob", Role.OPERATOR)
    strip.show(before, view_of(bench.state))
    assert row() == [strip._give, strip._keep], "one row of two columns, as before"


@pytest.fixture
def asked(strip, visitor, bench, view_of, clock):
    """Ada's strip after she has pressed Take over while Bob is in control."""
    click(strip._give)
    clock[0] += 1.0
    strip.show(None, view_of(bench.state))
    clock[0] += SETTLING
    click(strip._take)
    assert len(dialogs_of(visitor)) == 1 and bench.state.control == "Bob"
    return strip


def test_back_leaves_control_where_it_is(asked, visitor, bench):
    click(button_of(visitor, "Back"))
    assert bench.state.control == "Bob" and dialogs_of(visitor) == []


def test_the_dialog_closes_when_somebody_else_takes_control(asked, visitor, bench, view_of):
    take = button_of(visitor, "Take over from Bob")
    bench.do(TakeControl(), "Eve", Role.ENGINEER)
    click(take)
    assert bench.state.control == "Eve", "the dialog named Bob"
    asked.show(None, view_of(bench.state))
    assert dialogs_of(visitor) == []

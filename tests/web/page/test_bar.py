"""What the bar above the scene says, and that it says it to whoever is logged in."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.app.core.people import Person, Role
from workbench.app.core.state import Phase, State
from workbench.app.runtime.live import Live
from workbench.formats.cells.reading import read_cell
from workbench.model.messages.work import LinkText, StopText
from workbench.model.release import LinkStatus, Receipt
from workbench.web.page.bar import bar_words, without_robot

OTTO, VERA = Person("Otto", Role.OPERATOR), Person("Vera", Role.VIEWER)


@pytest.fixture(scope="module")
def idle():
    return State(read_cell("yumi"))


def test_stop_can_be_pressed_exactly_while_something_is_sent_also_by_who_is_not_in_control(idle):
    for phase in Phase:
        state = replace(idle, phase=phase, control="Anna", fault="x" if phase == "fault" else "")
        said = bar_words(state, Live(), OTTO)
        assert said["can_stop"] == (phase is Phase.SENDING)
        assert bool(said["why"]) != said["can_stop"]
        assert not bar_words(state, Live(), VERA)["can_stop"]


def test_the_robot_and_the_fault_are_said_in_words_and_with_a_kind(idle):
    assert bar_words(idle, Live(), OTTO)["robot"] == "Robot: no report"
    live = Live(robot=LinkText.STANDS(), link=LinkStatus(phase="running", step=3, steps=12))
    assert bar_words(idle, live, OTTO)["kind"] == "good"
    sending = bar_words(replace(idle, phase=Phase.SENDING), live, OTTO)
    assert (str(sending["robot"]), sending["kind"]) == ("Sending: robot stands", "busy")
    assert (
        bar_words(idle, Live(robot=LinkText.FAULT(fault="emergency stop")), OTTO)["kind"] == "bad"
    )
    broken = replace(idle, phase=Phase.FAULT, fault="the controller closed the link")
    assert str(bar_words(broken, live, OTTO)["fault"]) == "the controller closed the link"
    assert bar_words(idle, live, OTTO)["fault"] == ""
    unseen = replace(live, link=LinkStatus(stop=LinkText.NOT_SEEN_STANDING()))
    told = str(bar_words(broken, unseen, OTTO)["fault"])
    assert told == f"the controller closed the link; {LinkText.NOT_SEEN_STANDING()}"
    stopped = StopText.ACKNOWLEDGED(took=0.007)
    broken = replace(broken, fault=StopText.AT(where="step 2 of 11", how=stopped))
    told = str(bar_words(broken, replace(live, link=LinkStatus(stop=stopped)), OTTO)["fault"])
    assert told.count(str(stopped)) == 1


def test_a_page_without_a_robot_has_no_bar():
    said = without_robot(OTTO)
    assert said.keys() == bar_words(State(read_cell("yumi")), Live(), OTTO).keys()
    assert not said["has_robot"] and not said["can_stop"]


def test_the_bar_names_the_step_that_the_journal_has():
    heard = Receipt(0.0, "", "heard", "", 4, 4, "state", step=2)
    live = Live(robot=LinkText.STANDS(), link=LinkStatus(phase="running", step=3, steps=12))
    plan = SimpleNamespace(sequence=(None,) * 12)
    state = replace(State(read_cell("yumi"), phase=Phase.SENDING), plan=plan, receipts=(heard,))
    assert str(bar_words(state, live, OTTO)["robot"]) == "Sending: robot stands, step 2 of 12"

"""Control goes to the first one who may act, stays through reconnects, and goes with its person."""

import pytest

from workbench.app.core.control import TakeControl
from workbench.app.core.people import NOBODY, Person, Role
from workbench.gui.page.control import control_message
from workbench.gui.page.presence import GRACE, BrowserCount
from workbench.model.errors import NotRecorded

ADA = Person("Ada", Role.ENGINEER)
BOB = Person("Bob", Role.OPERATOR)
VIC = Person("Vic", Role.VIEWER)


@pytest.fixture
def presence(bench):
    return BrowserCount(bench, 0.0)


def test_the_first_who_may_act_is_in_control_and_keeps_it(bench, presence):
    presence.enter(1, VIC)
    assert bench.state.control == ""
    presence.enter(2, BOB)
    presence.enter(3, ADA)
    assert bench.state.control == "Bob"


def test_without_a_login_nobody_needs_control(bench, presence):
    presence.enter(1, Person(NOBODY, Role.ENGINEER))
    presence.look(0.0)
    presence.leave(1, 0.0)
    presence.look(2 * GRACE)
    assert bench.state.control == ""
    assert bench.state.number == 1


def test_control_is_kept_while_a_browser_is_left_or_comes_back_in_time(bench, presence):
    presence.enter(1, BOB)
    presence.enter(2, BOB)
    presence.leave(1, 10.0)
    presence.look(10.0 + 2 * GRACE)
    assert bench.state.control == "Bob", "another browser of the same person is there"
    presence.leave(2, 200.0)
    presence.look(200.0 + GRACE - 1)
    presence.enter(3, BOB)
    presence.look(200.0 + 2 * GRACE)
    assert bench.state.control == "Bob"


def test_control_ends_when_its_person_has_been_gone_for_too_long(bench, presence):
    presence.enter(1, BOB)
    presence.leave(1, 10.0)
    presence.look(10.0 + GRACE - 1)
    assert bench.state.control == "Bob"
    presence.look(10.0 + GRACE)
    assert bench.state.control == ""
    presence.look(10.0 + 3 * GRACE)
    presence.enter(2, BOB)
    assert bench.state.control == "Bob"


def test_who_has_gone_gives_back_nothing_that_is_somebody_elses_by_now(bench, presence):
    presence.enter(1, BOB)
    presence.enter(2, ADA)
    presence.leave(1, 10.0)
    bench.do(TakeControl(), "Ada", Role.ENGINEER)
    presence.look(10.0 + 2 * GRACE)
    assert bench.state.control == "Ada"


def test_a_program_that_took_control_keeps_it_without_any_browser(bench, presence):
    bench.do(TakeControl(), "plc", Role.OPERATOR)
    presence.look(10 * GRACE)
    assert bench.state.control == "plc"


def test_whoever_was_in_control_before_the_workbench_began_again_has_a_while_to_come(bench):
    bench.do(TakeControl(), "Bob", Role.OPERATOR)
    presence = BrowserCount(bench, 100.0)
    presence.look(100.0 + GRACE - 1)
    assert bench.state.control == "Bob"
    presence.look(100.0 + GRACE)
    assert bench.state.control == ""


def test_control_goes_with_its_person_also_when_the_disk_was_full_at_first(
    bench, presence, monkeypatch
):
    presence.enter(1, BOB)
    presence.leave(1, 0.0)
    with monkeypatch.context() as full:

        def fail(*_):
            raise NotRecorded("no space left on device")

        full.setattr(bench, "do", fail)
        presence.look(GRACE)
    assert bench.state.control == "Bob"
    presence.look(2 * GRACE)
    assert bench.state.control == ""


@pytest.mark.parametrize(
    ("me", "words"), [("Bob", "You are in control."), ("Ada", "Bob is in control.")]
)
def test_who_is_in_control_is_said_to_each_in_their_words(bench, me, words):
    assert (
        str(control_message(bench.state, me))
        == "Nobody has taken control; operators and engineers may act."
    )
    bench.do(TakeControl(), "Bob", Role.OPERATOR)
    assert str(control_message(bench.state, me)) == words

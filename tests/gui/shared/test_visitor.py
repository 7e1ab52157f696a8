"""A browser acts as its person: with that name, in that role, and nobody else's."""

from types import SimpleNamespace

import pytest

import workbench.gui.shared.visitor
from workbench.app.core.cell.changes import SaveCell
from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.people import NOBODY, Person, Role
from workbench.gui.shared.look import SharedLook
from workbench.gui.shared.visitor import Visitor
from workbench.model.errors import CommandRefused

ADA = Person("Ada", Role.ENGINEER)
BOB = Person("Bob", Role.OPERATOR)
VIC = Person("Vic", Role.VIEWER)
SOMEBODY = Person(NOBODY, Role.ENGINEER)


@pytest.fixture
def look():
    return SharedLook(lambda: None)


@pytest.fixture
def visitor_of(bench, look, monkeypatch):
    def make(person: Person) -> Visitor:
        monkeypatch.setattr(workbench.gui.shared.visitor, "person_of", lambda client: person)
        monkeypatch.setattr(workbench.gui.shared.visitor, "language_of", lambda client: "en")
        return Visitor(SimpleNamespace(client_id=1, gui=None), bench, look)

    return make


def test_a_command_is_given_in_the_name_and_the_role_of_the_person(bench, visitor_of):
    with pytest.raises(CommandRefused, match="you are an operator"):
        visitor_of(BOB).give(SaveCell(""))
    visitor_of(BOB).give(TakeControl())
    assert bench.state.control == "Bob"


def test_only_who_has_no_login_gives_a_name(bench, visitor_of):
    visitor_of(BOB).give(TakeControl(), "Ada")
    assert bench.state.control == "Bob", "who is logged in speaks for nobody else"
    visitor_of(SOMEBODY).give(TakeControl(), "Ada")
    assert bench.state.control == "Ada"


def test_viewers_follow_what_others_look_at(look, visitor_of):
    viewer, operator = visitor_of(VIC).look, visitor_of(BOB).look
    viewer.change(time=1.0, is_playing=True)
    viewer.change(shapes=True)
    assert look.now.time == 0.0 and not look.now.is_playing and not look.now.shapes
    operator.change(shapes=True)
    assert viewer.now.shapes


def test_whoever_is_not_in_control_plays_the_plan_and_changes_nothing_else(bench, look, visitor_of):
    bench.do(TakeControl(), "Ada")
    operator = visitor_of(BOB).look
    operator.change(time=1.0, is_playing=True, by=None)
    assert look.now.is_playing
    operator.change(shapes=True)
    operator.change(time=2.0, shapes=True)
    assert look.now.time == 1.0 and not look.now.shapes


def test_while_a_plan_is_sent_nobody_plays_it(look, visitor_of, states):
    ada = visitor_of(ADA)
    ada.bench = SimpleNamespace(state=states.sending)
    ada.look.change(time=3.0, is_playing=False, by=1)
    ada.look.change(is_playing=True, by=None, browser=1)
    assert look.now.time == 0.0 and look.now.follows and not look.now.is_playing
    ada.look.change(pose=2, by=1)
    assert look.now.pose == 2, "what has no time is looked at"


def a_button(*, disabled: bool) -> SimpleNamespace:
    impl = SimpleNamespace(uuid="button")
    return SimpleNamespace(disabled=disabled, hint="Takes a scan.", _impl=impl)


def test_a_control_says_why_it_cannot_be_used(bench, visitor_of):
    button = a_button(disabled=False)
    viewer = visitor_of(VIC)
    viewer.admit(button, bench.state, TakeScan)
    assert (button.disabled, button.hint) == (True, "A scan is for operators; you are a viewer")
    operator = visitor_of(BOB)
    button = a_button(disabled=True)
    operator.admit(button, bench.state, TakeScan)
    assert (button.disabled, button.hint) == (False, "Takes a scan.")
    operator.admit(button, bench.state, MakePlan)
    assert (button.disabled, button.hint) == (
        True,
        "Planning is not possible now: take a scan first",
    )
    state = bench.do(TakeControl(), "Ada")
    operator.admit(button, state, TakeScan)
    assert button.hint == "Ada is in control; ask for control first"
    operator.admit(button, bench.do(TakeControl(), "Bob"), TakeScan, otherwise="no bin")
    assert (button.disabled, button.hint) == (True, "No bin")


def test_what_a_button_says_stands_in_the_style_sheet_as_plain_text(bench, visitor):
    evil = 'no "plan"</style><script>alert(1)</script>\\'
    button = visitor.gui.add_button("Plan", hint="Makes one.")
    visitor.explain(button, "")
    visitor.show_button_texts()
    told = visitor._style.content
    assert f'[id="{button._impl.uuid}"]' in told and '--wb-told:"Makes one."' in told
    visitor.explain(button, evil)
    visitor.show_button_texts()
    told = visitor._style.content
    assert told.count("<") == 2 and "script>" not in told.replace("</style>", "")
    assert told.count('"') == 6 and "Makes one" not in told


def test_buttons_that_nothing_is_explained_of_say_what_they_were_made_with(visitor):
    visitor.gui.add_button("Measure", hint="Two clicks.")
    visitor.gui.add_button("Play")
    visitor.show_button_texts()
    assert visitor._style.content.count("--wb-told") == 1
    assert '--wb-told:"Two clicks."' in visitor._style.content


def test_what_cannot_be_ended_keeps_nothing_else_going(visitor_of, caplog):
    visitor, ended = visitor_of(BOB), []
    visitor.on_end(lambda: ended.append("first"))
    visitor.on_end(lambda: 1 / 0)
    visitor.on_end(lambda: ended.append("last"))
    visitor.on_end(lambda: ended.append("in scene"), in_scene=True)
    visitor.end(is_gone=True)
    assert ended == ["first", "last"]
    assert "could not be ended" in caplog.text

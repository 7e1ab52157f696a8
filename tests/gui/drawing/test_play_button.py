"""The button that plays the plan, and how far somebody has watched it."""

from dataclasses import replace

import pytest

from workbench.app.core.people import NOBODY
from workbench.gui.drawing.play_button import PlayButton, watched_message
from workbench.gui.shared.look import Look
from workbench.words.words import IN_ENGLISH


@pytest.fixture
def button(visitor):
    return PlayButton(visitor)


def test_it_plays_and_pauses_for_the_browser_that_pressed_it(button, visitor, states, view_of):
    button.show(None, view_of(states.planned))
    assert button.button.label == "Play" and not button.button.disabled
    visitor.look._may = lambda fields: True
    button.press()
    look = visitor.look.now
    assert look.is_playing and look.browser == visitor.number
    button.show(view_of(states.planned), view_of(states.planned, look))
    assert button.button.label == "Pause"
    button.press()
    assert not visitor.look.now.is_playing


def test_without_a_plan_and_while_one_is_sent_nothing_is_played(button, states, view_of):
    button.show(None, view_of(states.localized))
    assert button.button.disabled and button.button.hint == "Make a plan first"
    button.show(None, view_of(states.sending))
    assert button.button.disabled and "follows the robot" in button.button.hint


def test_how_far_the_plan_was_watched_is_told_where_it_is_asked_for(states, view_of):
    planned = view_of(states.planned)
    assert IN_ENGLISH.render(watched_message(planned, "Ada")) == "Not played yet."
    seconds = planned.plan_seconds
    playing = view_of(states.planned, Look(time=2.04, is_playing=True, follows=False))
    assert IN_ENGLISH.render(watched_message(playing, "Ada")) == f"2.0 of {seconds:.1f} s"
    partly = replace(planned, unseen=((0.0, 2.6),))
    assert IN_ENGLISH.render(watched_message(partly, "Ada")) == "Not watched yet: 0.0 s to 2.6 s"
    whole = replace(planned, unseen=((0.0, seconds),))
    assert IN_ENGLISH.render(watched_message(whole, "Ada")) == "Not played yet."
    for name in ("Ada", NOBODY):
        seen = view_of(replace(states.planned, watched=(name,)))
        assert IN_ENGLISH.render(watched_message(seen, "Ada")) == "Played to its end."
        assert IN_ENGLISH.render(watched_message(replace(seen, state=states.idle), "Ada")) == ""

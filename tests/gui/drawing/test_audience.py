"""What one browser has seen of a plan: only what it has confirmed, in one stretch or in several."""

from types import SimpleNamespace

import pytest
from waiting import wait_until

from workbench.gui.drawing.audience import Audience, join_spans, without

END = 3.0


@pytest.fixture
def audience():
    """In a browser that draws at once what it is asked for."""
    audience = Audience(SimpleNamespace(get_render=lambda height, width: None))
    yield audience
    audience.close()


def played(audience, begin, end):
    """Play a stretch as the renderer does: never further than what was seen allows."""
    at = audience.begin(begin)
    while at < end:
        at = min(end, audience.limit)
        audience.note_drawn(at)
        wait_until(lambda at=at: audience._seen == at, "the browser to draw")
    audience.stop()


def test_what_was_skipped_is_missing_until_it_was_played(audience):
    assert audience.unseen(END) == ((0.0, END),)
    played(audience, 2.0, END)
    assert audience.unseen(END) == ((0.0, 2.0),)
    played(audience, 0.0, 1.5)
    assert audience.unseen(END) == ((1.5, 2.0),)
    played(audience, 1.2, 2.5)
    assert audience.unseen(END) == ()


def test_what_was_not_confirmed_before_a_stretch_ended_was_not_seen(audience):
    played(audience, 0.0, 1.0)
    audience.begin(2.5)
    audience.stop()
    audience.note_drawn(END)
    assert audience.unseen(END) == ((1.0, END),)


def test_a_stretch_that_begins_a_little_behind_what_was_seen_begins_there(audience):
    played(audience, 0.0, 1.0)
    assert audience.begin(1.4) == 1.0
    assert audience.begin(2.5) == 2.5


@pytest.mark.parametrize(
    ("spans", "expected"),
    [
        (((0.0, 0.0), (2.0, 3.0)), ((0.0, 0.0), (2.0, 3.0))),
        (((2.0, 3.0), (0.0, 2.0)), ((0.0, 3.0),)),
        (((0.0, 3.0), (1.0, 2.0)), ((0.0, 3.0),)),
    ],
)
def test_stretches_that_meet_are_one(spans, expected):
    assert join_spans(*spans) == expected


def test_what_was_drawn_without_the_hands_is_missing_until_it_was_played_with_them(audience):
    at = audience.begin(0.0)
    for time in (0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, END):
        if 0.8 < time < 2.0:
            audience.out(at, time)
        at = time
        audience.note_drawn(time)
        wait_until(lambda time=time: audience._seen == time, "the browser to draw")
    audience.stop()
    assert audience.unseen(END) == audience.hidden(END) == ((0.8, 1.6),)
    played(audience, 0.8, 1.0)
    assert audience.unseen(END) == audience.hidden(END) == ((1.0, 1.6),)
    played(audience, 1.0, 1.6)
    assert audience.unseen(END) == audience.hidden(END) == ()


@pytest.mark.parametrize(
    ("outs", "expected"),
    [
        ((), ((0.0, 3.0),)),
        (((1.0, 2.0),), ((0.0, 1.0), (2.0, 3.0))),
        (((0.0, 1.0), (2.5, 4.0)), ((1.0, 2.5),)),
        (((0.0, 3.0),), ()),
        (((3.5, 4.0),), ((0.0, 3.0),)),
    ],
)
def test_what_is_left_of_a_stretch(outs, expected):
    assert without((0.0, 3.0), outs) == expected

"""What one browser has seen of a plan: only what it has confirmed, in one stretch or in several."""

from types import SimpleNamespace

import pytest
from waiting import wait_until

from workbench.gui.drawing.audience import Audience, joined

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
        audience.drawn(at)
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
    audience.drawn(END)
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
    assert joined(*spans) == expected

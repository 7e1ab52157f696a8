"""A value that is dragged is asked for once, when the hand rests."""

import threading

import pytest
from waiting import PATIENCE

from workbench.gui.scene.slider_drag import SliderDrag

NEVER = 1e4


class Hand:
    """Drags, and counts what is asked for."""

    def __init__(self):
        self.asked, self.has_asked = 0, threading.Event()

    def ask(self):
        self.asked += 1
        self.has_asked.set()


@pytest.fixture
def hand():
    return Hand()


def test_many_values_are_one_question_after_the_last(hand):
    others = set(threading.enumerate())
    drag = SliderDrag(hand.ask, rest=NEVER)
    for _ in range(50):
        drag.note_move()
    waiting = [
        thread
        for thread in threading.enumerate()
        if isinstance(thread, threading.Timer)
        and thread not in others
        and not thread.finished.is_set()
    ]
    assert len(waiting) == 1
    drag.finish()
    assert hand.asked == 1


def test_a_hand_that_rests_has_chosen_each_time(hand):
    drag = SliderDrag(hand.ask, rest=0.05)
    for asked in (1, 2):
        drag.note_move()
        assert hand.has_asked.wait(PATIENCE)
        drag.finish()
        assert hand.asked == asked
        hand.has_asked.clear()


def test_who_cannot_wait_ends_the_drag(hand):
    drag = SliderDrag(hand.ask, rest=NEVER)
    drag.finish()
    assert hand.asked == 0
    drag.note_move()
    drag.note_move()
    drag.finish()
    drag.finish()
    assert hand.asked == 1


def test_a_drag_that_nobody_ended_asks_for_nothing(hand):
    drag = SliderDrag(hand.ask, rest=NEVER)
    drag.note_move()
    drag.drop()
    drag.finish()
    assert hand.asked == 0


def test_what_depends_on_the_value_waits_for_a_question_under_way(hand):
    asking, goes_on = threading.Event(), threading.Event()

    def ask():
        asking.set()
        goes_on.wait(PATIENCE)
        hand.ask()

    drag = SliderDrag(ask, rest=0.0)
    drag.note_move()
    assert asking.wait(PATIENCE)
    seen = []
    waiting = threading.Thread(target=lambda: (drag.finish(), seen.append(hand.asked)))
    waiting.start()
    waiting.join(0.1)
    assert waiting.is_alive()
    goes_on.set()
    waiting.join(PATIENCE)
    assert seen == [1]

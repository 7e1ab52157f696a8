"""The bar under the scene reaches the end of a plan, and plays it as fast as a person wants."""

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.app.runtime.live import Live
from workbench.gui.page.modes import ENDS, ENDS_AFTER_CYCLE, Mode
from workbench.gui.plan.transport import SPEEDS, Transport
from workbench.gui.shared.look import View


@pytest.fixture
def bar(visitor):
    return Transport(visitor)


@pytest.fixture
def drag(bar):
    """Moves the slider as a person does."""

    def to(time: float) -> None:
        target = SimpleNamespace(value=time)
        for called in bar._time._impl.update_cb:
            asyncio.run(called(SimpleNamespace(client=object(), target=target)))

    return to


@pytest.fixture
def press(bar, visitor, states, monkeypatch):
    """Presses the button beside Play in a state; returns what it is called there."""

    def go_back(state) -> str:
        monkeypatch.setattr(visitor, "bench", SimpleNamespace(state=state))
        bar.show(None, View(state, Live(), visitor.look.now, (), 0.0))
        for called in bar._start._impl.update_cb:
            called(SimpleNamespace(client=object(), target=bar._start))
        return bar._start.label

    return go_back


@pytest.mark.parametrize("beyond", [0.001, 0.0049, 0.0051, 0.0])
def test_the_end_of_a_plan_is_reached(bar, drag, visitor, states, view_of, beyond):
    whole = view_of(states.planned)
    # Whole seconds, in the middle of the plan.
    end = int(whole.plan_seconds) - 1 + beyond
    view = replace(whole, runs=tuple(replace(one, end=min(one.end, end)) for one in whole.runs))
    assert view.plan_seconds == end
    bar.show(None, view)
    assert end <= bar._time.max < end + 0.0101
    drag(bar._time.max)
    assert visitor.look.now.time == view.plan_seconds
    drag(-1.0)
    assert visitor.look.now.time == 0.0


def test_after_a_cycle_a_preview_ends_where_the_robot_is(bar, press, visitor, states):
    look = visitor.look._look
    look.change(time=6.0, follows=True)
    for state in (states.done, states.fault):
        look.change(time=1.0, by=1)
        assert press(state) in ENDS_AFTER_CYCLE
        assert visitor.look.now.follows and visitor.look.now.time == 6.0


def test_before_it_is_sent_a_preview_ends_at_the_start(bar, press, visitor, states):
    visitor.look._look.change(time=1.0, by=1)
    assert press(states.planned) in ENDS[Mode.PREVIEW]
    assert visitor.look.now.time == 0.0


def test_it_lies_there_only_while_there_is_a_plan(bar, states, view_of):
    without, planned = view_of(states.localized), view_of(states.planned)
    bar.show(None, without)
    assert not bar._folder.visible
    bar.show(without, planned)
    assert bar._folder.visible
    assert bar._bands.content.count("wb-track") == len(planned.state.cell.arms)
    assert bar._bands.content.count("wb-block") == len(planned.runs)
    bar.show(planned, without)
    assert not bar._folder.visible and not bar._bands.content


@pytest.mark.parametrize(("words", "speed"), [*SPEEDS.items(), ("16 x", 1.0)])
def test_a_speed_is_for_everybody_and_one_that_is_not_offered_is_the_real_one(
    bar, visitor, words, speed
):
    target = SimpleNamespace(value=words)
    for called in bar._speed._impl.update_cb:
        asyncio.run(called(SimpleNamespace(client=object(), target=target)))
    assert visitor.look.now.speed == speed


def test_while_a_plan_is_sent_the_mark_is_said_to_follow_the_robot(bar, states, view_of):
    bar.show(None, view_of(states.planned))
    before = bar._clock.content
    bar.show(view_of(states.planned), view_of(states.sending))
    assert "follows the robot" in bar._clock.content and "follows" not in before
    bar.show(view_of(states.sending), view_of(states.done))
    assert bar._clock.content == before

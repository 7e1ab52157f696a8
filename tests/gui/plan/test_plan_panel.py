"""The tab that plays a plan says nothing of plans before, and reaches the end of this one."""

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.app.runtime.live import Live
from workbench.gui.page.modes import ENDS, ENDS_AFTER_CYCLE, Mode
from workbench.gui.plan.panel import PlanPanel
from workbench.gui.shared.look import View


@pytest.fixture
def panel(visitor):
    return PlanPanel(visitor)


@pytest.fixture
def drag(panel):
    """Moves the slider as a person does."""

    def to(time: float) -> None:
        target = SimpleNamespace(value=time)
        for called in panel._time._impl.update_cb:
            asyncio.run(called(SimpleNamespace(client=object(), target=target)))

    return to


@pytest.fixture
def press(panel, visitor, states, monkeypatch):
    """Presses the button beside Play in a state; returns what it is called there."""

    def go_back(state) -> str:
        monkeypatch.setattr(visitor, "bench", SimpleNamespace(state=state))
        panel.show(None, View(state, Live(), visitor.look.now, (), 0.0))
        for called in panel._start._impl.update_cb:
            called(SimpleNamespace(client=object(), target=panel._start))
        return panel._start.label

    return go_back


def plots(panel) -> list[str]:
    return [html.content for pair in panel._drawn for html in pair if html.content]


def test_what_was_drawn_of_a_proof_goes_with_it(panel, states, view_of):
    proven = view_of(states.planned)
    unproven = view_of(replace(states.planned, plan=replace(proven.state.plan, seed=9), proof=None))
    panel.show(None, unproven)
    few = plots(panel)
    panel.show(unproven, proven)
    assert panel._nearest.content and len(plots(panel)) > len(few)
    panel.show(proven, unproven)
    assert plots(panel) == few
    assert panel._nearest.content == ""


@pytest.mark.parametrize("beyond", [0.001, 0.0049, 0.0051, 0.0])
def test_the_end_of_a_plan_is_reached(panel, drag, visitor, states, view_of, beyond):
    whole = view_of(states.planned)
    # Whole seconds, in the middle of the plan.
    end = int(whole.plan_seconds) - 1 + beyond
    view = replace(whole, runs=tuple(replace(one, end=min(one.end, end)) for one in whole.runs))
    assert view.plan_seconds == end
    panel.show(None, view)
    assert end <= panel._time.max < end + 0.0101
    drag(panel._time.max)
    assert visitor.look.now.time == view.plan_seconds
    drag(-1.0)
    assert visitor.look.now.time == 0.0


def test_after_a_cycle_a_preview_ends_where_the_robot_is(panel, press, visitor, states):
    look = visitor.look._look
    look.change(time=6.0, follows=True)
    for state in (states.done, states.fault):
        look.change(time=1.0, by=1)
        assert press(state) in ENDS_AFTER_CYCLE
        assert visitor.look.now.follows and visitor.look.now.time == 6.0


def test_before_it_is_sent_a_preview_ends_at_the_start(panel, press, visitor, states):
    visitor.look._look.change(time=1.0, by=1)
    assert press(states.planned) in ENDS[Mode.PREVIEW]
    assert visitor.look.now.time == 0.0

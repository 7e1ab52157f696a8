"""The threshold: what it decides for the parts found, and when it is asked for."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.picks import Avoided
from workbench.gui.cycle import threshold
from workbench.gui.cycle.panel import CyclePanel
from workbench.gui.cycle.threshold import decides_line
from workbench.gui.scene.slider_drag import SliderDrag
from workbench.model.plan import Strategy

NOW = 1_760_000_000.0


def test_it_says_which_pairs_are_apart_and_what_follows(states):
    planned = states.planned
    said = decides_line(planned, "auto", 0.2, NOW)
    assert "One arm after the other: parts 141 mm apart at most" in said
    said = decides_line(planned, "auto", 0.14, NOW)
    assert "Both arms at once, if quicker: 1 of 1 pair far apart" in said
    three = replace(planned, detections=(*planned.detections, planned.detections[0]))
    assert "2 of 3 pairs far apart" in decides_line(three, "auto", 0.14, NOW)


def test_it_says_where_it_decides_nothing(states, cell):
    assert "counts for auto alone" in decides_line(states.planned, Strategy.COORDINATED, 0.2, NOW)
    assert "one after the other" in decides_line(states.scanned, "auto", 0.2, NOW)
    motion = replace(cell.controller.motion, arms_at_once=1)
    alone = replace(cell, controller=replace(cell.controller, motion=motion))
    said = decides_line(replace(states.planned, cell=alone), "auto", 0.1, NOW)
    assert "does not move two arms at once" in said


def test_parts_that_are_avoided_are_in_no_pair(states, cell):
    part = states.planned.detections[0]
    p_bin = cell.bin.T_world_bin.inverse().act(part.T_world_part.translation)
    mark = Avoided(part.part, tuple(p_bin), NOW + 60, 3, "slipped")
    avoiding = replace(states.planned, avoided=(mark,))
    assert "pair" not in decides_line(avoiding, "auto", 0.1, NOW)
    assert "1 of 1 pair" in decides_line(avoiding, "auto", 0.1, NOW + 61)


@pytest.fixture
def panel(visitor, states, monkeypatch):
    """A plan is ready, and what is dragged is asked for when something needs it, no earlier."""
    monkeypatch.setattr(threshold, "SliderDrag", lambda ask: SliderDrag(ask, rest=1e4))
    panel = CyclePanel(visitor)
    panel.given = []
    state = replace(states.planned, planned_threshold=0.2, wanted_threshold=0.2)
    monkeypatch.setattr(type(visitor.bench), "state", property(lambda _: state))
    monkeypatch.setattr(visitor, "give", lambda command, name="": panel.given.append(command))
    return panel


def drag(panel, *millimetres):
    slider = panel._threshold._slider
    for value in millimetres:
        # As it comes from a browser: whatever that has sent.
        slider._impl.value = value
        for called in slider._impl.update_cb:
            called(SimpleNamespace(client=object(), target=slider))


def press(button):
    for called in button._impl.update_cb:
        called(SimpleNamespace(client=object(), target=button))


def test_it_is_shown_at_once_and_asked_for_before_what_depends_on_it(panel):
    drag(panel, 190, 150, 130)
    assert "1 of 1 pair" in panel._threshold._line.content
    assert panel.given == []
    press(panel._send)
    asked, sent = panel.given
    assert isinstance(asked, WantThreshold) and asked.threshold == 0.13
    assert isinstance(sent, SendPlan)


def test_a_value_dragged_to_and_fro_is_no_news(panel):
    drag(panel, 190, 150, 200)
    press(panel._send)
    assert [type(one) for one in panel.given] == [SendPlan]


def test_what_was_asked_for_at_a_rest_does_not_undo_where_the_hand_is_now(panel):
    state = replace(panel._visitor.bench.state, wanted_threshold=0.15)
    drag(panel, 130)
    panel._threshold.follow(None, state)
    assert panel._threshold.metres == 0.13
    panel._threshold.finish()
    panel._threshold.follow(None, state)
    assert panel._threshold.metres == 0.15


def test_a_plan_is_asked_for_with_what_stands_there(panel):
    drag(panel, 190, 130)
    press(panel._plan)
    (command,) = panel.given
    assert isinstance(command, MakePlan) and command.threshold == 0.13


def test_no_facts_are_shown_of_a_plan_with_another_threshold(panel):
    drag(panel, 130)
    given = []
    panel._dialog.open = lambda: given.extend(panel.given)
    press(panel._approve)
    assert [one.threshold for one in given] == [0.13]


def test_what_is_no_number_breaks_nothing(panel):
    drag(panel, "x", None, float("nan"))
    panel._strategy.value = ["auto"]
    panel._threshold.draw(panel._visitor.bench.state, NOW)
    assert not any(isinstance(one, Approve) for one in panel.given)

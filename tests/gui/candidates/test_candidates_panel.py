"""The tab of candidates: what is looked at is steered by who is in control."""

import pytest

from workbench.app.core.control import TakeControl
from workbench.app.core.people import Person, Role
from workbench.app.runtime.live import Live
from workbench.gui.candidates.panel import CandidatesPanel
from workbench.gui.shared.look import View


@pytest.fixture
def panel(visitor, states):
    panel = CandidatesPanel(visitor, lambda: None)
    panel.show(None, View(states.planned, Live(), visitor.look.now, (), 0.0))
    return panel


def test_a_candidate_that_is_clicked_is_selected_in_place_of_a_thing(panel, visitor):
    visitor.own.change(thing="bin")
    panel._choose(1)
    assert visitor.own.now.thing == ""


def test_a_row_that_is_clicked_is_looked_at_and_a_second_click_ends_that(panel, visitor):
    panel._choose(1)
    assert visitor.look.now.candidate == panel._shown[1]
    panel._choose(1)
    assert visitor.look.now.candidate is None and visitor.client.told == []


@pytest.mark.parametrize("role", [Role.VIEWER, Role.OPERATOR])
def test_who_may_not_choose_is_told_why(panel, visitor, bench, role):
    bench.do(TakeControl(), "Ada")
    visitor.person = Person("Bob", role)
    panel._choose(1)
    assert visitor.look.now.candidate is None
    (told,) = visitor.client.told
    assert "you are a viewer" in told if role is Role.VIEWER else "Ada is in control" in told


def test_how_sure_the_chosen_candidate_is_stands_below_the_table(panel, visitor, states):
    def seen(sure):
        return View(states.planned, Live(), visitor.look.now, (), 0.0, sure=sure)

    assert not panel._sure_line.visible
    panel.show(seen(""), seen("held so, the part lies <there>"))
    assert panel._sure_line.visible
    assert "Held so, the part lies &lt;there&gt;" in panel._sure_line.content
    panel.show(seen("held so"), seen(""))
    assert not panel._sure_line.visible


def test_a_part_that_was_clicked_on_in_the_scene_filters_the_table(panel, visitor, states):
    view = View(states.planned, Live(), visitor.look.now, (), 0.0)
    everything = panel._shown
    visitor.own.change(pointed=states.planned.detections[1])
    panel.show(view, view)
    parts = {states.planned.candidates[number].detection for number in panel._shown}
    assert parts == {1} and len(panel._shown) < len(everything)
    visitor.own.change(pointed=None)
    panel.show(view, view)
    assert panel._shown == everything


def test_below_the_table_stands_from_the_start_where_the_reason_comes(panel, visitor, states):
    assert "Choose a row: why it fails" in panel._pose_line.content
    assert all(
        panel._table.order < below.order
        for below in (panel._foot, panel._pose_line, panel._fix_line)
    )

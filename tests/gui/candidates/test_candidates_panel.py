"""The tab of candidates: what is looked at is steered by who is in control."""

import pytest

from workbench.app.core.commands import TakeControl
from workbench.app.core.people import Person, Role
from workbench.app.runtime.live import Live
from workbench.gui.candidates.panel import CandidatesPanel
from workbench.gui.shared.look import View
from workbench.planning.placing.budget import budget_of


@pytest.fixture
def panel(visitor, states):
    panel = CandidatesPanel(visitor, lambda: None)
    panel.show(None, View(states.planned, Live(), visitor.look.now, (), 0.0))
    return panel


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


def test_the_chosen_candidate_says_how_sure_it_is_where_its_part_comes_to_lie(
    panel, visitor, states
):
    before = View(states.planned, Live(), visitor.look.now, (), 0.0)
    assert not panel._sure_line.visible
    panel._choose(1)
    after = View(states.planned, Live(), visitor.look.now, (), 0.0)
    panel.show(before, after)
    number = visitor.look.now.candidate
    candidate = states.planned.candidates[number]
    detection = states.planned.detections[candidate.detection]
    budget = budget_of(states.planned.cell, detection, candidate)
    assert budget.largest[0] in panel._sure_line.content and panel._sure_line.visible
    assert f"{budget.shift * 1000:.1f} mm" in panel._sure_line.content
    panel._choose(1)
    panel.show(after, View(states.planned, Live(), visitor.look.now, (), 0.0))
    assert not panel._sure_line.visible

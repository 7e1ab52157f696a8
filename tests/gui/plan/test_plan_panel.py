"""The tab of a plan says nothing of plans before."""

from dataclasses import replace

import pytest

from workbench.gui.plan.panel import PlanPanel


@pytest.fixture
def panel(visitor):
    return PlanPanel(visitor, "slider")


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

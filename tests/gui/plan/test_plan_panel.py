"""The tab of a plan says nothing of plans before."""

from dataclasses import replace

import pinocchio as pin
import pytest

from workbench.gui.plan.panel import PlanPanel
from workbench.model.candidate import FoundGrip


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


def test_a_found_grip_may_be_added_while_it_is_in_the_plan(panel, states, view_of):
    planned = view_of(states.planned)
    panel.show(None, planned)
    assert not panel._add_found.visible
    plan = planned.state.plan
    grip = FoundGrip(pin.SE3.Identity(), 0.02, 0.01)
    found = replace(plan, arms=(replace(plan.arms[0], found=grip), *plan.arms[1:]))
    with_found = view_of(replace(states.planned, plan=found))
    panel.show(planned, with_found)
    assert panel._add_found.visible
    panel.show(with_found, planned)
    assert not panel._add_found.visible

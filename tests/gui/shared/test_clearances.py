"""How near a plan comes to anything, in its own two figures."""

from dataclasses import replace

from workbench.app.core.state import Outline
from workbench.gui.cycle.plan_views import plan_line
from workbench.gui.plan.views import outlines_html
from workbench.gui.shared import views
from workbench.model.messages.states import StateText
from workbench.model.motion import at_least
from workbench.proof.claims.clearance import clearance_message, linear_clearance
from workbench.proof.claims.stages import NEAR_MARGIN_LEGS


def test_a_plans_clearances_are_two_figures_with_their_names(states, view_of):
    """A single smallest clearance was contradicted by the curve of the straight ways."""
    proof = states.planned.proof
    ready = StateText.PLAN_READY(
        strategy="alternated", cycle=9.0, clearance=clearance_message(proof)
    )
    state = replace(states.planned, message=ready)
    free, straight = state.proof.clearance, linear_clearance(state.proof)
    least = min(
        bounds.min() for _, leg, bounds in state.proof.clearances if leg in NEAR_MARGIN_LEGS
    )
    assert straight == least
    free, straight = (at_least(one).removeprefix("at least ") for one in (free, straight))
    words = f"minimum clearance {free} (free motion), {straight} (linear motion)"
    shown = plan_line(state)
    assert words in shown and f"<b>{free}</b>" in shown and f"<b>{straight}</b>" in shown
    assert "minimum clearance" not in views.status_html(view_of(state))
    outlines = (Outline("a", 1.0, "left"), Outline("b", 1.0, "alternated"))
    assert "Free motion" in outlines_html(outlines, "", ("1", "2"))

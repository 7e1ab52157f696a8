"""The button that drops back what a hand holds, its facts, and its preview."""

from dataclasses import replace

import numpy as np
import pytest
from dropping import OVER_BIN

from workbench.app.core.picks import Outcome, SentFor
from workbench.app.core.state import Phase
from workbench.app.empty_hand.drop_back import plan_drop_back
from workbench.app.runtime.live import Live
from workbench.cli.picking.results import plan_words
from workbench.formats.cells.reading import read_cell
from workbench.gui.cycle.approval_views import _clear_of
from workbench.gui.cycle.approval_views import _plan as plan_facts
from workbench.gui.cycle.empty_hand import DropButton
from workbench.gui.cycle.plan_views import plan_line
from workbench.gui.shared.look import View
from workbench.gui.shared.playback import in_hands, moments, timeline
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.plan import Plan, PlanResult
from workbench.model.release import PickResult
from workbench.model.tools.held_body import HeldAmount, held_radius
from workbench.proof.claims.drop_back import fall_height


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="module")
def result(cell: Cell) -> PlanResult:
    return plan_drop_back(cell, "right", OVER_BIN, HeldAmount.ONE)


def shown(visitor, state, joints=None) -> View:
    live = replace(Live(), joints=joints or {})
    return View(state, live, visitor.look.now, (), 0.0)


def sent_plan(result: PlanResult) -> Plan:
    """A plan that takes a part, as far as buttons read it."""
    plan = result.plan
    return replace(plan, arms=(replace(plan.arms[0], detection=0, held=""),))


def at_home(cell: Cell) -> dict[str, float]:
    return cell.joint_values({arm.name: arm.home for arm in cell.arms})


def test_it_is_there_after_a_fault_and_plans_for_what_a_person_states(bench, visitor, result):
    button, cell = DropButton(visitor), bench.state.cell
    button.show(shown(visitor, bench.state))
    assert not button._group.visible
    sent = SentFor((sent_plan(result),))
    state = replace(bench.state, phase=Phase.IDLE, unscanned=sent)
    assert button.show(shown(visitor, state, at_home(cell))) is button.button
    assert "May hold a part" in button._line.content
    assert button._group.visible and button.button.disabled
    with pytest.raises(InputError, match="state first what the hand holds"):
        button.command()
    button._held.value = "two parts"
    assert not button.button.disabled and button.command().held == "two"
    assert button.show(shown(visitor, state)) is button.empty
    assert button.button.disabled
    # The next time it is stated anew.
    button.show(shown(visitor, bench.state))
    assert button.show(shown(visitor, state, at_home(cell)))
    assert button.button.disabled


def test_a_part_that_was_lost_offers_it_and_is_not_the_next_step(bench, visitor, result):
    button, cell = DropButton(visitor), bench.state.cell
    lost = Outcome(0, is_picked=False, by="ada", result=PickResult.DROPPED)
    state = replace(bench.state, unscanned=SentFor((sent_plan(result),), (lost,)), phase=Phase.IDLE)
    assert not button.show(shown(visitor, state, at_home(cell)))
    assert button._group.visible


def test_after_a_scan_the_question_what_a_hand_holds_is_still_the_next_step(bench, visitor):
    button, cell = DropButton(visitor), bench.state.cell
    state = replace(bench.state, phase=Phase.SCANNED, hands_open=("right",))
    assert button.show(shown(visitor, state, at_home(cell))) is button.button
    assert "right hand" in button._line.content


def test_facts_and_line_state_what_is_held_and_from_how_high_it_falls(bench, cell, result):
    state = replace(bench.state, plan=result.plan, proof=result.proof)
    assert "drops back what it holds (one part)" in plan_line(state)
    (_, fact) = plan_facts(cell, result.plan)[-1]
    high = fall_height(cell, HeldAmount.ONE) * 1000
    assert str(fact) == (
        f"drops back what it holds (one part) from {high:.1f} mm at most, then opens the hand"
    )
    assert f"a ball of {held_radius(cell, HeldAmount.ONE) * 1000:.1f} mm around the hand" in str(
        _clear_of(state, result.plan)
    )
    assert "drops back what it holds (one)" in plan_words(result.plan, 0.0)


def test_beside_the_bin_the_place_is_stated_and_no_height(cell, result):
    place = cell.bin.T_world_bin.translation + [0.4, 0.0, 0.2]
    beside = replace(cell, bin=replace(cell.bin, p_world_drop=tuple(place)))
    (_, fact) = plan_facts(beside, result.plan)[-1]
    x, y, z = (f"{1000 * value:.0f}" for value in place)
    assert str(fact).endswith(f"at {x}, {y}, {z} mm; its fall is not known")


def test_the_preview_shows_the_arm_and_no_part_in_its_hand(cell, result):
    runs = timeline(result.plan)
    for run in runs:
        middle = (run.start + run.end) / 2
        assert in_hands(cell, (result.plan,), runs, middle) == {}
        assert np.isfinite(moments(cell, runs, middle)["right"].q).all()

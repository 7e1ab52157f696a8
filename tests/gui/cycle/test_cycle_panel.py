"""The tab Cycle: what is to be pressed next stands there, and nothing moves to where Send was."""

from dataclasses import replace

import pytest

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import Outcome, SimulatedPile
from workbench.app.core.state import Ahead, Phase
from workbench.app.runtime.live import Live
from workbench.gui.cycle.approval_views import approval_line
from workbench.gui.cycle.panel import CyclePanel
from workbench.model.release import PartReport
from workbench.model.scan import LocalizationResult, ScaleCheck

NOW = 1_760_000_000.0


@pytest.fixture
def panel(visitor, states, monkeypatch):
    panel = CyclePanel(visitor)
    panel.state = states.idle
    monkeypatch.setattr(type(visitor.bench), "state", property(lambda _: panel.state))
    return panel


def layout(panel, view):
    """What takes room below Scan, with what can be pressed; by the order on the page."""
    panel.state = view.state
    panel.show(None, view)
    controls = [panel._scan, panel._go_on.button, panel._play.button, panel._approve]
    controls += [panel._stop, panel._send]
    return [(one.visible, one.order) for one in controls]


def test_no_button_comes_or_goes_when_a_plan_is_sent_and_when_it_has_ended(panel, states, view_of):
    approved = layout(panel, view_of(states.approved))
    assert layout(panel, view_of(states.sending)) == approved
    assert layout(panel, view_of(states.done)) == approved
    assert layout(panel, view_of(states.fault)) == approved
    assert all(is_visible for is_visible, _ in approved)


def test_going_on_stands_beside_the_scan_and_says_why_it_cannot_be_pressed(panel, states, view_of):
    button = panel._go_on.button
    assert panel._scan.order < button.order < panel._find.order
    for state, is_open in (
        (states.idle, False),
        (states.approved, False),
        (states.sending, True),
        (states.done, True),
        (states.fault, False),
    ):
        layout(panel, view_of(state))
        assert button.disabled != is_open, state.phase
        is_moving = state.phase is Phase.SENDING
        assert button.label == ("Prepare next cycle" if is_moving else "Next cycle")
        assert button.hint
    ahead = replace(states.sending, ahead=Ahead(GoOn()))
    layout(panel, view_of(ahead))
    assert button.disabled and panel._go_on._line.visible


def test_the_page_says_which_simulated_parts_stay_and_drops_new_ones_by_a_button(
    panel, states, view_of, monkeypatch
):
    button, stays, given = panel._go_on._new, panel._go_on._stays, []
    monkeypatch.setattr(panel._visitor, "give", lambda command, name="": given.append(command))
    layout(panel, view_of(states.done))
    assert not button.visible, "nobody has let parts fall"
    panel._parts.value, panel._seed.value = 6, 4
    pile = SimulatedPile(4, 6, "keyed_cylinder", states.done.cell.bin.name)
    layout(panel, view_of(replace(states.done, pile=pile)))
    assert button.visible and "shows the 4 parts left in the bin" in stays.content
    panel._go_on._on_pressed()
    assert (panel._seed.value, given[-1].scan.seed, given[-1].scan.stays) == (4, 4, True)
    panel._go_on._drop_new()
    assert (panel._seed.value, given[-1].seed) == (5, 5)
    panel._parts.value, panel._seed.value = 2, 4
    layout(panel, view_of(replace(states.done, pile=replace(pile, parts=2))))
    assert "no part is left" in stays.content
    panel._go_on._on_pressed()
    assert given[-1].scan.seed == 5


def test_play_stands_before_the_approval_that_asks_for_it(panel, states, view_of):
    layout(panel, view_of(states.planned))
    assert panel._find.order < panel._play.button.order < panel._approve.order
    assert not panel._play.button.disabled and panel._approve.disabled
    assert "Not played yet." in panel._watched_line.content


def test_a_part_of_a_wrong_size_is_corrected_by_a_button_that_names_it(panel, states, view_of):
    def show(*ratios):
        state = states.localized
        scales = tuple(ScaleCheck(name, ratio, 0.002, 4) for name, ratio in ratios)
        findings = LocalizationResult(state.detections, scales=scales)
        layout(panel, replace(view_of(state), live=Live(findings=findings)))
        return panel._correct

    assert not show(("peg", 1.001)).visible
    button = show(("peg", 1.001), ("nut", 0.93), ("bolt", 1.08))
    assert button.visible and button.label == "Correct nut"
    assert panel._wrong == ("nut", "bolt")


def test_after_a_missed_grip_plan_offers_the_rest_and_is_the_next_step(panel, states, view_of):
    layout(panel, view_of(states.done))
    assert panel._plan.label == "Plan" and panel._plan.disabled
    done = after_a_miss(states.done)
    layout(panel, view_of(done))
    assert panel._plan.label == "Plan the rest" and not panel._plan.disabled
    layout(panel, view_of(replace(done, may_have_moved=None)))
    assert panel._plan.label == "Plan" and panel._plan.disabled


def after_a_miss(done):
    """The state in which the hand of the first of two parts has closed on nothing."""
    missed, *others = done.plan.picks
    reports = (
        PartReport(missed.arm, missed.detection, False, "", True),
        *(PartReport(pick.arm, pick.detection, True) for pick in others),
    )
    spare = replace(done.plan.detections[0], score=0.8)
    plan = replace(done.plan, detections=(*done.plan.detections, spare))
    return replace(
        done,
        plan=plan,
        part_reports=reports,
        outcomes=(Outcome(missed.detection, False, ROBOT_LINK),),
        may_have_moved=(missed.detection,),
    )


def test_what_is_to_be_done_next_is_no_fault(states):
    assert "wb-bad" not in approval_line(states.planned, NOW, "play it first", is_next=True)
    waits = "an approval has to wait until the planning ends or is cancelled"
    assert "wb-bad" not in approval_line(replace(states.planned, job=object()), NOW, waits)
    assert "wb-bad" in approval_line(states.planned, NOW, "the robot has moved")


def test_an_approval_that_was_used_holds_until_no_time(states):
    assert "By Anna until " in approval_line(states.approved, NOW, "")
    for state in (states.sending, states.done, states.fault):
        text = approval_line(state, NOW + 9e9, "")
        assert "Approved by Anna" in text and "until" not in text and "run out" not in text
    late = approval_line(replace(states.approved, phase=Phase.APPROVED), NOW + 9e9, "")
    assert "run out" in late


def test_a_browser_that_comes_back_begins_with_the_parts_and_the_seed_asked_for(panel, visitor):
    panel._parts.value, panel._seed.value = 8, 5
    panel._wanted_scan()
    again = CyclePanel(visitor)
    assert (again._parts.value, again._seed.value) == (8, 5)
    again._parts.value = 0
    again._wanted_scan()
    assert visitor.look.now.scan_asked == (8, 5), "only what can be asked for"


def test_who_is_not_in_control_changes_none_of_the_inputs(panel, visitor, states, view_of):
    def inputs():
        row, ways = panel._row, panel._overrides
        fields = (panel._kind, panel._parts, panel._seed, panel._strategy, row._wanted)
        return (*fields, panel._threshold._slider, ways._planner, ways._order, ways._margin)

    layout(panel, view_of(states.localized))
    assert not any(field.disabled for field in inputs())
    layout(panel, view_of(replace(states.localized, control="Bob")))
    assert all(field.disabled for field in inputs())


def test_the_threshold_rests_where_a_cell_moves_one_arm_at_a_time(panel, states, view_of):
    alone = replace(states.idle.cell, arms=states.idle.cell.arms[:1])
    assert not alone.moves_both_arms
    layout(panel, view_of(replace(states.idle, cell=alone)))
    assert panel._threshold._slider.disabled

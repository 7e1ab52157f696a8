"""The status above the tabs, and the warning below it."""

import re
from dataclasses import replace
from html import unescape
from unicodedata import east_asian_width

import pytest

from workbench.app.core.cycle.results import with_result
from workbench.app.core.cycle.sending import placed_by_now
from workbench.app.core.picks import Outcome
from workbench.app.core.state import Job, Phase, State
from workbench.formats.cells.reading import read_cell
from workbench.gui.shared import views
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.errors import JobCancelled, WorkbenchError
from workbench.model.messages.cells import InventoryText
from workbench.model.messages.message import GROUPED, UNITS, Message
from workbench.model.messages.states import ControlText, RowStop, StateText, TaskText
from workbench.model.messages.work import CancelText
from workbench.model.plan import Proven
from workbench.model.release import PartReport, PickResult
from workbench.words.words import words_of

NOW = 1_760_000_000.0


@pytest.mark.parametrize("language", ["de", "it", "fr", "es", "zh"])
def test_the_warning_of_other_software_is_read_in_every_language(language):
    since = "session 20260101-yumi"
    state = State(read_cell("yumi"), changed=(InventoryText.CELL(),), changed_since=since)
    words = words_of(language)
    said = words.html(views.changes_html(state, words))
    assert "20260101-yumi" in said
    assert not {"nothing", "before", "changed"} & set(re.findall("[a-z]+", said))


def test_a_long_state_goes_on_below_and_can_be_read_whole(view_of):
    state = State(read_cell("yumi"), message="plan " * 30)
    text = views.status_html(view_of(state))
    assert "<small>plan plan" in text and f'title="{"Plan " + "plan " * 29}"' in text
    short = views.status_html(view_of(replace(state, message="short")))
    assert "<small>" not in short and "title" not in short
    fault = replace(state, phase=Phase.FAULT, fault="no answer " * 20)
    assert "<b>Fault:</b> no answer" in views.status_html(view_of(fault))


SAMPLES = {
    "mm": 0.0123, "s": 6.9, "count": 2, "total": 12, "number": 11, "points": "280,689",
    "person": "Anna Muster", "other": "Bert", "part": "keyed_cylinder", "plan": "e26926af7628",
}  # fmt: skip


@pytest.mark.parametrize("language", ["en", "de", "it", "fr", "es", "zh"])
def test_the_first_line_of_every_state_is_short_in_every_language(language, view_of):
    words, cell = words_of(language), read_cell("yumi")
    for text in (*StateText, *ControlText, *RowStop, *TaskText, *CancelText):
        args = {
            name: SAMPLES.get(name, 2 if how & {*UNITS, GROUPED, "|"} else "side-3-3 " * 3)
            for name, how in text.places.items()
        }
        state = State(cell, message=Message(text, args))
        found = re.search("<span>(.*?)(<small>|</span>)", views.status_html(view_of(state), words))
        line = unescape(re.sub("<[^>]*>", "", found[1]))
        width = sum(2 if east_asian_width(letter) in "WF" else 1 for letter in line)
        assert 0 < width <= 60, (text.id, line)


def ended(state, name, brought):
    """The state in which a task has brought something, or an error."""
    return with_result(replace(state, job=Job(7, name)), 7, brought, NOW)


def test_what_has_failed_is_told_in_the_colour_of_a_fault(states, view_of, result):
    broken = WorkbenchError("the scanner does not answer")
    refused = replace(result, plan=None, proof=None, verdict=Verdict(Reason.NO_PATH, Stage.ROUTE))
    unproven = replace(result, proof=None)
    for state in (
        ended(states.scanned, "import", broken),
        ended(states.done, "scan", broken),
        ended(states.scanned, "localize", ()),
        ended(states.localized, "plan", refused),
        ended(states.localized, "plan", unproven),
    ):
        assert "wb-status-fault" in views.status_html(view_of(state)), state.message
    for state in (
        ended(states.scanned, "localize", states.localized.detections),
        ended(states.localized, "plan", result),
        ended(states.scanned, "localize", JobCancelled("enough")),
        states.idle,
    ):
        assert "wb-status-plain" in views.status_html(view_of(state)), state.message


def test_a_fault_names_the_hands_that_may_hold_a_part_and_which(states, view_of):
    text = views.status_html(view_of(states.fault))
    picks = sorted(states.fault.plan.picks, key=lambda pick: pick.arm)
    hands = ", ".join(f"{pick.arm} hand (part-{pick.detection + 1})" for pick in picks)
    assert len(picks) == 2 and f"May hold a part: {hands}." in text
    reported = replace(
        states.fault,
        outcomes=(
            Outcome(picks[0].detection, is_picked=False, by="ada", result=PickResult.DROPPED),
        ),
    )
    text = views.status_html(view_of(reported))
    assert f"May hold a part: {picks[1].arm} hand (part-{picks[1].detection + 1})." in text


def test_an_older_stop_leaves_a_hand_without_a_number(states, view_of):
    state = replace(states.idle, phase=Phase.FAULT, fault="no answer", hands_open=("left",))
    assert "May hold a part: left hand." in views.status_html(view_of(state))


def test_parts_are_counted_while_the_robot_puts_them_down(states, view_of):
    plan, counts = states.sending.plan, []
    for step in range(1, len(plan.sequence) + 1):
        receipt = replace(states.sending.receipts[-1], step=step)
        state = replace(states.sending, receipts=(receipt,))
        counts.append(int(re.search(r"(\d) of 2 placed", views.status_html(view_of(state)))[1]))
    assert counts == sorted(counts) and (counts[0], counts[-1]) == (0, 2)
    assert "0 of 2 placed" in views.status_html(view_of(states.sending)), "it reports no step"
    ended = replace(states.done, receipts=state.receipts)
    assert placed_by_now(ended) == counts[-1], "after its end the steps count no second time"


def test_a_pick_that_the_gripper_reports_as_failed_is_not_counted_as_placed(states, view_of):
    plan, last = states.sending.plan, states.sending.receipts[-1]
    pick = plan.picks[0]
    for is_picked, count in ((False, 1), (True, 2), (None, 2)):
        report = PartReport(pick.arm, pick.detection, is_picked=is_picked)
        receipts = (replace(last, part=report), replace(last, step=len(plan.sequence)))
        state = replace(states.sending, receipts=receipts)
        assert f"{count} of 2 placed" in views.status_html(view_of(state))


def test_parts_that_a_plan_puts_onto_a_station_are_not_counted_as_placed(states, view_of):
    sending = states.sending
    arms = tuple(replace(arm, station="post") for arm in sending.plan.arms)
    over = replace(sending.plan, arms=arms)
    receipt = replace(sending.receipts[-1], step=len(over.sequence))
    state = replace(sending, plan=over, receipts=(receipt,))
    assert placed_by_now(state) == 0
    row = replace(state, row=(Proven(sending.plan, sending.proof),))
    assert "0 of 2 placed" in views.status_html(view_of(row)), "the next plan places them"

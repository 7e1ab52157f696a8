"""The status above the tabs, and the warning below it."""

import re
from dataclasses import replace
from html import unescape
from unicodedata import east_asian_width

import pytest

from workbench.app.core.cycle.results import with_result
from workbench.app.core.state import Job, Phase, State
from workbench.formats.cells.reading import read_cell
from workbench.gui.shared import views
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.errors import JobCancelled, WorkbenchError
from workbench.model.messages.cells import InventoryText
from workbench.model.messages.message import GROUPED, UNITS, Message
from workbench.model.messages.states import ControlText, RowStop, StateText, TaskText
from workbench.model.messages.work import CancelText
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

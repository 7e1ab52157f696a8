"""The status above the tabs, and the warning below it."""

import re
from dataclasses import replace

import pytest

from workbench.app.core.cycle.results import with_result
from workbench.app.core.state import Job, Phase, State
from workbench.formats.cells.reading import read_cell
from workbench.gui.shared import views
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.errors import JobCancelled, WorkbenchError
from workbench.model.messages.cells import InventoryText
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


def test_a_long_status_is_set_smaller_and_a_fault_is_not(view_of):
    state = State(read_cell("yumi"), message="plan " * 30)
    assert "wb-long" in views.status_html(view_of(state))
    assert "wb-long" not in views.status_html(view_of(replace(state, message="short")))
    failed = replace(state, phase=Phase.FAULT, fault="no answer " * 20)
    assert "wb-long" not in views.status_html(view_of(failed))


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

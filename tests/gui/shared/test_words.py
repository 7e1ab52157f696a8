"""Words of the page for what is on record otherwise: tasks, and times."""

import time
from dataclasses import replace

import pytest

from workbench.gui.shared import views
from workbench.model.messages.message import plain
from workbench.model.messages.states import StateText, task_message


@pytest.mark.parametrize(
    ("recorded", "shown"),
    [
        (
            StateText.TASK_FAILED(task=task_message("sight"), why=plain("no ball")),
            "The scan of the plate failed: no ball",
        ),
        (
            StateText.CANCELLED_BY(task=task_message("localize"), person="Ada"),
            "The search for parts was cancelled by Ada",
        ),
        (StateText.TASK_CANCELLED(task=task_message("plan")), "The planning was cancelled"),
        ("scan with 12 points", "Scan with 12 points"),
    ],
)
def test_tasks_are_told_by_the_words_that_people_have_for_them(states, view_of, recorded, shown):
    assert views.message_text(recorded) == shown
    assert shown.replace("'", "&#x27;") in views.status_html(
        view_of(replace(states.scanned, message=recorded))
    )


def test_times_are_local_and_say_in_which_zone(monkeypatch):
    monkeypatch.setenv("TZ", "CET-1CEST,M3.5.0,M10.5.0/3")
    time.tzset()
    assert views.clock(1_760_000_000.0) == "10:53:20 CEST"
    assert views.clock(1_770_000_000.0) == "03:40:00 CET"

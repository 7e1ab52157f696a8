"""The events of a recorded session, as a list in which each can be jumped to."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from workbench.app.core.state import Phase, State
from workbench.app.records.record import COMMANDS
from workbench.app.review.history import Moment
from workbench.gui.shared.tables import clickable
from workbench.gui.shared.views import message_text, time_of_day, zone
from workbench.gui.texts.page import PageText
from workbench.words.words import IN_ENGLISH, Words

PAGE = 50
"""Rows of the list; each has an unseen button."""

MANY = frozenset({"Sent"})
"""Kinds of which one sending has a hundred: a row stands for all that follow each other."""


@dataclass(frozen=True, slots=True)
class Event:
    """One row: it goes to the moment `number`, and stands for all from `first` on.

    `at` [s since the epoch] is when, `what` the kind of thing, `says` what came of it.
    """

    first: int
    number: int
    at: float
    actor: str
    what: str
    says: str
    is_fault: bool


def events_of(
    moments: Sequence[tuple[Moment | None, State]], words: Words = IN_ENGLISH
) -> tuple[Event, ...]:
    """The events of a session in order; messages that were sent one after the other are one."""
    found: list[Event] = []
    before = ""
    for number, (moment, state) in enumerate(moments):
        if moment is None:
            continue
        is_more = moment.kind in MANY and moment.kind == before
        first = found.pop().first if is_more else number
        what = message_text(COMMANDS[moment.kind].right.says(), words)
        is_fault = state.phase is Phase.FAULT
        says = words.render(state.fault) if is_fault else message_text(state.message, words)
        found.append(Event(first, number, moment.at, moment.actor, what, says, is_fault))
        before = moment.kind
    return tuple(found)


def place_of(events: Sequence[Event], number: int) -> int:
    """Which event a moment belongs to."""
    place = next((k for k, event in enumerate(events) if number <= event.number), len(events) - 1)
    return max(place, 0)


def events_html(
    events: Sequence[Event], page: int, buttons: Sequence[str], words: Words = IN_ENGLISH
) -> str:
    """One page of the list.

    Args:
        events: all of them.
        page: which one.
        buttons: unseen ones, by place on the page.
        words: of who reads it.
    """
    rows = "".join(
        _row(event, buttons[place])
        for place, event in enumerate(events[page * PAGE : (page + 1) * PAGE])
    )
    head = words.render(PageText.AT_ZONE(zone=zone(events[0].at))) if events else "At"
    return (
        f'<div class="wb-rows"><table class="wb-table wb-events"><thead><tr><th>{escape(head)}</th>'
        f"<th>Who</th><th>What</th></tr></thead><tbody>{rows}</tbody></table></div>"
    )


def _row(event: Event, button: str) -> str:
    count = event.number - event.first + 1
    what = f"{event.what} ({count})" if count > 1 else event.what
    kind = "wb-bad" if event.is_fault else "wb-pair"
    return (
        f'<tr title="{escape(event.says)}" {clickable(button)}>'
        f'<td>{time_of_day(event.at)}</td><td translate="no">{escape(event.actor)}</td>'
        f'<td>{escape(what)}<div class="{kind}">{escape(event.says)}</div></td></tr>'
    )

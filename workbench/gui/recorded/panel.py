"""The tab of a recorded session: what happened, and which moment of it is viewed."""

import viser

from workbench.app.review.history import History
from workbench.gui.recorded.views import PAGE, events_html, events_of, place_of
from workbench.gui.shared.look import View
from workbench.gui.shared.tables import chosen_html
from workbench.gui.shared.views import clock, line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.page import PageText
from workbench.model.messages.message import as_message


class RecordedPanel:
    """A slider over the entries, what happened there, and a list of the events to jump to.

    Concurrency: clicks and drags choose a moment; the renderer's thread draws it.
    """

    def __init__(self, visitor: Visitor, history: History):
        """Add the controls."""
        self._history = history
        self._events = events_of(history.moments, visitor.words)
        gui, self._visitor = visitor.gui, visitor
        self._entry = gui.add_slider(
            "Entry",
            min=0,
            max=max(history.count - 1, 1),
            step=1,
            initial_value=history.number,
            hint="Drag through what was recorded; all but the statistics is shown as it was then.",
        )
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        back = gui.add_button("Event before", icon=viser.Icon.CHEVRON_LEFT, color="gray")
        on = gui.add_button("Next event", icon=viser.Icon.CHEVRON_RIGHT, color="gray")
        self._facts = gui.add_html("")
        self._list = gui.add_html("")
        self._mark = gui.add_html("")
        self._page = -1
        self._rows = visitor.rows(PAGE, self._jump)
        back.on_click(lambda _: self._step(-1))
        on.on_click(lambda _: self._step(1))
        visitor.by_hand(self._entry, lambda number: history.go(int(number)))

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        if old is not None and old.state is new.state:
            return
        number, moment = self._history.number, self._history.entry
        total = self._history.count
        entry = PageText.ENTRY(number=number + 1, total=total)
        if moment is not None:
            entry = PageText.ENTRY_AT(
                number=number + 1,
                total=total,
                at=clock(moment.at),
                person=moment.actor,
                message=as_message(new.state.message),
            )
        self._facts.content = line(self._visitor.words.render(entry))
        page, place = divmod(place_of(self._events, number), PAGE)
        self._mark.content = chosen_html(place if number else None)
        if page != self._page:
            self._list.content, self._page = (
                events_html(self._events, page, self._rows, self._visitor.words),
                page,
            )
        if self._entry.value != number:
            self._entry.value = number

    def _jump(self, place: int) -> None:
        at = self._page * PAGE + place
        if at < len(self._events):
            self._history.go(self._events[at].number)

    def _step(self, by: int) -> None:
        """To the end of the event before, or of the next one."""
        number, ends = self._history.number, [event.number for event in self._events]
        if by > 0:
            self._history.go(min((end for end in ends if end > number), default=number))
        else:
            self._history.go(max((end for end in ends if end < number), default=0))

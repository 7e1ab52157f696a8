"""The tab of a recorded session: which moment is looked at."""

from typing import Any

import viser

from workbench.app.review.history import History
from workbench.gui.shared.look import View
from workbench.gui.shared.views import clock, table_html
from workbench.gui.shared.visitor import Visitor


class RecordedPanel:
    """A slider over the entries, and what happened there.

    Concurrency: clicks and drags choose a moment; the renderer's thread draws it.
    """

    def __init__(self, visitor: Visitor, history: History):
        """Add the controls."""
        self._history = history
        gui = visitor.gui
        self._entry = gui.add_slider(
            "Entry",
            min=0,
            max=max(history.count - 1, 1),
            step=1,
            initial_value=history.number,
            hint="Drag through what was recorded; everything shown is as it was then.",
        )
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        back = gui.add_button("Back", icon=viser.Icon.CHEVRON_LEFT, color="gray")
        on = gui.add_button("On", icon=viser.Icon.CHEVRON_RIGHT, color="gray")
        self._facts = gui.add_html("")
        back.on_click(lambda _: history.go(history.number - 1))
        on.on_click(lambda _: history.go(history.number + 1))

        @self._entry.on_update
        async def _(event: Any) -> None:
            # The renderer sets the slider too; only a person's hand comes with a browser.
            if event.client is not None:
                history.go(int(event.target.value))

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        if old is not None and old.state is new.state:
            return
        moment = self._history.entry
        rows = [("Of", f"{self._history.number + 1} of {self._history.count}")]
        if moment is not None:
            rows += [("At", clock(moment.at)), ("Who", moment.actor), ("What", moment.kind)]
        rows.append(("Then", new.state.message))
        self._facts.content = table_html(rows)
        if self._entry.value != self._history.number:
            self._entry.value = self._history.number

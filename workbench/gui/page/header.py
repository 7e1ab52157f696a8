"""What stands above the tabs: the steps, what goes on, what ends it, and who is in control."""

import viser

from workbench.app.core.commands import AcknowledgeFault, CancelJob
from workbench.app.core.state import Phase
from workbench.gui.page.control import ControlStrip
from workbench.gui.page.theme import Theme
from workbench.gui.scene.surroundings import paint_background
from workbench.gui.shared.look import View
from workbench.gui.shared.views import status_html, strip_html
from workbench.gui.shared.visitor import Visitor


class Header:
    """Steps, status, progress, control; Cancel while a task runs, Acknowledge after a fault."""

    def __init__(self, visitor: Visitor, theme: Theme, style: str):
        """Add the controls.

        Args:
            visitor: whose browser.
            theme: of the page, which this browser may turn dark.
            style: style sheet of the whole page.
        """
        self._visitor, gui = visitor, visitor.gui
        gui.add_html(f'<style class="wb-style">{style}</style>')
        gui.add_html('<div class="wb-head"></div>')
        self._strip = gui.add_html("")
        self._status = gui.add_html("")
        self._cancel = gui.add_button("Cancel task", icon=viser.Icon.X, color="gray")
        self._acknowledge = gui.add_button(
            "Acknowledge", icon=viser.Icon.CHECK, color="red", visible=False
        )
        self._progress = gui.add_progress_bar(0.0)
        self._theme, self._gui = theme, gui
        self._control = ControlStrip(visitor)
        visitor.on_press(self._cancel, CancelJob)
        visitor.on_key("L", "Dark or light page", self._turn)
        visitor.on_press(self._acknowledge, AcknowledgeFault)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state, live = new.state, new.live
        self._control.show(old, new)
        if old is None or old.state is not state:
            self._strip.content = strip_html(state)
            self._progress.animated = state.job is not None or state.phase is Phase.SENDING
            # One place for both, so that nothing below moves.
            self._cancel.visible = state.phase is not Phase.FAULT
            self._visitor.admit(self._cancel, state, CancelJob)
            self._visitor.admit(self._acknowledge, state, AcknowledgeFault)
            self._acknowledge.visible = state.phase is Phase.FAULT
        self._status.content = status_html(new)
        if state.job is not None:
            self._progress.value = round(100 * live.told_of(state.job.number)[0], 1)
        elif live.getting_ready is not None:
            self._progress.value = round(100 * live.getting_ready.done, 1)
        elif state.receipts:
            self._progress.value = round(100 * state.receipts[-1].done / state.receipts[-1].total)
        else:
            self._progress.value = 0.0

    def _turn(self) -> None:
        visitor = self._visitor
        visitor.is_dark = not visitor.is_dark
        self._theme.apply(self._gui, is_dark=visitor.is_dark)
        paint_background(visitor.client.scene, is_dark=visitor.is_dark)

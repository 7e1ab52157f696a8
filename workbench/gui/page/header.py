"""What stands above the tabs: the steps, what goes on, what ends it, and who is in control."""

import viser

from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.session import AcknowledgeChanges
from workbench.app.core.state import Phase, State
from workbench.gui.cycle.sending_views import share_sent
from workbench.gui.page.control import ControlStrip
from workbench.gui.page.looks import Looks
from workbench.gui.page.modes import mode_html
from workbench.gui.page.theme import Theme
from workbench.gui.plan.transport import Transport
from workbench.gui.scene.surroundings import add_floor, paint_background
from workbench.gui.shared.look import View
from workbench.gui.shared.tables import css_text
from workbench.gui.shared.views import changes_html, status_html, strip_html
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.page import PageText
from workbench.words.words import Words

FRAMED = (
    ".wb-mode b{display:none}"
    "div:has(> button .icon-tabler-hand-stop){display:none}"
    "div:has(> button .icon-tabler-send){grid-column:3}"
    "@font-face{font-family:Inter;font-weight:100 900;src:url(/static/inter.woff2)}"
)
"""The page around the scene shows the mode and has Stop, and its server has the font."""


class Header:
    """Steps, status, progress, control; Cancel while a task runs, Acknowledge after a fault.

    What has changed since the start before stands below until an engineer acknowledges it.
    """

    def __init__(self, visitor: Visitor, theme: Theme, style: str):
        """Add the controls.

        Args:
            visitor: whose browser.
            theme: of the page, which this browser may turn dark.
            style: style sheet of the whole page.
        """
        self._visitor, gui = visitor, visitor.gui
        # viser's own title bar, where there is no page around the scene.
        top = FRAMED if theme.is_framed else ":root{--wb-mode-top:3.75rem}"
        rail = rail_css(visitor.words)
        gui.add_html(f'<style class="wb-style">{style}{top}{rail}</style>')
        gui.add_html('<div class="wb-head"></div>')
        self._mode = gui.add_html("")
        self._strip = gui.add_html("")
        self._status = gui.add_html("")
        self._cancel = gui.add_button("Cancel task", icon=viser.Icon.X, color="gray")
        self._acknowledge = gui.add_button(
            "Acknowledge", icon=viser.Icon.CHECK, color="red", visible=False
        )
        self._changes = gui.add_html("", visible=False)
        self._seen = gui.add_button(
            "Changes seen",
            icon=viser.Icon.CHECK,
            color="red",
            visible=False,
            hint="Acknowledge what has changed",
        )
        self._progress = gui.add_progress_bar(0.0)
        self._theme, self._gui = theme, gui
        if visitor.is_dark:
            theme.apply(gui, is_dark=True)
        self._control = ControlStrip(visitor)
        self._looks = Looks(visitor)
        self.transport = Transport(visitor)
        """Lies over the foot of the scene."""
        self._ends_comparing = visitor.unseen(lambda: visitor.look.change(search=None))
        visitor.hide([self._ends_comparing])
        visitor.on_press(self._cancel, CancelJob)
        visitor.on_key("L", "Dark or light page", self._turn)
        visitor.on_press(self._acknowledge, AcknowledgeFault)
        self._shown = ""
        visitor.on_press(self._seen, lambda: AcknowledgeChanges(self._shown))

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state, live = new.state, new.live
        is_comparing = new.look.searcher == self._visitor.number
        mode = mode_html(new, self._ends_comparing if is_comparing else "", self._visitor.words)
        if mode != self._mode.content:
            self._mode.content = mode
        self._control.show(old, new)
        self._looks.show(new)
        self.transport.show(old, new)
        if old is None or old.state is not state:
            self._strip.content = strip_html(state)
            is_busy = state.job is not None or state.phase is Phase.SENDING
            self._progress.animated = is_busy and not new.is_recorded
            # One place for both, so that nothing below moves.
            self._cancel.visible = state.phase is not Phase.FAULT
            self._visitor.admit(self._cancel, state, CancelJob)
            self._visitor.admit(self._acknowledge, state, AcknowledgeFault)
            self._acknowledge.visible = state.phase is Phase.FAULT
            self._show_changes(state)
        if self._visitor.is_dark and (old is None or old.state.cell is not state.cell):
            # With the cell the floor was laid anew for all, as on a light page.
            self._lay_out()
        self._status.content = status_html(new, self._visitor.words)
        if state.job is not None and state.phase is not Phase.SENDING:
            self._progress.value = round(100 * live.progress_of(state.job.number)[0], 1)
        elif live.getting_ready is not None:
            self._progress.value = round(100 * live.getting_ready.done, 1)
        else:
            self._progress.value = round(100 * share_sent(state), 1)
        # What has ended early is not on its way any more.
        self._progress.color = "gray" if state.phase is Phase.FAULT else None

    def _show_changes(self, state: State) -> None:
        self._shown = "" if state.ran is None else state.ran.digest
        self._changes.visible = self._seen.visible = bool(state.changed)
        self._changes.content = changes_html(state, self._visitor.words)
        self._visitor.admit(self._seen, state, AcknowledgeChanges)

    def _turn(self) -> None:
        visitor = self._visitor
        visitor.is_dark = not visitor.is_dark
        self._theme.apply(self._gui, is_dark=visitor.is_dark)
        self._lay_out()

    def _lay_out(self) -> None:
        """Sky and floor in this browser, over those that all have."""
        visitor = self._visitor
        paint_background(visitor.client.scene, is_dark=visitor.is_dark)
        add_floor(visitor.client.scene, visitor.cell, is_dark=visitor.is_dark)


def rail_css(words: Words) -> str:
    """What the style sheet writes over the tabs for every cycle, and over those to set up."""
    run, set_up = (css_text(words.render(t())) for t in (PageText.RUN_TABS, PageText.SET_UP_TABS))
    return f':root{{--wb-run:"{run}";--wb-set-up:"{set_up}"}}'

"""The strip that says who is in control, and passes control on."""

import threading
import time
from collections.abc import Callable

import viser

from workbench.app.core.command import Command
from workbench.app.core.control import (
    AskForControl,
    DenyControl,
    GiveControl,
    ReleaseControl,
    TakeControl,
)
from workbench.app.core.people import Role
from workbench.app.core.state import Phase, State
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.page import PageText
from workbench.model.errors import InputError
from workbench.model.messages.message import Message

STYLE = "div:has(> div > .wb-head) > div:has(> .wb-control) { grid-column: span 1; }"
"""One line beside one button, as the status above it has it."""

DOUBLE_CLICK = 0.7
"""[s] A press this soon after one of the same button is the second click of a double click."""

SETTLING = 1.5
"""[s] After a change of control presses are ignored: another button may lie under the pointer."""


class TakeOverDialog:
    """Asks before control is taken over from a person, who cannot act from then on.

    Concurrency: `open` from viser's threads, `show` from the renderer's.
    """

    def __init__(self, visitor: Visitor):
        """Nothing is shown until `open`."""
        self._visitor, self._holder = visitor, ""
        self._lock = threading.Lock()
        self._close: Callable[[], None] | None = None

    def open(self) -> None:
        """Ask about the person who is in control now; where nobody is, take control at once."""
        visitor, state = self._visitor, self._visitor.bench.state
        holder = state.control
        if not holder:
            visitor.ask(TakeControl)
            return
        words, gui = visitor.words, visitor.gui
        with self._lock:
            if self._close is not None:
                return
            self._holder = holder
            with visitor.client.atomic():
                title = words.render(PageText.TAKE_OVER_TITLE(person=holder))
                modal = gui.add_modal(title)
                self._close = modal.close
                with modal:
                    gui.add_html(line(words.render(PageText.TAKE_OVER_LOSS(person=holder))))
                    if state.phase is Phase.SENDING:
                        gui.add_html(line(words.render(PageText.TAKE_OVER_MOVES()), kind="warn"))
                    gui.add_html('<div class="wb-buttons wb-two"></div>')
                    back = gui.add_button("Back", color="gray")
                    label = words.render(PageText.TAKE_OVER(person=holder))
                    take = gui.add_button(label, icon=viser.Icon.HAND_GRAB)
        back.on_click(lambda _: self.close())
        take.on_click(lambda _: self._take_over())

    def show(self, state: State) -> None:
        """Close when somebody else is in control than the dialog names."""
        if state.control != self._holder:
            self.close()

    def close(self) -> None:
        """Take the dialog away."""
        with self._lock:
            take_away, self._close = self._close, None
        if take_away is not None:
            take_away()

    def _take_over(self) -> None:
        if self._visitor.bench.state.control == self._holder:
            self._visitor.ask(TakeControl)
        self.close()


class ControlStrip:
    """One line and the buttons that mean something now; unseen where nobody needs control.

    Whoever is in control sees each request, and answers it by Hand over or Keep.

    Concurrency: clicks give commands; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls, unseen."""
        self._visitor, self._told = visitor, ""
        self._changed_at, self._given_to = -SETTLING, ""
        gui = visitor.gui
        gui.add_html(f'<style class="wb-style">{STYLE}</style>')
        self._line = gui.add_html("", visible=False)
        self._ask = gui.add_button("Ask for control", icon=viser.Icon.HAND_CLICK, visible=False)
        self._back = gui.add_button("Release control", color="gray", visible=False)
        self._take = gui.add_button("Take control", icon=viser.Icon.HAND_GRAB, visible=False)
        self._give = gui.add_button("Hand over", icon=viser.Icon.CHECK, visible=False)
        self._keep = gui.add_button("Keep", icon=viser.Icon.X, color="gray", visible=False)
        self._dialog = TakeOverDialog(visitor)
        self._on_single_press(self._take, self._dialog.open)
        self._on_single_press(self._ask, lambda: visitor.ask(AskForControl))
        self._on_single_press(self._back, lambda: visitor.ask(ReleaseControl))
        self._on_single_press(self._give, lambda: visitor.ask(self._handed_over))
        self._on_single_press(self._keep, lambda: visitor.ask(self._keep_control))

    def _on_single_press(
        self, button: viser.GuiButtonHandle, pressed: Callable[[], object]
    ) -> None:
        """Have a button do something once, however often it is clicked in a row.

        After the first click the same button may be about another person, and soon after a change
        of control another button lies in its place.
        """
        pressed_at = -DOUBLE_CLICK

        @button.on_click
        def _(_: object) -> None:
            nonlocal pressed_at
            before, pressed_at = pressed_at, time.monotonic()
            is_settled = pressed_at - self._changed_at >= SETTLING
            if is_settled and pressed_at - before >= DOUBLE_CLICK:
                pressed()

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state = new.state
        self._dialog.show(state)
        if self._visitor.is_recorded or (old is not None and _about(old.state) == _about(state)):
            return
        if old is not None and old.state.control != state.control:
            self._changed_at = time.monotonic()
            self._notify_loss(old.state, state)
        me = self._visitor.person
        acts = self._visitor.is_known and me.role.covers(Role.OPERATOR)
        is_mine = acts and state.control == me.name
        is_free = not state.control
        words = self._visitor.words
        held = line(words.render(control_message(state, me.name)), span=1)
        self._line.content = f'<div class="wb-control">{held}</div>'
        asks = state.asking[0] if is_mine and state.asking else ""
        # Their answers lie in the same row as the line, so that nothing below moves.
        self._line.visible = (self._visitor.is_known or not is_free) and not asks
        self._take.visible = acts and not is_mine and (is_free or me.role.covers(Role.ENGINEER))
        self._take.label = "Take control" if is_free else "Take over"
        self._ask.visible = acts and not is_mine and not is_free
        self._ask.disabled = me.name in state.asking
        self._back.visible = is_mine and not asks
        self._give.visible = self._keep.visible = bool(asks)
        self._give.label = words.render(PageText.HAND_OVER(person=asks))
        if asks and asks != self._told:
            title = words.render(PageText.ASKS(person=asks))
            self._visitor.notify(title, "Hand over or Keep, in the panel.", color="blue")
        self._told = asks

    def _notify_loss(self, old: State, new: State) -> None:
        """Notify the person whose control another person has taken over."""
        is_lost = old.control == self._visitor.person.name and new.control
        if is_lost and new.control != self._given_to:
            title = self._visitor.words.render(PageText.OTHER_IN_CONTROL(person=new.control))
            self._visitor.notify(title, "Control was taken over from you.", color="blue")
        self._given_to = ""

    def _handed_over(self) -> Command:
        self._given_to = self._first()
        return GiveControl(self._given_to)

    def _keep_control(self) -> Command:
        return DenyControl(self._first())

    def _first(self) -> str:
        """Whom the buttons are about."""
        if not self._told:
            raise InputError("nobody asks for control any more")
        return self._told


def control_message(state: State, me: str) -> Message | str:
    """Who is in control, as the person of that name reads it."""
    if not state.control:
        return "Nobody has taken control; operators and engineers may act."
    if state.control == me:
        return PageText.IN_CONTROL()
    is_asking = me in state.asking
    text = PageText.OTHER_ASKED if is_asking else PageText.OTHER_IN_CONTROL
    return text(person=state.control)


def _about(state: State) -> tuple[object, ...]:
    return state.control, state.asking

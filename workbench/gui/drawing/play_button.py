"""The button that plays the plan, wherever one is asked to watch it."""

import viser

from workbench.app.core.cycle.watching import WatchPlan, explain_unwatched
from workbench.app.core.state import Phase, State
from workbench.gui.drawing.in_view import hidden_message, span_messages
from workbench.gui.shared.look import View
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.scene import WatchText
from workbench.model.messages.message import Message


class PlayButton:
    """Plays and pauses the plan for everybody; this browser is the one that watches.

    Concurrency: clicks only change the shared look; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the button."""
        self._visitor = visitor
        self.button = visitor.gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY)
        self.button.on_click(lambda _: self.press())

    def show(self, old: View | None, new: View) -> None:
        """Bring it from `old` to `new`."""
        button, is_playing = self.button, new.look.is_playing
        if old is None or old.state is not new.state:
            self._visitor.allow(button, play_problem(self._visitor, new.state))
        if old is None or old.look.is_playing != is_playing:
            button.label = "Pause" if is_playing else "Play"
            button.icon = viser.Icon.PLAYER_PAUSE if is_playing else viser.Icon.PLAYER_PLAY

    def press(self) -> None:
        """Play, or pause, where that is possible."""
        visitor, look = self._visitor, self._visitor.look
        if not self.button.disabled:
            visitor.own.end()
            look.change(is_playing=not look.now.is_playing, by=None, browser=visitor.number)


def play_problem(visitor: Visitor, state: State) -> str:
    """Why a browser cannot play the plan; empty when it can."""
    if state.plan is None:
        return "make a plan first"
    if state.phase is Phase.SENDING:
        return "while a plan is sent, its picture follows the robot"
    return visitor.lacks(state, WatchPlan)


def watched_message(view: View, actor: str) -> Message | str | None:
    """How far somebody has watched the plan that waits for an approval; empty without one."""
    state, look = view.state, view.look
    if state.phase not in (Phase.PLANNED, Phase.APPROVED):
        return None
    if look.is_playing:
        return WatchText.TIME(time=look.time, total=view.plan_seconds)
    if not explain_unwatched(state, actor):
        return "Played to its end."
    is_begun = sum(end - begin for begin, end in view.unseen) < view.plan_seconds
    return missed_message(view) if view.unseen and is_begun else "Not played yet."


def missed_message(view: View) -> Message | None:
    """What has to be played before the plan counts as watched; None when nothing has."""
    if view.state.phase not in (Phase.PLANNED, Phase.APPROVED) or not view.unseen:
        return None
    if view.hidden:
        return hidden_message(view.hidden)
    return WatchText.NOT_WATCHED(spans=span_messages(view.unseen))

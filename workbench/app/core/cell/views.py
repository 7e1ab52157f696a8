"""Views of a scanner on an arm: chosen by name, from then on scans are taken from that one.

Where nothing can be taken after a scan from one view, the bin is scanned from its next one before
it counts as empty.  It has had its turn until something can be taken, or each view has had it.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.cell.changes import Changed, with_cell
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right
from workbench.app.core.state import State
from workbench.app.core.value_checks import check_text
from workbench.model.cell import Cell
from workbench.model.derived.by_view import view_name, views_from, with_view
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.cells import ViewChoiceText
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message


@dataclass(frozen=True, slots=True, eq=False)
class ChooseView(Command):
    """Take scans from the view of that name; what was scanned from another one is void."""

    right: ClassVar[Right] = Right(CommandText.CHOOSE_VIEW, SAFE)

    name: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("name", self.name)
        _by_view(state, self.name)

    def apply(self, state: State, entry: Entry) -> Decision:
        return choose_view(state, self.name)


def choose_view(state: State, name: str) -> Changed:
    """The state with scans from another view; the one that is chosen already voids nothing."""
    cell, message = _by_view(state, name), ViewChoiceText.CHOSEN(name=name)
    if cell is state.cell:
        return replace(state, message=message), ()
    whole = state.whole or state.cell
    after, effects = with_cell(state, cell, message)
    return replace(after, whole=None if cell.digest == whole.digest else whole), effects


def with_nothing_seen(state: State) -> State:
    """The state after nothing could be taken by a scan from the chosen view.

    Where each view of the bin had its turn before, this is the first one of another round.
    """
    views, passed = views_from(state.cell), state.views_without
    if len(views) == 1:
        return state
    if all(name in passed for name in views):
        passed = ()
    return replace(state, views_without=tuple(dict.fromkeys((*passed, views[0]))))


def next_view(state: State) -> str:
    """The view of the chosen bin that follows the chosen one and has not had its turn, or empty.

    It is empty as long as the chosen one has not had its turn either.
    """
    chosen, *others = views_from(state.cell)
    if chosen not in state.views_without:
        return ""
    return next((name for name in others if name not in state.views_without), "")


def next_view_message(state: State) -> Message | None:
    """Which view is next and why, for people; None where none is."""
    name, chosen = next_view(state), view_name(state.cell)
    return ViewChoiceText.NEXT(name=name, chosen=chosen) if name else None


def _by_view(state: State, name: str) -> Cell:
    """The cell of the state by one of its views.

    Raises:
        CommandRefused: none of that name sees the bin that is chosen.
    """
    try:
        # There an empty name stands for the view that is chosen.
        return with_view(state.cell, name or "''")
    except InputError as error:
        raise CommandRefused(error.message) from error

"""Views of a scanner on an arm: chosen by name, from then on scans are taken from that one.

Where nothing can be taken after a scan from one view, the bin is scanned from its next one before
it counts as empty.  It has had its turn until something can be taken, or each view has had it.

Where scans are merged from views, one stays until the next view has been scanned from, too.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.cell.changes import Changed, with_cell
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse_input
from workbench.app.core.state import Phase, State
from workbench.app.core.value_checks import check_text
from workbench.model.cell import Cell
from workbench.model.derived.by_view import view_name, views_from, with_view
from workbench.model.messages.cells import ViewChoiceText
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message, all_of
from workbench.model.scan import Scan


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
    earlier = _to_be_merged(state)
    after, effects = with_cell(state, cell, message)
    after = replace(after, earlier=earlier)
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
    merged = () if state.scan is None else tuple(view.name for view in state.scan.views)
    return replace(state, views_without=tuple(dict.fromkeys((*passed, *merged, views[0]))))


def next_view(state: State) -> str:
    """The view of the chosen bin that follows the chosen one and has not had its turn, or empty.

    It is empty as long as the chosen one has not had its turn either.
    """
    chosen, *others = views_from(state.cell)
    if chosen not in state.views_without:
        return ""
    return next((name for name in others if name not in state.views_without), "")


def missing_view(state: State) -> str:
    """The view from which the scan has still to be merged with another one, or empty."""
    carrier, scan = state.cell.scanner.on_arm, state.scan
    if carrier is None or not carrier.merges_views or scan is None:
        return ""
    merged = {view.name for view in scan.views}
    return next((name for name in views_from(state.cell) if name not in merged), "")


def views_message(state: State) -> Message | None:
    """Which views do not fit the others, and which is missing, for people; None for none."""
    views = () if state.scan is None else state.scan.views
    off = [
        ViewChoiceText.OFF(
            name=view.name, shift=view.shift, turn=view.turn, share=f"{view.through * 100:.1f}"
        )
        for view in views
        if view.is_off
    ]
    name = missing_view(state)
    return all_of((*off, ViewChoiceText.MISSING(name=name) if name else None))


def next_view_message(state: State) -> Message | None:
    """Which view is next and why, for people; None where none is."""
    name, chosen = next_view(state), view_name(state.cell)
    return ViewChoiceText.NEXT(name=name, chosen=chosen) if name else None


def _to_be_merged(state: State) -> Scan | None:
    """The scan that shows the bin as it still is, from views that the next one is merged with."""
    carrier = state.cell.scanner.on_arm
    if carrier is None or not carrier.merges_views:
        return None
    if state.scan is None:
        return state.earlier
    return None if state.phase in (Phase.DONE, Phase.FAULT) else state.scan


def _by_view(state: State, name: str) -> Cell:
    """The cell of the state by one of its views.

    Raises:
        CommandRefused: none of that name sees the bin that is chosen.
    """
    with refuse_input():
        # `with_view` takes an empty name for the chosen view; here it names none.
        return with_view(state.cell, name or "''")

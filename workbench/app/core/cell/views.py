"""Views of a scanner on an arm: chosen by name, from then on scans are taken from that one."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.cell.changes import with_cell
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right
from workbench.app.core.state import State
from workbench.app.core.value_checks import check_text
from workbench.model.cell import Cell
from workbench.model.derived.by_view import with_view
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.cells import ViewChoiceText
from workbench.model.messages.commands import CommandText


@dataclass(frozen=True, slots=True, eq=False)
class ChooseView(Command):
    """Take scans from the view of that name; what was scanned from another one is void."""

    right: ClassVar[Right] = Right(CommandText.CHOOSE_VIEW, SAFE)

    name: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("name", self.name)
        _by_view(state, self.name)

    def apply(self, state: State, entry: Entry) -> Decision:
        cell, message = _by_view(state, self.name), ViewChoiceText.CHOSEN(name=self.name)
        if cell is state.cell:
            return replace(state, message=message), ()
        whole = state.whole or state.cell
        after, effects = with_cell(state, cell, message)
        return replace(after, whole=None if cell.digest == whole.digest else whole), effects


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

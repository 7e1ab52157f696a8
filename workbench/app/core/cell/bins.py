"""Bins: chosen by name, from then on parts are taken from that one.

The scan stays.  Detections, plan and approval were made for another bin, and are void.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.cell.changes import with_cell
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right
from workbench.app.core.state import State
from workbench.app.core.value_checks import check_text
from workbench.model.cell import Cell
from workbench.model.derived.by_bin import with_bin
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.cells import BinChoiceText
from workbench.model.messages.commands import CommandText


@dataclass(frozen=True, slots=True, eq=False)
class ChooseBin(Command):
    """Take parts from the bin of that name."""

    right: ClassVar[Right] = Right(CommandText.CHOOSE_BIN, SAFE)

    name: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("name", self.name)
        _by_bin(state, self.name)

    def apply(self, state: State, entry: Entry) -> Decision:
        cell, message = _by_bin(state, self.name), BinChoiceText.CHOSEN(name=self.name)
        if cell is state.cell:
            return replace(state, message=message), ()
        whole = state.whole or state.cell
        after, effects = with_cell(state, cell, message)
        return replace(after, whole=None if cell.digest == whole.digest else whole), effects


def _by_bin(state: State, name: str) -> Cell:
    """The cell of the state by one of its bins.

    Raises:
        CommandRefused: there is none of that name.
    """
    try:
        return with_bin(state.cell, name)
    except InputError as error:
        raise CommandRefused(error.message) from error

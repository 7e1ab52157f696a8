"""Bins: chosen by name, from then on parts are taken from that one; which are empty, and new ones.

Scan, detections, plan and approval were made for another bin, and are void.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.cell.changes import Changed, with_cell
from workbench.app.core.cell.views import next_view
from workbench.app.core.command import (
    EVERY_PHASE,
    SAFE,
    Asked,
    Command,
    Decision,
    Entry,
    Right,
    refuse,
    refuse_input,
)
from workbench.app.core.state import Phase, ScanState, State, begin_stage, stale_by
from workbench.app.core.value_checks import check_text
from workbench.model.cell import Cell
from workbench.model.derived.by_bin import with_bin
from workbench.model.derived.by_recipe import recipe_of
from workbench.model.messages.cells import BinChoiceText
from workbench.model.messages.commands import CommandText
from workbench.model.recipes.recipe import NO_RECIPE


@dataclass(frozen=True, slots=True, eq=False)
class ChooseBin(Command):
    """Take parts from the bin of that name."""

    right: ClassVar[Right] = Right(CommandText.CHOOSE_BIN, SAFE)

    name: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("name", self.name)
        _by_bin(state, self.name)

    def apply(self, state: State, entry: Entry) -> Decision:
        return choose_bin(state, self.name)


@dataclass(frozen=True, slots=True, eq=False)
class NewBin(Command):
    """The bin of that name was refilled, or another one stands in its place.

    With a simulated scanner new parts fall into it before the next scan.
    """

    right: ClassVar[Right] = Right(
        CommandText.NEW_BIN, EVERY_PHASE, beside_job=True, without_control=True
    )

    name: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("name", self.name)
        _by_bin(state, self.name)
        is_busy = state.phase is Phase.SENDING or state.job is not None
        if is_busy and self.name == state.cell.bin.name:
            refuse(BinChoiceText.IN_USE(name=self.name))

    def apply(self, state: State, entry: Entry) -> Decision:
        message = BinChoiceText.NEW(name=self.name)
        after = replace(
            state,
            empty_bins=tuple(name for name in state.empty_bins if name != self.name),
            avoided=tuple(mark for mark in state.avoided if mark.bin != self.name),
            pile=None if state.pile is None or state.pile.bin == self.name else state.pile,
            message=message,
        )
        if self.name != state.cell.bin.name:
            return after, ()
        after = replace(after, views_without=(), earlier=None, stirs=0, may_have_moved=None)
        if state.phase in (Phase.DONE, Phase.FAULT):
            return after, ()
        # The scan shows what lay there before.
        stale = stale_by(state, message)
        return begin_stage(after, ScanState, stale=stale, message=message), ()


def choose_bin(state: State, name: str) -> Changed:
    """The state with parts taken from another bin; the one that is chosen already voids nothing."""
    cell, message = _by_bin(state, name), BinChoiceText.CHOSEN(name=name)
    if cell is state.cell:
        return replace(state, message=message), ()
    whole = state.whole or state.cell
    after, effects = with_cell(replace(state, views_without=(), stirs=0), cell, message)
    return replace(after, whole=None if cell.digest == whole.digest else whole), effects


def with_contents(state: State, *, is_empty: bool) -> State:
    """The state once a search or a planning has shown whether the chosen bin is empty.

    It is once each of its views has shown that.  Of a single bin nothing is remembered.
    """
    if not state.cell.other_bins:
        return state
    chosen, is_empty = state.cell.bin.name, is_empty and not next_view(state)
    others = tuple(name for name in state.empty_bins if name != chosen)
    return replace(state, empty_bins=(*others, chosen) if is_empty else others)


def next_bin(state: State) -> str:
    """The name of the bin after the chosen one that is not empty; empty: there is none.

    It is none in which this cycle has found nothing that the kit lacks.  A recipe that names its
    bin stays with it.
    """
    cell = state.cell
    if cell.recipe != NO_RECIPE and recipe_of(cell, cell.recipe).bin:
        return ""
    names = [box.name for box in cell.bins]
    place = names.index(cell.bin.name)
    following = (*names[place + 1 :], *names[:place])
    passed = {*state.empty_bins, *state.kit.bins_without}
    return next((name for name in following if name not in passed), "")


def bin_numbered(state: State, number: int) -> str | None:
    """The name of a bin by its number from 1 on, 0: the next one that is not empty; else None."""
    if number == 0:
        return next_bin(state) or None
    bins = state.cell.bins
    return bins[number - 1].name if 1 <= number <= len(bins) else None


def _by_bin(state: State, name: str) -> Cell:
    """The cell of the state by one of its bins.

    Raises:
        CommandRefused: there is none of that name.
    """
    with refuse_input():
        # `with_bin` takes an empty name for the chosen bin; here it names none.
        return with_bin(state.cell, name or "''")

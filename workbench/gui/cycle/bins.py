"""The bin that parts are taken from, chosen by name; the empty ones, and a button for each."""

from functools import partial
from typing import Any

import viser

from workbench.app.core.cell.bins import ChooseBin, NewBin
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.cell import Cell
from workbench.model.derived.by_bin import MOST_BINS


class BinInput:
    """A list of the cell's bins, which nobody sees where it has one.

    Concurrency: any thread.
    """

    def __init__(self, visitor: Visitor):
        """Add the list, a line and a button for each bin that is empty."""
        self._visitor = visitor
        cell = visitor.cell
        # A browser may send anything.
        self._chosen: Any = visitor.gui.add_dropdown(
            "Bin",
            _names(cell),
            initial_value=cell.bin.name,
            visible=bool(cell.other_bins),
            hint="Parts are taken from it, and nothing reaches into the others. "
            "Scan, parts found and plan are void when another one is chosen.",
        )
        self._line = visitor.gui.add_html("", visible=False)
        self._new = [
            visitor.gui.add_button(
                "·",
                icon=viser.Icon.PACKAGE,
                color="gray",
                visible=False,
                hint="It was refilled, or another one stands in its place.",
            )
            for _ in range(MOST_BINS)
        ]
        for place, button in enumerate(self._new):
            visitor.on_press(button, partial(self._wanted_new, place))

        @self._chosen.on_update
        def _(event: Any) -> None:
            # The renderer sets it, too; only a person's hand comes with a browser.
            if event.client is None:
                return
            name, now = str(self._chosen.value), visitor.bench.state.cell.bin.name
            if name != now and not visitor.ask(lambda: ChooseBin(name)):
                self._chosen.value = visitor.bench.state.cell.bin.name

    def show(self, new: View) -> None:
        """Show the bin that is chosen now, whichever way it was chosen, and the empty ones."""
        state, cell, visitor = new.state, new.state.cell, self._visitor
        if self._chosen.options != _names(cell):
            self._chosen.options = _names(cell)
        if self._chosen.value != cell.bin.name:
            self._chosen.value = cell.bin.name
        self._chosen.visible = bool(cell.other_bins)
        visitor.admit(self._chosen, state, ChooseBin)
        for button in self._new[len(cell.bins) :]:
            button.visible = False
        empty = [name for name in _names(cell) if name in state.empty_bins]
        self._line.visible = bool(empty)
        said = visitor.words.render(CyclePageText.EMPTY_BINS(bins=empty))
        self._line.content = line(said, kind="warn", span=1)
        for name, button in zip(_names(cell), self._new, strict=False):
            button.visible = name in empty
            if button.visible:
                button.label = visitor.words.render(CyclePageText.BIN_IS_NEW(name=name))
                why = visitor.refusal(state, NewBin(name), new.at, new.live.joints)
                visitor.allow(button, visitor.words.render(why))

    def _wanted_new(self, place: int) -> NewBin:
        names = _names(self._visitor.bench.state.cell)
        return NewBin(names[place] if place < len(names) else "")


def _names(cell: Cell) -> tuple[str, ...]:
    return tuple(box.name for box in cell.bins)

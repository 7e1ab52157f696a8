"""The bin that parts are taken from, chosen by name."""

from typing import Any

from workbench.app.core.cell.bins import ChooseBin
from workbench.app.core.state import State
from workbench.gui.shared.visitor import Visitor
from workbench.model.cell import Cell


class BinInput:
    """A list of the cell's bins, which nobody sees where it has one.

    Concurrency: any thread.
    """

    def __init__(self, visitor: Visitor):
        """Add the list."""
        self._visitor = visitor
        cell = visitor.cell
        # A browser may send anything.
        self._chosen: Any = visitor.gui.add_dropdown(
            "Bin",
            _names(cell),
            initial_value=cell.bin.name,
            visible=bool(cell.other_bins),
            hint="Parts are taken from it, and nothing reaches into the others. "
            "Parts found and plan are void when another one is chosen.",
        )

        @self._chosen.on_update
        def _(event: Any) -> None:
            # The renderer sets it, too; only a person's hand comes with a browser.
            if event.client is None:
                return
            name, now = str(self._chosen.value), visitor.bench.state.cell.bin.name
            if name != now and not visitor.ask(lambda: ChooseBin(name)):
                self._chosen.value = visitor.bench.state.cell.bin.name

    def show(self, new: State) -> None:
        """Show the bin that is chosen now, whichever way it was chosen."""
        cell = new.cell
        if self._chosen.options != _names(cell):
            self._chosen.options = _names(cell)
        if self._chosen.value != cell.bin.name:
            self._chosen.value = cell.bin.name
        self._chosen.visible = bool(cell.other_bins)
        self._visitor.admit(self._chosen, new, ChooseBin)


def _names(cell: Cell) -> tuple[str, ...]:
    return tuple(box.name for box in cell.bins)

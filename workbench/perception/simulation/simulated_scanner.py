"""The scanner of a cell that has none: it looks at a pile that falls for it."""

from itertools import cycle, islice

from workbench.model.cell import Cell
from workbench.model.errors import InputError, JobCancelled
from workbench.model.scan import ALL_KINDS, Detection, Scan
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.options import NoOptions
from workbench.plugins.scanner import Cancelled, Report, ScanRequest


class SimulatedScanner:
    """Drops parts by physics and computes what would have been measured; see `Scanner`."""

    Options = NoOptions

    def __init__(self, cell: Cell, options: NoOptions):
        self._cell = cell

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """A scan of a new pile."""
        report(0.1, "parts fall into the bin")
        truth = pile_of(self._cell, request.part, request.parts, seed=request.seed)
        if cancelled():
            raise JobCancelled("the scan was cancelled")
        report(0.6, "the scanner looks")
        return synthesize(self._cell, truth, seed=request.seed)


def pile_of(cell: Cell, kind: str, count: int, *, seed: int) -> tuple[Detection, ...]:
    """Parts that fell into the cell's bin: `count` of a kind, of the first one when it is empty.

    Of the kind `ALL_KINDS` is one of each in turn.

    Raises:
        InputError: the cell has no part, or none of that kind; or they do not fit.
    """
    if not cell.parts:
        raise InputError(f"cell {cell.name} has no part, so there is nothing to drop into its bin")
    kinds = cell.parts if kind == ALL_KINDS else (cell.part(kind or cell.parts[0].name),)
    return drop_parts(tuple(islice(cycle(kinds), count)), cell.bin, seed=seed)

"""What seeing offers at the seams: the simulated scanner, and the localizer.

Every cell that is read loads this, so what they need (1.5 s of imports) is imported at work.
"""

from dataclasses import dataclass

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.scan import LocalizationResult, Scan
from workbench.perception.simulation.noise_models import NOISE_MODELS
from workbench.plugins.options import NoOptions, option
from workbench.plugins.progress import Cancelled, Report
from workbench.plugins.scanner import ScanRequest


@dataclass(frozen=True, slots=True)
class SimulatedOptions:
    """Keys of the simulated scanner in `[scanner.options]`."""

    like: str = option(
        "fine", among=tuple(NOISE_MODELS), says="the build of scanner whose errors are simulated"
    )


class SimulatedScanner:
    """Drops parts by physics and computes what would have been measured; see `Scanner`."""

    Options = SimulatedOptions

    def __init__(self, cell: Cell, options: SimulatedOptions):
        self._cell = cell

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """A scan of a pile, or of what is left of it."""
        from workbench.perception.simulation.piles import pile_of
        from workbench.perception.simulation.synthesize import synthesize
        from workbench.perception.simulation.unloading import left_of

        report(0.1, ProgressText.PARTS_FALL())
        truth = pile_of(self._cell, request.part, request.parts, seed=request.seed)
        truth = left_of(self._cell, truth, request.lifted)
        if cancelled():
            raise JobCancelled(CancelText.SCAN())
        report(0.6, ProgressText.SCANNER_LOOKS())
        on_arm = self._cell.scanner.on_arm is not None
        return synthesize(self._cell, truth, seed=request.seed, shows_robot=on_arm)


class PointPairs:
    """The built-in localizer; see `plugins.localizer.Localizer` and `kinds.localize_parts`."""

    Options = NoOptions

    def __init__(self, options: NoOptions):
        pass

    def find(
        self,
        scan: Scan,
        cell: Cell,
        *,
        seed: int,
        detail: float,
        report: Report,
        cancelled: Cancelled,
    ) -> LocalizationResult:
        """All parts of all kinds that the cell picks."""
        from workbench.perception.colours.telling import resolve_by_colour
        from workbench.perception.localization.kinds import SearchedView, localize_parts
        from workbench.perception.localization.several_views import localize_in_views

        def localize(view: Scan, report: Report) -> SearchedView:
            return localize_parts(
                view,
                cell,
                seed=seed,
                detail=detail,
                report=report,
                cancelled=cancelled,
                resolve_by_colour=resolve_by_colour,
            )

        return localize_in_views(scan, localize, report)

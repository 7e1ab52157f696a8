"""Parts of one kind looked for in a scan, as the built-in localizer does it for all kinds."""

from dataclasses import replace

from workbench.model.cell import Cell
from workbench.model.part import Part
from workbench.model.scan import Detection, LocalizationResult, Scan
from workbench.perception.localization.kinds import localize_parts
from workbench.plugins.progress import never, silent


def searched(
    scan: Scan, part: Part, cell: Cell, *, seed: int, report=silent, cancelled=never
) -> LocalizationResult:
    """All that the search for one part brings."""
    alone = replace(cell, parts=(part,))
    return localize_parts(
        scan, alone, seed=seed, detail=1.0, report=report, cancelled=cancelled
    ).result


def localize(scan: Scan, part: Part, cell: Cell, **how) -> tuple[Detection, ...]:
    """What was found of that part."""
    return searched(scan, part, cell, **how).detections

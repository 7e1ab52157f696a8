"""The seam of localizers: which parts lie where in a scan."""

from dataclasses import replace
from typing import Any, Protocol

from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.scan import LocalizationResult, Scan
from workbench.plugins.found import USUAL, Group, load
from workbench.plugins.options import options_of
from workbench.plugins.progress import Cancelled, Report, never, silent

ENTRY_POINTS: Group = "workbench.localizers"


class Localizer(Protocol):
    """Finds all parts of a cell in a scan.

    A class with this interface is made for each search, with its options: `Options` is the
    dataclass of the keys that stand in the cell file under `[localizer.options]`
    (`plugins.options`), or `NoOptions`.
    """

    Options: type

    def __init__(self, options: Any) -> None:
        """Nothing is computed yet."""
        ...

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
        """All instances of all parts of the cell that the scan shows in its bin.

        The same scan and seed bring the same findings.  What is not sure is left out: a part that
        is missing costs a pick, a wrong pose a crash.

        Args:
            scan: organised or not.
            cell: its parts say what to look for, its bin where, its scanner how noisy points are.
            seed: of everything that is drawn.
            detail: how fine the scan is searched; 1 is usual.
            report: is called with the share done, 0..1, and what is being done.
            cancelled: is asked now and then whether to give up.

        Returns:
            `detections` with `T_world_part` and scores 0..1, the surest first, each of a part of
            the cell; `rejected` says what was checked and not taken, and may be empty.

        Raises:
            JobCancelled: `cancelled` said so.
        """
        ...


def find_parts(
    scan: Scan,
    cell: Cell,
    *,
    seed: int,
    detail: float = 1.0,
    least_score: float = 0.0,
    report: Report = silent,
    cancelled: Cancelled = never,
) -> LocalizationResult:
    """The parts in a scan, by the cell's localizer; see `Localizer.find`.

    Parts with a score below `least_score`, 0..1, are left out.

    Raises:
        InputError: there is no such localizer, or it found a part that the cell does not have.
    """
    name = cell.localizer.name or USUAL
    kind = load(ENTRY_POINTS, name)
    localizer: Localizer = kind(options_of(kind.Options, cell.localizer.options))
    found = localizer.find(scan, cell, seed=seed, detail=detail, report=report, cancelled=cancelled)
    known = {part.name for part in cell.parts}
    for detection in found.detections:
        if detection.part not in known:
            raise InputError(
                f"localizer {name} found a part {detection.part!r}, which the cell has not"
            )
    sure = tuple(part for part in found.detections if part.score >= least_score)
    return replace(found, detections=sure)

"""The seam of scanners: where scans come from."""

from dataclasses import dataclass
from typing import Any, Protocol

import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.scan import Scan
from workbench.plugins.found import Group, load
from workbench.plugins.options import options_of
from workbench.plugins.progress import Cancelled as Cancelled
from workbench.plugins.progress import Report as Report

ENTRY_POINTS: Group = "workbench.scanners"


@dataclass(frozen=True, slots=True)
class ScanRequest:
    """What a simulated scanner shall see; a real one sees what lies there.

    `parts` parts of the kind `part` (empty: for kits, or the first) dropped by `seed`.  Those that
    lay at the poses `lifted`, `T_world_part`, were taken out since, one after the other.
    """

    seed: int = 0
    parts: int = 0
    part: str = ""
    lifted: tuple[pin.SE3, ...] = ()


class Scanner(Protocol):
    """A driver of one make of scanner.

    A class with this interface is made anew for each scan, in a process of its own, with the cell
    and its options: `cell.scanner` is the mount with pose, intrinsics, range, `address` and
    `patience`; `Options` is the dataclass of the keys that stand in the cell file under
    `[scanner.options]` (`plugins.options`), or `NoOptions`.
    """

    Options: type

    def __init__(self, cell: Cell, options: Any) -> None:
        """Connect to nothing yet."""
        ...

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Take one scan, of what lies in the bin after this call.

        `Scan.points` are in the scanner's frame [m]; organised scans have `pixels` and a
        `resolution`.  `T_world_scanner` is the mount's.

        Raises:
            LinkError: nothing came within `cell.scanner.patience`, or what came is no scan.
            FileError: what came is no cloud.
            JobCancelled: `cancelled`, asked at least every 0.1 s, said so.
        """
        ...


def scanner_of(cell: Cell) -> Scanner:
    """The cell's scanner, ready to take one scan.

    Raises:
        InputError: there is none of its name, or its options are not right.
    """
    kind = load(ENTRY_POINTS, cell.scanner.source)
    return kind(cell, options_of(kind.Options, cell.scanner.options))

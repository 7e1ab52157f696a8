"""The scanner `merged`: several scanners, each with a calibrated pose of its own, as one cloud.

A cell has one scanner, in whose frame all points are.  This one takes a scan of each view, one
after the other, so that none lights what another looks at.  It puts the points together in its own
frame by the poses in the world that the views were calibrated to.  Where its own frame lies moves
no point in the world: it is where the bin is seen from when parts are searched.
"""

import re
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.formats.cells.devices import read_scanner
from workbench.formats.clouds.scans import MOST_POINTS
from workbench.formats.files.toml_keys import read_toml
from workbench.model.cell import Cell, ScannerMount
from workbench.model.errors import FileError, InputError, JobCancelled, LinkError
from workbench.model.geometry import Floats, transform
from workbench.model.messages.devices import ScannerText
from workbench.model.messages.message import Message
from workbench.model.messages.work import CancelText
from workbench.model.scan import Scan
from workbench.plugins.options import option
from workbench.plugins.progress import Cancelled, Report
from workbench.plugins.scanner import Scanner, ScanRequest, scanner_of

MERGED, SIMULATED = "merged", "simulated"
FEWEST_VIEWS, MOST_VIEWS = 2, 8
DAY = 24 * 3600.0


@dataclass(frozen=True, slots=True)
class MergedOptions:
    """The keys of `merged` under `[scanner.options]`."""

    views: str = option(
        says="files in the folder `address`, commas between; each has a table [scanner]"
    )


@dataclass(frozen=True, slots=True, eq=False)
class ScannerView:
    """One of the scanners: the file that describes it, where it hangs, and its driver."""

    file: Path
    mount: ScannerMount
    scanner: Scanner


class MergedScanner:
    """The scans of several scanners as one; if one of them fails there is none."""

    Options = MergedOptions

    def __init__(self, cell: Cell, options: MergedOptions):
        self._mount = cell.scanner
        self._views = _views(cell, options)

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Take a scan of each view; see `Scanner`."""
        for view in self._views:
            _check_calibration(view, time.time())
        clouds, colours, notes = list[Floats](), list[np.ndarray | None](), list[str]()
        for number, view in enumerate(self._views):

            def share(
                done: float, note: Message | str, view: ScannerView = view, number: int = number
            ) -> None:
                report((number + done) / len(self._views), f"{view.file.name}: {note}")

            try:
                scan = view.scanner.scan(request, share, cancelled)
            except (FileError, LinkError) as error:
                raise _make_error(view, error.message) from None
            if cancelled():
                raise JobCancelled(CancelText.SCAN())
            T = self._mount.T_world_scanner.actInv(scan.T_world_scanner)
            clouds.append(transform(T, scan.points))
            colours.append(scan.colours)
            notes.append(f"{len(scan.points):,} of {view.file.name}")
        points = np.concatenate(clouds)
        if len(points) > MOST_POINTS:
            raise LinkError(ScannerText.MOST_POINTS(count=len(points), most=MOST_POINTS))
        # Where one of the scanners gives no colours, nobody could tell which points have some.
        painted = [each for each in colours if each is not None]
        return Scan(
            points,
            self._mount.T_world_scanner,
            f"merged: {', '.join(notes)}",
            colours=np.concatenate(painted) if len(painted) == len(colours) else None,
        )


def _views(cell: Cell, options: MergedOptions) -> tuple[ScannerView, ...]:
    """The views that are named, ready to take one scan.

    Raises:
        InputError: these are no names of files, or too few or too many.
        FileError: a file cannot be read, or is of another `merged`.
    """
    names = [name for name in re.split(r"[,\s]+", options.views) if name]
    if not FEWEST_VIEWS <= len(names) <= MOST_VIEWS or len(set(names)) < len(names):
        raise InputError(
            f"views: {FEWEST_VIEWS} to {MOST_VIEWS} different files are expected, not "
            f"{options.views!r}"
        )
    if any("/" in name for name in names):
        raise InputError(f"views: names of files in `address` are expected, not {options.views!r}")
    views: list[ScannerView] = []
    for name in names:
        table = read_toml(Path(cell.scanner.address) / name).table("scanner")
        mount = read_scanner(table)
        if mount.source == MERGED:
            raise table.error("source", "a view is one scanner, and none that is merged itself")
        # The parts, the bin and the robot are those of the cell: one world.
        scanner = scanner_of(replace(cell, scanner=mount))
        views.append(ScannerView(table.path, mount, scanner))
    return tuple(views)


def _check_calibration(view: ScannerView, now: float) -> None:
    """A view whose pose nobody has measured, or long ago, would put its points anywhere.

    Raises:
        LinkError: it is such a view.
    """
    record = view.mount.calibration
    if view.mount.source == SIMULATED:
        return
    if record is None:
        raise _make_error(view, ScannerText.NOT_CALIBRATED())
    days = (now - record.at) / DAY
    if days > view.mount.calibration_days:
        allowed = view.mount.calibration_days
        raise _make_error(
            view, ScannerText.CALIBRATION_OLD(days=round(days), allowed=f"{allowed:g}")
        )


def _make_error(view: ScannerView, problem: Message) -> LinkError:
    return LinkError(ScannerText.VIEW(name=view.file.name, problem=problem))

"""The scanner `folder`: clouds that another program writes as files."""

import time
from pathlib import Path

from workbench.formats.clouds.scans import read_scan
from workbench.formats.files.whole_files import Stamp, stamps
from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.messages.devices import ScannerText
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.scan import Scan
from workbench.plugins.options import NoOptions
from workbench.plugins.progress import Cancelled, Report
from workbench.plugins.scanner import ScanRequest

FILE_ENDINGS = frozenset({".ply", ".pcd"})
COMPLETE_AFTER = 0.3
"""[s] A file that has not grown for that long is complete."""

GLANCE = 0.1
"""[s] Between two looks into a folder."""


class FolderScanner:
    """The next complete PLY or PCD file that somebody puts into a folder.

    A file counts when it was begun after the scan was asked for: one from before may show a bin
    that is not like that any more.  So one that was there counts when it has come to rest and is
    written again.  It is complete when it has stopped growing.
    """

    Options = NoOptions

    def __init__(self, cell: Cell, options: NoOptions):
        self._mount = cell.scanner
        self._folder = Path(cell.scanner.address)

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Wait for the next file; see `Scanner`."""
        if not self._folder.is_dir():
            raise LinkError(ScannerText.NO_FOLDER(folder=str(self._folder)))
        began = time.monotonic()
        seen = {path: (stamp, began) for path, stamp in self._files().items()}
        # Those may be written just now; what they are once they rest is from before, too.
        unsettled, before = set(seen), dict[Path, Stamp]()
        while (waited := time.monotonic() - began) < self._mount.patience:
            if cancelled():
                raise JobCancelled(CancelText.SCAN())
            report(
                waited / self._mount.patience, ProgressText.WAITS_FOR_FILE(folder=str(self._folder))
            )
            for path, stamp in self._files().items():
                if before.get(path) == stamp:
                    continue
                known, since = seen.get(path, (None, 0.0))
                if known != stamp:
                    seen[path] = (stamp, time.monotonic())
                elif time.monotonic() - since >= COMPLETE_AFTER and path in unsettled:
                    unsettled.discard(path)
                    before[path] = stamp
                elif time.monotonic() - since >= COMPLETE_AFTER and stamp[1] > 0:
                    return read_scan(path, self._mount)
            time.sleep(GLANCE)
        raise LinkError(
            ScannerText.NO_FILE(folder=str(self._folder), patience=self._mount.patience)
        )

    def _files(self) -> dict[Path, Stamp]:
        try:
            return stamps(self._folder, FILE_ENDINGS)
        except OSError as error:
            raise LinkError(
                ScannerText.PROBLEM(name=str(self._folder), problem=error.strerror or str(error))
            ) from None

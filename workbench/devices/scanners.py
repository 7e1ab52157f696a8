"""Scanners: where scans come from when they are not simulated.

A scanner of another maker is one class with `scan`, and its line in `SCANNERS`; its name goes to
`model/cell.py:ScanSource`.
"""

import http.client
import time
import urllib.request
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

from workbench.formats.clouds.scans import LARGEST_FILE, parse_scan, read_scan
from workbench.model.cell import ScannerMount, ScanSource
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.scan import Scan

KINDS = frozenset({".ply", ".pcd"})
STILL = 0.3
"""[s] A file that has not grown for so long is complete."""

GLANCE = 0.1
"""[s] Between two looks into a folder."""

CHUNK = 1 << 20
WAITS = 10.0
"""[s] For the next bytes of an answer."""


class Scanner(Protocol):
    """Takes one scan.

    Raises:
        LinkError: nothing came in time, or what came is no scan.
        FileError: what came is no cloud.
        JobCancelled: `cancelled` said so.
    """

    def scan(self, report: Callable[[float, str], None], cancelled: Callable[[], bool]) -> Scan:
        """Wait for the next scan; `report` is told the share of the patience used up."""
        ...


class FolderScanner:
    """The next complete PLY or PCD file that somebody puts into a folder.

    A file counts when it was written after the scan was asked for: one from before may show a bin
    that is not like that any more.  It is complete when it has stopped growing.
    """

    def __init__(self, mount: ScannerMount):
        self._mount = mount
        self._folder = Path(mount.address)

    def scan(self, report: Callable[[float, str], None], cancelled: Callable[[], bool]) -> Scan:
        """Wait for the next file; see `Scanner`."""
        if not self._folder.is_dir():
            raise LinkError(f"scanner: there is no folder {self._folder}")
        before, began = self._files(), time.monotonic()
        seen: dict[Path, tuple[tuple[int, int], float]] = {}
        while (waited := time.monotonic() - began) < self._mount.patience:
            if cancelled():
                raise JobCancelled("the scan was cancelled")
            report(waited / self._mount.patience, f"waiting for a file in {self._folder}")
            for path, stamp in self._files().items():
                if before.get(path) == stamp:
                    continue
                known, since = seen.get(path, (None, 0.0))
                if known != stamp:
                    seen[path] = (stamp, time.monotonic())
                elif time.monotonic() - since >= STILL and stamp[1] > 0:
                    return read_scan(path, self._mount)
            time.sleep(GLANCE)
        raise LinkError(
            f"scanner: no new PLY or PCD file came into {self._folder} within "
            f"{self._mount.patience:g} s"
        )

    def _files(self) -> dict[Path, tuple[int, int]]:
        """Clouds in the folder with their times [ns] and sizes."""
        try:
            paths = list(self._folder.iterdir())
        except OSError as error:
            raise LinkError(f"scanner: {self._folder}: {error.strerror or error}") from None
        found: dict[Path, tuple[int, int]] = {}
        for path in paths:
            if path.suffix.lower() in KINDS and not path.name.startswith("."):
                try:
                    status = path.stat()
                except OSError:
                    continue  # renamed in between
                found[path] = (status.st_mtime_ns, status.st_size)
        return found


class HttpScanner:
    """A PLY or PCD file that a page gives when it is asked."""

    def __init__(self, mount: ScannerMount):
        self._mount = mount

    def scan(self, report: Callable[[float, str], None], cancelled: Callable[[], bool]) -> Scan:
        """Ask for a scan; see `Scanner`."""
        address, began = self._mount.address, time.monotonic()
        content = bytearray()
        report(0.0, f"asking {address}")
        try:
            with urllib.request.urlopen(address, timeout=WAITS) as answer:
                # As much as has come: `read` would wait for a whole chunk, however slowly it comes.
                while chunk := answer.read1(CHUNK):
                    content += chunk
                    if cancelled():
                        raise JobCancelled("the scan was cancelled")
                    if len(content) > LARGEST_FILE:
                        raise LinkError(f"scanner: {address} gives more than a scan can hold")
                    if time.monotonic() - began > self._mount.patience:
                        raise LinkError(f"scanner: {address} is too slow")
                    report(0.5, f"{len(content) / 1e6:.1f} MB from {address}")
        except (OSError, http.client.HTTPException, ValueError) as error:
            raise LinkError(f"scanner: {address}: {error}") from None
        name = Path(urllib.request.url2pathname(address).rpartition("/")[2] or "scan")
        return parse_scan(name, bytes(content), self._mount)


SCANNERS: Mapping[ScanSource, Callable[[ScannerMount], Scanner]] = {
    "folder": FolderScanner,
    "http": HttpScanner,
}
"""By the names in the cell file; `simulated` needs a pile and is made in `app/runtime/work.py`."""

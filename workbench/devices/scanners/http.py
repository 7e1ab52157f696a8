"""The scanner `http`: a cloud that a page gives when it is asked, with login and TLS."""

import asyncio
import time
from pathlib import Path
from urllib.parse import unquote, urlsplit

from workbench.devices.scanners.logins import BASIC, BEARER, HttpOptions
from workbench.formats.clouds.scans import parse_scan
from workbench.model.cell import Cell
from workbench.model.errors import InputError, JobCancelled, LinkError
from workbench.model.messages.devices import ScannerText
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.scan import Scan
from workbench.plugins.progress import Cancelled, Report
from workbench.plugins.scanner import ScanRequest

GLANCE = 0.1
"""[s] Between two looks whether it was cancelled."""

PLAIN = "http://"


class HttpScanner:
    """A PLY or PCD file that a page gives when it is asked.

    A page that sends elsewhere is not followed: what the cell file names is what is asked, and
    what a login was given for.
    """

    Options = HttpOptions

    def __init__(self, cell: Cell, options: HttpOptions):
        self._mount = cell.scanner
        self._options = options
        if cell.scanner.address.startswith(PLAIN):
            if options.login in (BASIC, BEARER):
                raise InputError(
                    f"login {options.login} would send the secret to {cell.scanner.address} as it "
                    "is, for all to read on the way: give an https address, or use digest"
                )
            if options.ca_file or options.pinned:
                raise InputError(
                    f"{cell.scanner.address} has no certificate: give an https address"
                )

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Ask for a scan; see `Scanner`."""
        address = self._mount.address
        report(0.0, ProgressText.ASKS(address=address))
        try:
            content = asyncio.run(self._ask(report, cancelled))
        except LinkError as error:
            raise LinkError(ScannerText.PROBLEM(name=address, problem=error.message)) from None
        name = Path(unquote(urlsplit(address).path).rpartition("/")[2] or "scan")
        return parse_scan(name, content, self._mount)

    async def _ask(self, report: Report, cancelled: Cancelled) -> bytes:
        """What the page gives, within the patience, unless it is cancelled."""
        # Every cell that is read loads this module, and its import takes 0.4 s.
        from workbench.devices.scanners.pages import pull

        content, began = bytearray(), time.monotonic()
        asking = asyncio.create_task(pull(self._mount.address, self._options, content))
        try:
            while not asking.done():
                if cancelled():
                    raise JobCancelled(CancelText.SCAN())
                waited = time.monotonic() - began
                megabytes = f"{len(content) / 1e6:.1f}"
                if waited > self._mount.patience:
                    raise LinkError(
                        ScannerText.TOO_SLOW(size=megabytes, patience=self._mount.patience)
                    )
                report(waited / self._mount.patience, ProgressText.CAME(size=megabytes))
                await asyncio.wait({asking}, timeout=GLANCE)
            await asking
        finally:
            asking.cancel()
            await asyncio.gather(asking, return_exceptions=True)
        return bytes(content)

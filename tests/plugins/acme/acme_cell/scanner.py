"""The Acme 3000: x, y, z in mm as little-endian 32-bit floats, then the end of the stream."""

import socket
from dataclasses import dataclass

import numpy as np

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.scan import Scan
from workbench.plugins.options import option
from workbench.plugins.scanner import Cancelled, Report, ScanRequest

LARGEST = 200_000_000
"""[bytes] More is no scan."""


class AcmeScanner:
    """Asks for a scan by connecting to `address`, which is host:port."""

    @dataclass(frozen=True)
    class Options:
        """Keys in `[scanner.options]`."""

        nearest_mm: float = option(0.0, low=0.0, high=5000.0, says="nearer points are dust")

    def __init__(self, cell: Cell, options: Options) -> None:
        self._mount, self._options = cell.scanner, options

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """One scan; the request is for simulated scanners."""
        mount, content = self._mount, bytearray()
        host, _, port = mount.address.partition(":")
        report(0.0, f"asking {mount.address}")
        try:
            with socket.create_connection((host, int(port)), mount.patience) as link:
                while chunk := link.recv(1 << 16):
                    content += chunk
                    if cancelled():
                        raise JobCancelled("the scan was cancelled")
                    if len(content) > LARGEST:
                        raise LinkError("scanner: it sends more than a scan can hold")
        except (OSError, ValueError) as error:
            raise LinkError(f"scanner {mount.address}: {error}") from None
        whole = len(content) // 12 * 12
        points = np.frombuffer(bytes(content[:whole]), "<f4").reshape(-1, 3).astype(float) / 1000
        seen = np.isfinite(points).all(axis=1) & points.any(axis=1)
        seen &= points[:, 2] >= self._options.nearest_mm / 1000
        if not seen.any():
            raise LinkError("scanner: it has measured nothing")
        return Scan(points[seen], mount.T_world_scanner, "acme")

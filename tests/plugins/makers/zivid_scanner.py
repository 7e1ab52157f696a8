"""Zivid: `pip install zivid`, with Zivid's SDK; `address` is a serial number, or empty."""

from dataclasses import dataclass

from image_scan import image_scan

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.scan import Scan
from workbench.plugins.options import option
from workbench.plugins.scanner import Cancelled, Report, ScanRequest


class ZividScanner:
    """One capture with the settings of a file from Zivid Studio."""

    @dataclass(frozen=True)
    class Options:
        """Keys in `[scanner.options]`."""

        settings: str = option(says="absolute path of a .yml file of Zivid Studio")

    def __init__(self, cell: Cell, options: Options) -> None:
        self._mount, self._options = cell.scanner, options

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Capture; the library cannot be interrupted meanwhile."""
        import zivid

        report(0.0, "capturing")
        if cancelled():
            raise JobCancelled("the scan was cancelled")
        try:
            settings = zivid.Settings.load(self._options.settings)
            named = {"serial_number": self._mount.address} if self._mount.address else {}
            camera = zivid.Application().connect_camera(**named)
            try:
                with camera.capture_3d(settings) as frame:
                    points = frame.point_cloud().copy_data("xyz")
            finally:
                camera.disconnect()
        except RuntimeError as error:
            raise LinkError(f"scanner: {error}") from None
        return image_scan(points, self._mount, "zivid")

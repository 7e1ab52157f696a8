"""Ensenso: `pip install nxlib`, with the Ensenso SDK; `address` is the serial number."""

from image_scan import image_scan

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.scan import Scan
from workbench.plugins.options import NoOptions
from workbench.plugins.scanner import Cancelled, Report, ScanRequest


class EnsensoScanner:
    """One capture of a stereo or a structured-light camera, as it is set in NxView."""

    Options = NoOptions

    def __init__(self, cell: Cell, options: NoOptions) -> None:
        self._mount = cell.scanner

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Capture; the library cannot be interrupted meanwhile."""
        import nxlib

        report(0.0, "capturing")
        if cancelled():
            raise JobCancelled("the scan was cancelled")
        try:
            with nxlib.NxLib(), nxlib.Camera.from_serial(self._mount.address) as camera:
                camera.capture()
                camera.compute_disparity_map()  # does nothing for structured light
                camera.compute_point_map()
                points = camera.get_point_map()
        except Exception as error:  # NxLibException and errors of cameras have no common base
            raise LinkError(f"scanner {self._mount.address}: {error}") from None
        return image_scan(points, self._mount, f"ensenso {self._mount.address}")

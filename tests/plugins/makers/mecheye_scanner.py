"""Mech-Eye: `pip install MechEyeAPI`, of the camera's version; `address` is the IP address."""

from typing import Any

from image_scan import image_scan

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.scan import Scan
from workbench.plugins.options import NoOptions
from workbench.plugins.scanner import Cancelled, Report, ScanRequest


class MechEyeScanner:
    """One capture with the user set that was chosen in Mech-Eye Viewer."""

    Options = NoOptions

    def __init__(self, cell: Cell, options: NoOptions) -> None:
        self._mount = cell.scanner

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Capture; the library cannot be interrupted meanwhile."""
        from mecheye.area_scan_3d_camera import Camera, Frame3D

        report(0.0, "capturing")
        if cancelled():
            raise JobCancelled("the scan was cancelled")
        camera, frame = Camera(), Frame3D()
        self._check(camera.connect(self._mount.address))
        try:
            self._check(camera.capture_3d(frame))
        finally:
            camera.disconnect()
        points = frame.get_untextured_point_cloud().data()
        return image_scan(points, self._mount, f"mech-eye {self._mount.address}")

    def _check(self, status: Any) -> None:
        """Calls of the library return a status; its method `is_ok` tells whether they worked."""
        if not status.is_ok():
            raise LinkError(f"scanner {self._mount.address}: {status.error_description}")

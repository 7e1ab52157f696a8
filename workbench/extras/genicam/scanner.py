"""The scanner driver `genicam`: depth cameras on GigE Vision."""

from dataclasses import dataclass
from typing import Literal

from workbench.devices.scanners.organised_clouds import scan_of
from workbench.extras.genicam.camera import Camera, DepthFrame, one_frame, open_camera
from workbench.extras.genicam.depth import DepthScale, organise_points
from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.messages.devices import ScannerText
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.scan import Scan
from workbench.plugins.options import option
from workbench.plugins.progress import Cancelled, Report
from workbench.plugins.scanner import ScanRequest

UNITS = {"Millimeter": 0.001, "Inch": 0.0254}
"""[m] By the entries of Scan3dDistanceUnit that are lengths."""

SOFTWARE = "software"


@dataclass(frozen=True, slots=True)
class GenicamOptions:
    """The keys of `genicam` under `[scanner.options]`."""

    serial: str = option("", says="serial number; empty: whichever is at `address`, or the only")
    pixel_format: str = option(
        "Coord3D_C16", among=("Coord3D_C16", "Mono16"), says="of the depth map"
    )
    trigger: str = option(
        SOFTWARE,
        among=(SOFTWARE, "free"),
        says="software, or the first frame after the camera is started",
    )
    exposure_us: float = option(0.0, low=0, high=1e7, says="0: as the camera is set")
    packet_bytes: int = option(0, low=0, high=16_000, says="of the stream; 0: as the camera is set")
    scale_mm: float = option(0.0, low=0, high=1000, says="depth of a count; 0: the camera says it")
    offset_mm: float = option(0.0, low=-1e5, high=1e5, says="of the depth, together with scale_mm")
    focal_px: float = option(0.0, low=0, high=1e6, says="focal length; 0: the camera says it")
    center_u_px: float = option(0.0, low=-1e5, high=1e5, says="principal point, with focal_px")
    center_v_px: float = option(0.0, low=-1e5, high=1e5, says="principal point, with focal_px")
    invalid: int = option(
        -1, low=-1, high=65535, says="of a pixel without a depth; -1: camera's, or 0"
    )


class GenicamScanner:
    """One depth map of a camera, as an organised cloud."""

    Options = GenicamOptions

    def __init__(self, cell: Cell, options: GenicamOptions):
        self._mount = cell.scanner
        self._options = options

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Take one frame; see `Scanner`."""
        named = self._mount.address or self._options.serial or "the only camera"

        def glance(share: float) -> None:
            if cancelled():
                raise JobCancelled(CancelText.SCAN())
            report(share, ProgressText.WAITS_FOR_IMAGE(scanner=named))

        glance(0.0)
        try:
            with open_camera(self._mount.address, self._options.serial) as camera:
                _set(camera, self._options)
                means = _means(camera, self._options)
                is_triggered = self._options.trigger == SOFTWARE
                frame = one_frame(camera, is_triggered, self._mount.patience, glance)
            return self._scan(frame, means, named)
        except LinkError as error:
            raise LinkError(ScannerText.PROBLEM(name=named, problem=error.message)) from None

    def _scan(self, frame: DepthFrame, means: DepthScale, named: str) -> Scan:
        """The scan of a frame, if it lies where the scanner can measure."""
        return scan_of(
            organise_points(frame.counts, means),
            self._mount,
            f"{named} frame {frame.number}",
            ScannerText.IS_SCALE_RIGHT(scale=means.scale),
        )


def _set(camera: Camera, options: GenicamOptions) -> None:
    """Make the camera ready: silent, then format, exposure and trigger."""
    camera.call("arv_camera_stop_acquisition")
    camera.choose("PixelFormat", options.pixel_format)
    if options.exposure_us > 0:
        camera.call("arv_camera_set_exposure_time", options.exposure_us)
    if options.packet_bytes > 0:
        camera.call("arv_camera_gv_set_packet_size", options.packet_bytes)
    if options.trigger == SOFTWARE:
        camera.call("arv_camera_set_trigger", b"Software")
    else:
        camera.call("arv_camera_clear_triggers")


def _means(camera: Camera, options: GenicamOptions) -> DepthScale:
    """What the counts mean: by the cell file where it says so, otherwise by the camera."""
    if camera.has("Scan3dCoordinateSelector"):
        camera.choose("Scan3dCoordinateSelector", "CoordinateC")
    scale, offset = options.scale_mm / 1000, options.offset_mm / 1000
    if scale == 0:
        unit = _unit(camera)
        scale = _read_number(camera, "Scan3dCoordinateScale", "scale_mm") * unit
        offset = _read_number(camera, "Scan3dCoordinateOffset", "scale_mm") * unit
    focal, center = options.focal_px, (options.center_u_px, options.center_v_px)
    if focal == 0:
        focal = _read_number(camera, "Scan3dFocalLength", "focal_px")
        center = (
            _read_number(camera, "Scan3dPrincipalPointU", "focal_px"),
            _read_number(camera, "Scan3dPrincipalPointV", "focal_px"),
        )
    return DepthScale(scale, offset, focal, center, _invalid(camera, options))


def _unit(camera: Camera) -> float:
    """[m] Of the camera's scale and offset."""
    if not camera.has("Scan3dDistanceUnit"):
        return UNITS["Millimeter"]
    unit = camera.choice("Scan3dDistanceUnit")
    if unit not in UNITS:
        detail = f"Scan3dDistanceUnit is {unit!r}, expected one of {', '.join(UNITS)}"
        raise LinkError(ScannerText.SETTING(detail=detail))
    return UNITS[unit]


def _invalid(camera: Camera, options: GenicamOptions) -> int | None:
    """The count of pixels without a measurement; None where the camera says there is none."""
    if options.invalid >= 0:
        return options.invalid
    if camera.has("Scan3dInvalidDataFlag") and not camera.flag("Scan3dInvalidDataFlag"):
        return None
    if not camera.has("Scan3dInvalidDataValue"):
        return 0
    return int(camera.number("Scan3dInvalidDataValue"))


def _read_number(camera: Camera, feature: str, key: Literal["scale_mm", "focal_px"]) -> float:
    if not camera.has(feature):
        raise LinkError(ScannerText.NO_FEATURE(feature=feature, key=key))
    return camera.number(feature)

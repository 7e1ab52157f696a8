"""The scanner `realsense`: one depth image of a RealSense camera, or of a recording of one.

Source: RealSense SDK 2.0, documentation of `rs2::sensor`, `rs2::playback` and `rs2::pointcloud`.
"""

import importlib
import queue
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from workbench.devices.scanners.organised_clouds import scan_of
from workbench.model.cell import Cell
from workbench.model.errors import InputError, JobCancelled, LinkError
from workbench.model.geometry import Floats
from workbench.model.messages.devices import DeviceText, ScannerText
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.scan import Scan
from workbench.plugins.extras import install_command
from workbench.plugins.options import option
from workbench.plugins.progress import Cancelled, Report
from workbench.plugins.scanner import ScanRequest

LIBRARY = "pyrealsense2"
GLANCE = 0.05
"""[s] Between two looks whether to end."""

LAST_IMAGES = 5.0
"""[s] Time after the last image in which a finished recording may deliver another: images wait for
this program, also when other programs use the processor."""


@dataclass(frozen=True, slots=True)
class RealsenseOptions:
    """The keys of `realsense` under `[scanner.options]`."""

    serial: str = option("", says="serial number; empty: the only camera that is there")
    file: str = option("", says="absolute path of a recording that is played instead of a camera")
    columns: int = option(0, low=0, high=4096, says="of the depth image; 0: as the camera is set")
    rows: int = option(0, low=0, high=4096, says="of the depth image, with columns")
    exposure_us: float = option(0.0, low=0, high=1e6, says="0: the camera finds it by itself")
    skipped_frames: int = option(
        15, low=0, high=1000, says="thrown away first, while the exposure settles"
    )

    def __post_init__(self) -> None:
        if self.file and not Path(self.file).is_absolute():
            raise InputError("file: an absolute path is expected")
        if self.file and (self.exposure_us or self.columns):
            key = "exposure_us" if self.exposure_us else "columns"
            raise InputError(f"{key}: a recording (file) is as it was recorded")
        if bool(self.columns) != bool(self.rows):
            raise InputError("columns: rows are given together with it, or neither")


class RealsenseScanner:
    """One depth image as an organised cloud, its pixels put into space by the maker's library."""

    Options = RealsenseOptions

    def __init__(self, cell: Cell, options: RealsenseOptions):
        self._mount = cell.scanner
        self._options = options

    def scan(self, request: ScanRequest, report: Report, cancelled: Cancelled) -> Scan:
        """Take one image after those that are skipped; see `Scanner`."""
        named = self._options.file or self._options.serial or "the only camera"
        report(0.0, f"starting {named}")
        if cancelled():
            raise JobCancelled(CancelText.SCAN())
        try:
            sdk: Any = importlib.import_module(LIBRARY)
        except ImportError:
            command = install_command("realsense")
            raise LinkError(DeviceText.LIBRARY(library=LIBRARY, command=command)) from None
        taking = _Taking(sdk, self._options.skipped_frames)
        try:
            with _running(sdk, self._options, taking) as has_ended:
                number, points = self._wait_for(taking, has_ended, named, report, cancelled)
            source = f"{named} frame {number}"
            return scan_of(points, self._mount, source, ScannerText.IS_IT_THIS())
        except (LinkError, RuntimeError) as error:
            problem = error.message if isinstance(error, LinkError) else str(error)
            raise LinkError(ScannerText.PROBLEM(name=named, problem=problem)) from None

    def _wait_for(
        self,
        taking: "_Taking",
        has_ended: Callable[[], bool],
        named: str,
        report: Report,
        cancelled: Cancelled,
    ) -> "_Image":
        """The image, as soon as it is there."""
        began = heard = time.monotonic()
        skipped = 0
        while (waited := time.monotonic() - began) < self._mount.patience:
            if cancelled():
                raise JobCancelled(CancelText.SCAN())
            report(waited / self._mount.patience, ProgressText.WAITS_FOR_IMAGE(scanner=named))
            if taking.skipped > skipped:
                skipped, heard = taking.skipped, time.monotonic()
            is_over = has_ended() and time.monotonic() - heard > LAST_IMAGES
            with suppress(queue.Empty):
                return taking.images.get(timeout=GLANCE)
            if is_over:
                skipped = self._options.skipped_frames
                raise LinkError(ScannerText.RECORDING_ENDS(count=taking.skipped, skipped=skipped))
        raise LinkError(ScannerText.NO_IMAGE(patience=self._mount.patience))


_Image = tuple[int, Floats]
"""The number of a frame, and its points (rows, columns, 3) [m]."""


class _Taking:
    """What the library calls with each frame: it keeps the first after those that are skipped.

    A recording waits for it, so that no frame is left out however slow we are.
    """

    def __init__(self, sdk: Any, skipping: int) -> None:
        self.images: queue.Queue[_Image] = queue.Queue()
        self.skipped = 0
        self._sdk, self._skipping, self._is_done = sdk, skipping, False

    def __call__(self, frame: Any) -> None:
        """Take a frame; its memory is the library's and only lent."""
        if self._is_done:
            return
        if self.skipped < self._skipping:
            self.skipped += 1
            return
        self._is_done = True
        depth = frame.as_depth_frame()
        vertices = self._sdk.pointcloud().calculate(depth).get_vertices(2)
        points = np.array(vertices, dtype=np.float64)
        points[points[:, 2] == 0] = np.nan
        shape = (depth.get_height(), depth.get_width(), 3)
        self.images.put((depth.get_frame_number(), points.reshape(shape)))


@contextmanager
def _running(sdk: Any, options: RealsenseOptions, take: _Taking) -> Generator[Callable[[], bool]]:
    """The camera or the recording sends depth images; gives whether there will be no more.

    Raises:
        LinkError: there is no such file or camera, or it has no such images.
        RuntimeError: the library cannot open or start it.
    """
    context = sdk.context()
    device = _recording(context, options) if options.file else _camera(sdk, context, options)
    number = device.get_info(sdk.camera_info.serial_number)
    if options.serial not in ("", number):
        raise LinkError(ScannerText.OTHER_CAMERA(found=number, serial=options.serial))
    sensor, profile = _depths(sdk, device, options)
    if options.exposure_us:
        sensor.set_option(sdk.option.enable_auto_exposure, 0)
        sensor.set_option(sdk.option.exposure, options.exposure_us)

    def has_ended() -> bool:
        return bool(options.file) and device.current_status() == sdk.playback_status.stopped

    sensor.open(profile)
    try:
        sensor.start(take)
        try:
            yield has_ended
        finally:
            if options.file:
                # While a recording hands over an image, stopping it is a race in the library that
                # ends the process.  One that pauses hands over nothing; one that ended cannot.
                with suppress(RuntimeError):
                    device.pause()
            sensor.stop()
    finally:
        sensor.close()


def _recording(context: Any, options: RealsenseOptions) -> Any:
    # The library would make a file that is not there.
    if not Path(options.file).is_file():
        raise LinkError(ScannerText.NO_RECORDING(file=options.file))
    device = context.load_device(options.file)
    device.set_real_time(False)
    return device


def _camera(sdk: Any, context: Any, options: RealsenseOptions) -> Any:
    """The camera of that number, or the only one."""
    devices = {
        device.get_info(sdk.camera_info.serial_number): device for device in context.query_devices()
    }
    if options.serial in devices:
        return devices[options.serial]
    if options.serial or len(devices) != 1:
        found = ", ".join(sorted(devices)) or "-"
        raise LinkError(ScannerText.NO_SUCH_CAMERA(serial=options.serial or "-", found=found))
    return next(iter(devices.values()))


def _depths(sdk: Any, device: Any, options: RealsenseOptions) -> tuple[Any, Any]:
    """The sensor that sends depth images, and in which form: as asked for, or as is usual."""
    for sensor in device.query_sensors():
        for profile in sensor.get_stream_profiles():
            if profile.stream_type() != sdk.stream.depth or profile.format() != sdk.format.z16:
                continue
            image = profile.as_video_stream_profile()
            size = (image.width(), image.height())
            is_usual = options.columns == 0 and (bool(options.file) or profile.is_default())
            if is_usual or size == (options.columns, options.rows):
                return sensor, profile
    if options.columns:
        raise LinkError(ScannerText.NO_DEPTH_SIZE(columns=options.columns, rows=options.rows))
    raise LinkError(ScannerText.NO_DEPTH())

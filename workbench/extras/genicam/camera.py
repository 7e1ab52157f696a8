"""One camera: found, set, and asked for one frame that was taken after the asking."""

import ctypes
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.extras.genicam.depth import MOST_PIXELS
from workbench.extras.genicam.library import Aravis, aravis
from workbench.model.errors import LinkError
from workbench.model.messages.devices import ScannerText

SIXTEEN_BITS = {0x01100007: "Mono16", 0x011000B8: "Coord3D_C16"}
"""Pixel formats of GenICam's Pixel Format Naming Convention that hold one depth of 16 bits."""

BUFFERS = 4
GLANCE = 0.1
"""[s] Between two looks whether the scan was cancelled."""

ARMING = 0.05
"""[s] From the start to the trigger: cameras need it, and nothing that comes meanwhile counts."""

ALIVE = 1.0
"""[s] A camera that sends nothing is asked this often whether it is still there."""

AGAIN = 5.0
"""[s] A trigger is repeated this often: a camera that is not ready for one ignores it."""

NO_RAW_SOCKET = 1
"""ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED: the same stream with and without privileges."""

SUCCESS, IMAGE = 0, 1
WRONG = {
    1: "was not filled",
    2: "did not arrive in time",
    3: "has lost packets",
    4: "has packets of another frame",
    5: "has another size than the camera said",
    6: "was not complete",
    7: "was broken off",
}
"""ArvBufferStatus, except for success."""


@dataclass(frozen=True, slots=True, eq=False)
class DepthFrame:
    """A depth map as it came: `counts` (h, w), no unit, and the number the camera gave it."""

    counts: np.ndarray
    number: int


class CameraGone(LinkError):
    """It does not answer any more."""


class Camera:
    """A connected camera; its features by name."""

    def __init__(self, library: Aravis, camera: Any):
        self.library = library
        self.handle = camera
        self._device = library.plain("arv_camera_get_device", camera)

    def call(self, name: str, *given: Any) -> Any:
        """What a function of aravis gives for this camera; raises LinkError."""
        return self.library.call(name, self.handle, *given)

    def has(self, feature: str) -> bool:
        """Whether it has a feature now."""
        return bool(self._ask("arv_device_is_feature_available", feature))

    def number(self, feature: str) -> float:
        """A feature that is a number, whole or not."""
        return float(self._ask("arv_device_get_float_feature_value", feature))

    def whole(self, feature: str) -> int:
        """A feature that is a whole number."""
        return int(self._ask("arv_device_get_integer_feature_value", feature))

    def flag(self, feature: str) -> bool:
        """A feature that is true or false."""
        return bool(self._ask("arv_device_get_boolean_feature_value", feature))

    def choice(self, feature: str) -> str:
        """The name of the entry that a feature is set to."""
        return (self._ask("arv_device_get_string_feature_value", feature) or b"").decode()

    def choose(self, feature: str, entry: str) -> None:
        """Set a feature to one of its entries."""
        self.library.call(
            "arv_device_set_string_feature_value", self._device, feature.encode(), entry.encode()
        )

    def _ask(self, function: str, feature: str) -> Any:
        return self.library.call(function, self._device, feature.encode())


@contextmanager
def open_camera(address: str, serial: str) -> Generator[Camera]:
    """The camera at an address, or of a serial number, or the only one there is.

    Args:
        address: IP address; empty: it is searched for on all networks, which takes a second.
        serial: serial number; empty: whichever it is.

    Raises:
        LinkError: it is not there, not the one that is meant, or somebody else's.
    """
    library = aravis()
    name = address or _find(library, serial)
    camera = library.call("arv_camera_new", name.encode())
    if not camera:
        raise LinkError(ScannerText.NO_CAMERA(found=name))
    try:
        # Aravis takes the first word for a name as well: a camera called like the address.
        is_serial = library.text("arv_camera_get_device_serial_number", camera)
        if serial and is_serial != serial:
            raise LinkError(ScannerText.OTHER_CAMERA(found=is_serial, serial=serial))
        yield Camera(library, camera)
    finally:
        library.plain("g_object_unref", camera)


def _find(library: Aravis, serial: str) -> str:
    """What aravis calls the camera of a serial number, or the only one."""
    library.plain("arv_update_device_list")
    here = [
        tuple(library.text(f"arv_get_device_{what}", index) for what in ("id", "serial_nbr"))
        for index in range(library.plain("arv_get_n_devices"))
    ]
    numbers = ", ".join(number for _, number in here) or "-"
    meant = [name for name, number in here if serial in ("", number)]
    if not meant:
        if serial:
            raise LinkError(ScannerText.NO_SUCH_CAMERA(serial=serial, found=numbers))
        raise LinkError(ScannerText.NO_CAMERA(found=numbers))
    if len(meant) > 1:
        raise LinkError(ScannerText.CAMERAS(count=len(meant), found=numbers))
    return meant[0]


def one_frame(
    camera: Camera, is_triggered: bool, patience: float, glance: Callable[[float], None]
) -> DepthFrame:
    """Take one frame, of what is before the camera after this call.

    The stream, its port and its buffers are new; what comes before the trigger is thrown away,
    by the numbers of its frames as well: what is taken was not taken earlier.

    Args:
        camera: set, and not streaming.
        is_triggered: by software; otherwise the first frame after the start is taken.
        patience: [s] how long the frame is waited for.
        glance: called every 0.1 s with the share of the patience that is over; may raise.

    Raises:
        LinkError: nothing came, what came is not whole, or the camera has gone.
    """
    library = camera.library
    size = camera.call("arv_camera_get_payload")
    if not 0 < size <= 2 * MOST_PIXELS:
        detail = f"a frame of {size} bytes is no depth map of 16 bits"
        raise LinkError(ScannerText.SETTING(detail=detail))
    if library.plain("arv_camera_is_gv_device", camera.handle):
        library.plain("arv_camera_gv_set_stream_options", camera.handle, NO_RAW_SOCKET)
    stream = camera.call("arv_camera_create_stream", None, None)
    try:
        for _ in range(BUFFERS):
            buffer = library.plain("arv_buffer_new_allocate", size)
            library.plain("arv_stream_push_buffer", stream, buffer)
        camera.call("arv_camera_start_acquisition")
        try:
            frame = _wait_for_frame(camera, stream, is_triggered, patience, glance)
        except CameraGone:
            raise  # nobody is there to be told to stop
        except BaseException:
            _stop(camera)
            raise
        _stop(camera)
        return frame
    finally:
        library.plain("g_object_unref", stream)


def _stop(camera: Camera) -> None:
    with suppress(LinkError):  # where it has gone, its heartbeat ends the stream
        camera.call("arv_camera_stop_acquisition")


def _look_after(camera: Camera) -> None:
    try:
        camera.whole("Width")
    except LinkError as error:
        raise CameraGone(ScannerText.GONE(reason=error.message)) from None


def _flush(library: Aravis, stream: Any) -> frozenset[int]:
    """The numbers of frames that came without a trigger, and have been thrown away."""
    numbers: set[int] = set()
    for _ in range(BUFFERS):
        with _pop(library, stream, ARMING) as buffer:
            if not buffer:
                break
            numbers.add(library.plain("arv_buffer_get_frame_id", buffer))
    return frozenset(numbers)


def _wait_for_frame(
    camera: Camera,
    stream: Any,
    is_triggered: bool,
    patience: float,
    glance: Callable[[float], None],
) -> DepthFrame:
    early = _flush(camera.library, stream) if is_triggered else frozenset[int]()
    began = asked = time.monotonic()
    triggers = 0
    while (now := time.monotonic()) - began < patience:
        glance((now - began) / patience)
        if is_triggered and now - began >= triggers * AGAIN:
            camera.call("arv_camera_software_trigger")
            triggers += 1
        if now - asked > ALIVE:
            _look_after(camera)
            asked = now
        with _pop(camera.library, stream, GLANCE) as buffer:
            if buffer and camera.library.plain("arv_buffer_get_frame_id", buffer) not in early:
                return _frame(camera.library, buffer)
    raise LinkError(ScannerText.NO_IMAGE(patience=patience))


@contextmanager
def _pop(library: Aravis, stream: Any, wait: float) -> Generator[Any]:
    """A buffer that has come within `wait` [s], or None; it goes with the block."""
    buffer = library.plain("arv_stream_timeout_pop_buffer", stream, int(wait * 1e6))
    try:
        yield buffer
    finally:
        if buffer:
            library.plain("g_object_unref", buffer)


def _frame(library: Aravis, buffer: Any) -> DepthFrame:
    """What a buffer holds, copied, if it is one whole image of 16 bits."""
    number = library.plain("arv_buffer_get_frame_id", buffer)
    status = library.plain("arv_buffer_get_status", buffer)
    if status != SUCCESS:
        raise _bad_image(number, WRONG.get(status, f"it has the status {status}"))
    parts = library.plain("arv_buffer_get_n_parts", buffer)
    if library.plain("arv_buffer_get_payload_type", buffer) != IMAGE or parts != 1:
        detail = f"{parts} parts and not one: enable the component Range alone"
        raise _bad_image(number, detail)
    form = library.plain("arv_buffer_get_image_pixel_format", buffer)
    if form not in SIXTEEN_BITS:
        known = ", ".join(SIXTEEN_BITS.values())
        raise _bad_image(number, f"its pixel format is {form:#x}, expected one of {known}")
    columns = library.plain("arv_buffer_get_image_width", buffer)
    rows = library.plain("arv_buffer_get_image_height", buffer)
    size = ctypes.c_size_t()
    data = library.plain("arv_buffer_get_image_data", buffer, ctypes.byref(size))
    is_sound = columns > 0 and rows > 0 and columns * rows <= MOST_PIXELS
    if not data or not is_sound or size.value < 2 * columns * rows:
        detail = f"{columns} x {rows} pixels have {2 * columns * rows} bytes, not {size.value}"
        raise _bad_image(number, detail)
    content = ctypes.string_at(data, 2 * columns * rows)
    return DepthFrame(np.frombuffer(content, "<u2").reshape(rows, columns), number)


def _bad_image(number: int, detail: str) -> LinkError:
    return LinkError(ScannerText.IMAGE(number=number, detail=detail))

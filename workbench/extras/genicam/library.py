"""The functions of aravis that a scan needs, called in the shared library itself.

Signatures are those of aravis 0.8 (`arvcamera.h`, `arvdevice.h`, `arvbuffer.h`, `arvstream.h`,
`arvsystem.h`).  Not by GObject introspection: PyGObject has no wheels.
"""

import ctypes
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_uint64
from ctypes import c_void_p as handle
from functools import cache
from typing import Any

from workbench.app.provenance.libraries import Library
from workbench.model.errors import LinkError
from workbench.model.messages.devices import DeviceText, ScannerText

LIBRARY = "libaravis-0.8.so.0"
INSTALLS = "apt-get install libaravis-0.8-0"


class _GError(ctypes.Structure):
    """What functions of GLib say went wrong."""

    _fields_ = (("domain", ctypes.c_uint32), ("code", c_int), ("message", c_char_p))


_ERROR = POINTER(POINTER(_GError))

# What a function gives, and what it takes before the place for its error.
_MAY_FAIL: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "arv_camera_new": (handle, (c_char_p,)),
    "arv_camera_clear_triggers": (None, (handle,)),
    "arv_camera_create_stream": (handle, (handle, handle, handle)),
    "arv_camera_get_device_serial_number": (c_char_p, (handle,)),
    "arv_camera_get_payload": (c_uint, (handle,)),
    "arv_camera_gv_set_packet_size": (None, (handle, c_int)),
    "arv_camera_set_exposure_time": (None, (handle, c_double)),
    "arv_camera_set_trigger": (None, (handle, c_char_p)),
    "arv_camera_software_trigger": (None, (handle,)),
    "arv_camera_start_acquisition": (None, (handle,)),
    "arv_camera_stop_acquisition": (None, (handle,)),
    "arv_device_get_boolean_feature_value": (c_int, (handle, c_char_p)),
    "arv_device_get_float_feature_value": (c_double, (handle, c_char_p)),
    "arv_device_get_integer_feature_value": (ctypes.c_int64, (handle, c_char_p)),
    "arv_device_get_string_feature_value": (c_char_p, (handle, c_char_p)),
    "arv_device_is_feature_available": (c_int, (handle, c_char_p)),
    "arv_device_set_string_feature_value": (None, (handle, c_char_p, c_char_p)),
}
_CANNOT_FAIL: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "arv_update_device_list": (None, ()),
    "arv_get_n_devices": (c_uint, ()),
    "arv_get_device_id": (c_char_p, (c_uint,)),
    "arv_get_device_serial_nbr": (c_char_p, (c_uint,)),
    "arv_camera_is_gv_device": (c_int, (handle,)),
    "arv_camera_gv_set_stream_options": (None, (handle, c_int)),
    "arv_camera_get_device": (handle, (handle,)),
    "arv_buffer_new_allocate": (handle, (c_size_t,)),
    "arv_buffer_get_status": (c_int, (handle,)),
    "arv_buffer_get_payload_type": (c_int, (handle,)),
    "arv_buffer_get_n_parts": (c_uint, (handle,)),
    "arv_buffer_get_frame_id": (c_uint64, (handle,)),
    "arv_buffer_get_image_width": (c_int, (handle,)),
    "arv_buffer_get_image_height": (c_int, (handle,)),
    "arv_buffer_get_image_pixel_format": (ctypes.c_uint32, (handle,)),
    "arv_buffer_get_image_data": (handle, (handle, POINTER(c_size_t))),
    "arv_stream_push_buffer": (None, (handle, handle)),
    "arv_stream_timeout_pop_buffer": (handle, (handle, c_uint64)),
    "g_object_unref": (None, (handle,)),
    "g_error_free": (None, (POINTER(_GError),)),
}


class Aravis:
    """The library: `call` for what may fail, `plain` for what cannot."""

    def __init__(self, library: ctypes.CDLL):
        self._functions: dict[str, Any] = {}
        for name, (gives, takes) in _CANNOT_FAIL.items():
            self._declare(library, name, gives, takes)
        for name, (gives, takes) in _MAY_FAIL.items():
            self._declare(library, name, gives, (*takes, _ERROR))

    def _declare(self, library: ctypes.CDLL, name: str, gives: Any, takes: tuple[Any, ...]) -> None:
        function = getattr(library, name)  # those of GLib come with it
        function.restype, function.argtypes = gives, takes
        self._functions[name] = function

    def plain(self, name: str, *given: Any) -> Any:
        """What a function gives that has no error to tell."""
        return self._functions[name](*given)

    def call(self, name: str, *given: Any) -> Any:
        """What a function gives.

        Raises:
            LinkError: it says that it failed, in its words.
        """
        error = POINTER(_GError)()
        result = self._functions[name](*given, byref(error))
        if error:
            said = (error.contents.message or b"").decode("utf-8", "replace")
            self._functions["g_error_free"](error)
            raise LinkError(ScannerText.SETTING(detail=said or f"{name} failed"))
        return result

    def text(self, name: str, *given: Any) -> str:
        """A text that a function of either kind gives; empty where it gives none."""
        ask = self.call if name in _MAY_FAIL else self.plain
        found = ask(name, *given)
        return (found or b"").decode("utf-8", "replace")


@cache
def aravis() -> Aravis:
    """The library, loaded once.

    Raises:
        LinkError: it is not installed, or not of the version 0.8 that has these functions.
    """
    try:
        return Aravis(ctypes.CDLL(LIBRARY))
    except OSError:
        raise LinkError(DeviceText.LIBRARY(library=LIBRARY, command=INSTALLS)) from None
    except AttributeError as error:
        raise LinkError(DeviceText.LIBRARY_VERSION(library=LIBRARY, reason=str(error))) from None


def libraries() -> tuple[Library, ...]:
    """What `doctor` reports."""
    return (Library(LIBRARY, "the scanner genicam", is_installed(), INSTALLS),)


def is_installed() -> bool:
    """Whether scans can be taken by it here."""
    try:
        aravis()
    except LinkError:
        return False
    return True

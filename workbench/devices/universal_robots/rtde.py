"""RTDE as a controller speaks it: packets, variables with their types, recipes.

Source: Universal Robots, "Real-Time Data Exchange (RTDE) Guide", protocol version 2.
"""

import struct
from collections.abc import Mapping, Sequence
from typing import Any

VERSION, CONTROLLER, DATA = 86, 118, 85
OUTPUTS, INPUTS, START, PAUSE = 79, 73, 83, 80

HEADER = struct.Struct(">HB")

RTDE_PORT = 30004
"""The foreign client chooses no other."""

STOPPING, STOPPED, PLAYING, PAUSING, PAUSED, RESUMING = range(6)
"""Values of `runtime_state`."""

STANDS = (STOPPED, PAUSED)
"""Those in which no program moves the robot; while it stops or pauses it still brakes."""

RUNNING_MODE = 7
"""The value of `robot_mode` in which a robot can move."""

ALIVE = 18
"""Input register that has to be written while the robot moves."""

PROGRESS = 12
"""Output register with the ticket of the program, and the number of the leg that runs."""

TICKETS = 100
"""Number of values of that register for each ticket, more than a plan has legs."""

REFUSED = TICKETS - 1
"""The last of them: this program has come once more, and has not begun again."""

BEGUN = (13, 14, 15, 16)
"""Output registers with the tickets of the programs that have begun last, the newest first."""

LONGEST_PACKET = 4096
"""[bytes] A longer packet is none of ours."""

FORMATS: Mapping[str, str] = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
}

_NAMED: Mapping[str, str] = {
    "timestamp": "DOUBLE",
    "actual_q": "VECTOR6D",
    "robot_mode": "INT32",
    "safety_status_bits": "UINT32",
    "runtime_state": "UINT32",
    "speed_slider_mask": "UINT32",
    "speed_slider_fraction": "DOUBLE",
    "standard_digital_output_mask": "UINT8",
    "standard_digital_output": "UINT8",
    "configurable_digital_output_mask": "UINT8",
    "configurable_digital_output": "UINT8",
    "tool_digital_output_mask": "UINT8",
    "tool_digital_output": "UINT8",
    "standard_analog_output_mask": "UINT8",
    "standard_analog_output_type": "UINT8",
    "standard_analog_output_0": "DOUBLE",
    "standard_analog_output_1": "DOUBLE",
}

_KINDS = {"int": "INT32", "double": "DOUBLE", "bit": "BOOL"}


def type_of(name: str) -> str:
    """The type of a variable; NOT_FOUND where the twin has none of that name."""
    if name in _NAMED:
        return _NAMED[name]
    way, _, rest = name.partition("_")
    kind, _, _ = rest.partition("_register_")
    return _KINDS.get(kind, "NOT_FOUND") if way in ("input", "output") else "NOT_FOUND"


def packet(kind: int, content: bytes = b"") -> bytes:
    """A packet with its header."""
    return HEADER.pack(HEADER.size + len(content), kind) + content


def pack_values(names: Sequence[str], values: Mapping[str, Any]) -> bytes:
    """Values in the order of a recipe; what is not among them is zero."""
    data = b""
    for name in names:
        form = struct.Struct(">" + FORMATS[type_of(name)])
        value = values.get(name)
        if value is None:
            data += bytes(form.size)
        else:
            data += form.pack(*value) if isinstance(value, tuple) else form.pack(value)
    return data


def unpack_values(names: Sequence[str], data: bytes) -> dict[str, Any]:
    """The values of a recipe, one each.

    Raises:
        struct.error: there are not as many bytes as the recipe has.
    """
    form = struct.Struct(">" + "".join(FORMATS[type_of(name)] for name in names))
    return dict(zip(names, form.unpack(data), strict=True))

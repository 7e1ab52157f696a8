"""The state that a controller reports to any client: one JSON object a line."""

import json
import math
from collections.abc import Iterator
from typing import Any

from workbench.devices.abb_socket.connecting import connect
from workbench.model.errors import LinkError, ProtocolError
from workbench.model.messages.devices import DeviceText
from workbench.model.release import RobotState
from workbench.plugins.progress import Cancelled, never

LONGEST_LINE = 64 * 1024

LONGEST_TEXT = 300
"""Characters of a fault that are reported."""

MOST_COUNTED = 2**23
"""RAPID counts in numbers of 32 bits with a point: above this some are left out."""


def watch_state(host: str, port: int, cancelled: Cancelled = never) -> Iterator[RobotState]:
    """The states that a controller reports, as they come: one JSON object a line.

    Raises:
        LinkError: nobody answers, or the report broke off.
        ProtocolError: a line is not a state.
    """
    with connect(host, port, DeviceText.NO_STATE) as link:
        heard = b""
        while not cancelled():
            try:
                data = link.recv(65536)
            except TimeoutError:
                continue
            except OSError as error:
                broken = DeviceText.STATE_BROKEN(reason=error.strerror or str(error))
                raise LinkError(broken) from None
            if not data:
                raise LinkError(DeviceText.STATE_CLOSED())
            heard += data
            *lines, heard = heard.split(b"\n")
            if len(heard) > LONGEST_LINE:
                raise ProtocolError("a state report is too long")
            for line in lines:
                yield _state(line)


def _state(line: bytes) -> RobotState:
    try:
        report: dict[str, Any] = json.loads(line)
        return RobotState(
            joints={_text(a): tuple(map(_finite, q)) for a, q in report["joints"].items()},
            openings={_text(a): _finite(v) for a, v in report["openings"].items()},
            moving=_text(report["moving"]),
            received=_count(report["received"]),
            placed=_count(report["placed"]),
            fault=_text(report["fault"]),
        )
    except (ValueError, LookupError, TypeError, AttributeError, OverflowError) as error:
        raise ProtocolError(f"{line[:60]!r} is no state report ({error})") from None
    except RecursionError:
        raise ProtocolError(f"{line[:60]!r} is no state report: nested too deeply") from None


def _text(value: Any) -> str:
    """A text that can be recorded; a fault is one, whatever letters it comes with."""
    return "".join(letter if letter.isprintable() else "?" for letter in str(value)[:LONGEST_TEXT])


def _count(value: Any) -> int:
    number = _finite(value)
    if not 0 <= number <= MOST_COUNTED or number != int(number):
        raise ValueError(f"{number:.6g} counts nothing")
    return int(number)


def _finite(value: Any) -> float:
    # Texts and flags would be taken by `float` as well.
    if type(value) not in (int, float):
        raise ValueError(f"{value!r:.40} is not a number")
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{number} is not a finite number")
    return number

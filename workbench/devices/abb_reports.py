"""What a controller reports of itself to whoever wants to know: one JSON object a line."""

import json
import socket
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from workbench.model.errors import LinkError, ProtocolError

CONNECT_SECONDS = 3.0
POLL_SECONDS = 0.05
LONGEST_LINE = 64 * 1024


@dataclass(frozen=True, slots=True)
class ControllerState:
    """What a controller reports of itself.

    `joints` [rad], chain order, and `openings` [m] by arm; `moving` the arm in motion or "";
    `received` counts messages and `placed` the parts put down since it started.  `fault` is
    empty when there is none.
    """

    joints: dict[str, tuple[float, ...]]
    openings: dict[str, float]
    moving: str
    received: int
    placed: int
    fault: str


def watch_state(
    host: str, port: int, cancelled: Callable[[], bool] = lambda: False
) -> Iterator[ControllerState]:
    """The states that a controller reports, as they come: one JSON object a line.

    Raises:
        LinkError: nobody answers, or the report broke off.
        ProtocolError: a line is not a state.
    """
    try:
        link = socket.create_connection((host, port), CONNECT_SECONDS)
    except OSError as error:
        raise LinkError(
            f"no controller reports its state at {host}:{port} ({error.strerror or error})"
        ) from None
    with link:
        link.settimeout(POLL_SECONDS)
        heard = b""
        while not cancelled():
            try:
                data = link.recv(65536)
            except TimeoutError:
                continue
            except OSError as error:
                raise LinkError(f"the state report broke off: {error.strerror or error}") from None
            if not data:
                raise LinkError("the controller closed its state report")
            heard += data
            *lines, heard = heard.split(b"\n")
            if len(heard) > LONGEST_LINE:
                raise ProtocolError("a state report is too long")
            for line in lines:
                yield _state(line)


def _state(line: bytes) -> ControllerState:
    try:
        report: dict[str, Any] = json.loads(line)
        return ControllerState(
            joints={str(a): tuple(float(v) for v in q) for a, q in report["joints"].items()},
            openings={str(a): float(v) for a, v in report["openings"].items()},
            moving=str(report["moving"]),
            received=int(report["received"]),
            placed=int(report["placed"]),
            fault=str(report["fault"]),
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ProtocolError(f"{line[:60]!r} is no state report ({error})") from None

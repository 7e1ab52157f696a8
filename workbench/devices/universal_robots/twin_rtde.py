"""RTDE of the simulated controller: recipes are agreed on, states go out and registers come."""

import socket
import struct
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from workbench.devices.universal_robots import rtde

SHORTEST = 0.01
"""Shortest interval between two states that a client gets [s]."""

POLL_EVERY = 0.05

Heard = Callable[[socket.socket, int], bytes | None]
"""Reads at most this many bytes from a client: empty after a timeout, None when it has closed."""


class RtdePort:
    """What is done with each client.

    Args:
        state: the variables of now, by name.
        written: takes those that a client writes.
        heard: reads from a client.
    """

    def __init__(
        self,
        state: Callable[[], Mapping[str, Any]],
        written: Callable[[dict[str, Any]], None],
        heard: Heard,
    ) -> None:
        self._state, self._written, self._heard = state, written, heard

    def serve(self, client: socket.socket) -> None:
        """Answer one client to its end."""
        outputs: list[str] = []
        recipes: list[list[str]] = []
        period, due, heard, is_started = 0.0, 0.0, b"", False
        while True:
            if is_started and time.monotonic() >= due:
                due = time.monotonic() + period
                data = b"\x01" + rtde.pack_values(outputs, self._state())
                client.sendall(rtde.packet(rtde.DATA, data))
            client.settimeout(
                max(min(due - time.monotonic(), POLL_EVERY), 1e-3) if is_started else POLL_EVERY
            )
            data = self._heard(client, rtde.LONGEST_PACKET)
            if data is None:
                return
            heard += data
            while len(heard) >= rtde.HEADER.size:
                size, kind = rtde.HEADER.unpack_from(heard)
                if not rtde.HEADER.size <= size <= rtde.LONGEST_PACKET:
                    return
                if len(heard) < size:
                    break
                content, heard = heard[rtde.HEADER.size : size], heard[size:]
                if kind == rtde.VERSION:
                    client.sendall(rtde.packet(rtde.VERSION, b"\x01"))
                elif kind == rtde.CONTROLLER:
                    client.sendall(rtde.packet(rtde.CONTROLLER, struct.pack(">IIII", 5, 11, 0, 0)))
                elif kind == rtde.OUTPUTS:
                    (rate,) = struct.unpack_from(">d", content)
                    period, outputs = max(1 / rate, SHORTEST), _names(content[8:])
                    client.sendall(rtde.packet(rtde.OUTPUTS, b"\x01" + _types(outputs)))
                elif kind == rtde.INPUTS:
                    recipes.append(_names(content))
                    number = bytes([len(recipes)])
                    client.sendall(rtde.packet(rtde.INPUTS, number + _types(recipes[-1])))
                elif kind in (rtde.START, rtde.PAUSE):
                    is_started = kind == rtde.START
                    client.sendall(rtde.packet(kind, b"\x01"))
                elif kind == rtde.DATA:
                    self._written(rtde.unpack_values(recipes[content[0] - 1], content[1:]))


def _names(content: bytes) -> list[str]:
    return [name for name in content.decode("ascii").split(",") if name]


def _types(names: Sequence[str]) -> bytes:
    return ",".join(rtde.type_of(name) for name in names).encode()

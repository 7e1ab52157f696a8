"""A controller's twin: EGM for each arm, with the module in RAPID that takes orders, on a clock.

It reports each arm every 4 ms of its own time to the sensor's port, and to another one for states.
An arm follows its last reference through a filter of first order, no faster than its joints can.
Where nothing is answered it stays there, and after `COMM_TIMEOUT` EGM stops, as in RobotWare 7.

Faster than in real time it waits a little for each answer, so that nobody has to be as fast.
"""

import itertools
import json
import secrets
import select
import socket
import threading
import time
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

from workbench.devices.abb_egm import wire
from workbench.devices.abb_egm.twin_arm import TwinArm
from workbench.model.cell import Cell
from workbench.model.errors import InputError, LinkError
from workbench.plugins.robot_link import Simulation

FAULTS = ("lost", "cut", "jitter", "twice", "motors-off", "stuck")
"""By word: every third report is lost; all are; they are held up and come at once; one comes
twice; the motors go off; the arm stays where it is."""

HELD_UP = 60
"""[reports] 240 ms."""

LOCKSTEP = 0.5
"""[s] Timeout of an answer, when the twin runs faster than real time."""

OTHER_ARM_WAIT = 0.01
"""[s] Timeout of one arm's answer after another's has come.  A plan that has ended for one arm is
answered only for the other, so this must not count as silence."""

STATES = 25
"""[reports] One of this many goes to the port for states, where the controller streams slowly."""

FREE_PORTS = range(20_000, 32_000)
"""Ports that no system gives to a socket by itself, and few programs listen on."""

_offsets = itertools.count(secrets.randbelow(len(FREE_PORTS)))

INTO = 10
"""[reports] Delay of a fault after the start of its leg."""


class SimulatedEgm:
    """The controller of a cell, for as long as it runs."""

    def __init__(self, cell: Cell, simulation: Simulation) -> None:
        """Open its sockets.

        Args:
            cell: whose arms stand at home.
            simulation: at `host` the sensor listens, and from there this sends.  `port` is the
                sensor's for the first arm, `state_port` that for states; the next arm has the next.
                An arm that gets no answer for `home_after` [s] of its time goes home.  A fault is
                `WORD@LEG`, from that leg on.  `record` takes every order.

        Raises:
            InputError: a fault is not known, or the address is none of this machine.
        """
        self._faults = dict(_fault(text) for text in simulation.faults)
        self._host, self._speed = simulation.host, simulation.speed
        self._record, self._trace = simulation.record, simulation.trace
        count = len(cell.arms)
        self.port = simulation.port or free_ports(self._host, count)
        self.state_port = simulation.state_port or free_ports(self._host, count)
        while abs(self.port - self.state_port) < count:
            self.state_port = free_ports(self._host, count)
        self.arms = [TwinArm(cell, arm, simulation.home_after) for arm in cell.arms]
        self._over = threading.Event()
        self._tick, self._is_cut = 0, False
        self._into = [0] * count
        self._held: list[bytes] = []
        self._sockets: list[socket.socket] = []
        ports = {
            first_port + k for first_port in (self.port, self.state_port) for k in range(count)
        }
        for _ in self.arms:
            self._sockets.append(socket_beside(self._host, ports))

    def stop(self) -> None:
        """End `run`."""
        self._over.set()

    def run(self) -> None:
        """Report, and follow what is answered, until somebody stops it."""
        due = time.monotonic()
        try:
            while not self._over.is_set():
                self._tick += 1
                awaited = [k for k, arm in enumerate(self.arms) if self._report(k, arm)]
                due = max(due + wire.PERIOD_MS / 1000 / self._speed, time.monotonic() - 1.0)
                self._listen(awaited, due)
        finally:
            for connection in self._sockets:
                connection.close()

    def _report(self, k: int, arm: TwinArm) -> bool:
        """Move an arm and say where it is; whether an answer can be expected."""
        arm.go()
        self._into[k] = self._into[k] + 1 if arm.leg else 0
        data = wire.feedback_bytes(arm.report(self._tick * wire.PERIOD_MS % (1 << 32)))
        if self._tick % STATES == 1:
            self._say(k, data, self.state_port + k)
            self._draw(arm)
        out = self._spoilt(k, arm, data)
        for datagram in out:
            self._say(k, datagram, self.port + k)
        return bool(out) and arm.is_prompt

    def _say(self, k: int, data: bytes, port: int) -> None:
        with suppress(OSError):  # nobody listens yet
            self._sockets[k].sendto(data, (self._host, port))

    def _spoilt(self, k: int, arm: TwinArm, data: bytes) -> list[bytes]:
        """What becomes of a report: usually itself."""
        for word, leg in list(self._faults.items()):
            if arm.leg < max(leg, 1) or self._into[k] < INTO:
                continue
            match word:
                case "cut":
                    del self._faults[word]
                    self._is_cut = True
                case "lost":
                    return [] if self._tick % 3 == 0 else [data]
                case "motors-off":
                    arm.motors = wire.MOTORS_OFF
                case "stuck":
                    arm.is_stuck = True
                case "twice":
                    del self._faults[word]
                    return [data, data]
                case _:
                    self._held.append(data)
                    if len(self._held) < HELD_UP:
                        return []
                    del self._faults[word]
                    return self._held
        return [] if self._is_cut else [data]

    def _listen(self, awaited: list[int], due: float) -> None:
        """Take answers: until the next report is due, or as many as are awaited."""
        if self._speed > 1.0:
            due = time.monotonic() + (LOCKSTEP if awaited else 0.001)
        missing = set(awaited)
        while not self._over.is_set():
            left = due - time.monotonic()
            for readable in select.select(self._sockets, [], [], max(left, 0.0))[0]:
                k = self._sockets.index(readable)
                self._take(k, readable)
                if self._speed > 1.0 and k in missing:
                    due = min(due, time.monotonic() + OTHER_ARM_WAIT)
                missing.discard(k)
            if left <= 0.0 or (self._speed > 1.0 and awaited and not missing):
                for k in missing:
                    self.arms[k].is_prompt = False
                return

    def _take(self, k: int, connection: socket.socket) -> None:
        # What is no answer of a sensor is no fault of the controller.
        with suppress(OSError, LinkError):
            arm = self.arms[k]
            if arm.take(wire.read_reference(connection.recv(wire.LONGEST_MESSAGE))):
                _append(self._record, {"arm": arm.arm.name, "order": arm.orders[-1]})

    def _draw(self, arm: TwinArm) -> None:
        q = arm.arm.from_axes(arm.axes).tolist()
        _append(self._trace, {"at": time.time(), "arm": arm.arm.name, "q": q})


def _append(file: Path | None, values: dict[str, object]) -> None:
    if file is not None:
        with file.open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(values) + "\n")


def _fault(text: str) -> tuple[str, int]:
    word, _, leg = text.partition("@")
    if word not in FAULTS or (leg and not (leg.isdecimal() and int(leg))):
        raise InputError(f"fault {text!r:.40}: one of {', '.join(FAULTS)} is expected, with @LEG")
    return word, int(leg or 1)


def _socket(host: str, port: int = 0) -> socket.socket:
    stream_response = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        stream_response.bind((host, port))
    except OSError as error:
        stream_response.close()
        reason = error.strerror or error
        raise InputError(f"{host}:{port} cannot be sent from: {reason}") from None
    return stream_response


def socket_beside(host: str, ports: Collection[int]) -> socket.socket:
    """A UDP socket at any port but these: who sends there must not hear himself.

    Raises:
        InputError: the address is none of this machine.
    """
    while True:
        connection = _socket(host)
        if connection.getsockname()[1] not in ports:
            return connection
        connection.close()


def free_ports(host: str, count: int) -> int:
    """A UDP port that is free, and so are the next ones, `count` in all.

    They lie below the ports that systems give to sockets without a number (RFC 6335: from 49152,
    Linux: from 32768), so that no socket that is opened meanwhile takes one of them.  Nobody may
    listen yet where a twin sends to, so ports that were given out before are not free either.

    Raises:
        InputError: there are none.
    """
    for _ in range(1000):
        port = FREE_PORTS.start + next(_offsets) * count % (len(FREE_PORTS) - count)
        with suppress(InputError):
            for k in range(count):
                _socket(host, port + k).close()
            return port
    raise InputError(f"{host} has no {count} free ports")

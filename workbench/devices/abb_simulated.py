"""A simulated robot controller: speaks the protocol strictly, moves in time, reports its state."""

import json
import logging
import select
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from workbench.devices.abb_messages import REQUEST, Commands, Message
from workbench.model.cell import Arm, Cell
from workbench.model.errors import LinkError, ProtocolError
from workbench.model.geometry import Floats

log = logging.getLogger(__name__)

TICK = 0.02
"""[s] Between two steps of a motion."""

REPORT = 0.05
"""[s] Between two state reports while something changes."""

MOST_WATCHERS = 32
ANSWER_SECONDS = 30.0

IN_THE_HAND = "the client left in the middle of a sequence"


class SimulatedController:
    """Two TCP servers: one takes motion, one client at a time; the other reports state to many.

    Lifetime: the ports are open from construction; `run` serves until `stop` is called, and
    ends within a tick.
    Concurrency: `run` owns the motion; reports go out from a thread of their own, so a slow
    watcher never holds up the robot.  `stop` may be called from anywhere.
    """

    def __init__(
        self,
        cell: Cell,
        host: str = "127.0.0.1",
        port: int = 0,
        state_port: int = 0,
        *,
        speed: float = 1.0,
        record: Path | None = None,
    ) -> None:
        """Open the ports.

        Args:
            cell: whose arms it has.
            host: address to listen on.
            port: for motion; 0 takes any free one.
            state_port: for state reports; 0 takes any free one.
            speed: 1 is real time, 20 twenty times as fast.
            record: file to which every configuration that arrives is appended as a JSON line.

        Raises:
            LinkError: a port is taken.
        """
        self._cell = cell
        self._speed = speed
        self._record = record
        self._stop = threading.Event()
        self._lock = threading.Lock()
        self._q = {arm.name: np.array(arm.home) for arm in cell.arms}
        self._opening = {arm.name: 0.0 for arm in cell.arms}
        self._holds: dict[str, bool] = {}
        self._moving, self._fault = "", ""
        self._received, self._placed = 0, 0
        self._motion = _listening(host, port)
        try:
            self._states = _listening(host, state_port)
        except LinkError:
            self._motion.close()
            raise

    @property
    def port(self) -> int:
        """Where motion is taken."""
        return self._motion.getsockname()[1]

    @property
    def state_port(self) -> int:
        """Where state is reported."""
        return self._states.getsockname()[1]

    def state(self) -> dict[str, Any]:
        """The present state as it is reported."""
        with self._lock:
            return {
                "joints": {arm: q.tolist() for arm, q in self._q.items()},
                "openings": dict(self._opening),
                "moving": self._moving,
                "received": self._received,
                "placed": self._placed,
                "fault": self._fault,
            }

    def stop(self) -> None:
        """End `run`."""
        self._stop.set()

    def run(self) -> None:
        """Serve clients one after the other until `stop`."""
        reporter = threading.Thread(target=self._report, name="state reports", daemon=True)
        reporter.start()
        try:
            while not self._stop.is_set():
                if select.select([self._motion], [], [], TICK)[0]:
                    client, address = self._motion.accept()
                    log.info("client %s connected", address)
                    with client:
                        self._serve(client)
        finally:
            self._stop.set()
            reporter.join()
            self._motion.close()
            self._states.close()

    # -- one client ------------------------------------------------------------------------

    def _serve(self, client: socket.socket) -> None:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._set(_fault="")
        commands = Commands(self._cell)
        last: Message | None = None
        try:
            while not self._stop.is_set():
                client.sendall(REQUEST)
                message = self._next(client, commands)
                if message is None:
                    break
                self._execute(client, message, last)
                last = message
        except (ProtocolError, LinkError, OSError) as error:
            log.warning("fault: %s", error)
            self._set(_fault=str(error), _moving="")

    def _next(self, client: socket.socket, commands: Commands) -> Message | None:
        """The next message; None when the client leaves between two sequences."""
        until = time.monotonic() + ANSWER_SECONDS
        while not self._stop.is_set():
            self._refuse_others()
            if not select.select([client], [], [], TICK)[0]:
                # Between sequences a client may wait as long as it likes.
                if time.monotonic() > until and not commands.is_between:
                    raise LinkError(f"no message for {ANSWER_SECONDS:.0f} s within a sequence")
                continue
            data = client.recv(256)
            if not data:
                if commands.is_between:
                    return None
                raise LinkError(IN_THE_HAND)
            message = commands.hear(data)
            if message is not None:
                return message
        return None

    def _refuse_others(self) -> None:
        if select.select([self._motion], [], [], 0)[0]:
            other, address = self._motion.accept()
            log.warning("client %s refused: another one is connected", address)
            other.close()

    def _execute(self, client: socket.socket, message: Message, last: Message | None) -> None:
        arm = self._cell.arm(message.arm)
        self._set(_received=self._received + 1)
        if self._record is not None and message.q is not None:
            line = {"arm": message.arm, "kind": message.kind, "q": np.asarray(message.q).tolist()}
            with self._record.open("a") as file:
                file.write(json.dumps(line) + "\n")
        match message.kind:
            case "start":
                self._holds[arm.name] = False
            case "in" | "out":
                if message.kind == "out" and last is not None and last.kind == "in":
                    self._grip(arm, 0.0)
                    self._holds[arm.name] = True
                elif message.kind == "in" and last is not None and last.kind == "start":
                    self._grip(arm, arm.tool.stroke[1])
                if message.q is not None:
                    self._move(client, arm, np.asarray(message.q))
            case "stop":
                if self._holds.pop(arm.name, False):
                    self._grip(arm, arm.tool.stroke[1])
                    self._set(_placed=self._placed + 1)

    def _grip(self, arm: Arm, opening: float) -> None:
        with self._lock:
            self._opening[arm.name] = opening

    def _move(self, client: socket.socket, arm: Arm, goal: Floats) -> None:
        """All joints linearly, as fast as the slowest of them may."""
        _, _, velocity = self._cell.robot.limits(arm.joints)
        start = self._q[arm.name]
        seconds = float((np.abs(goal - start) / (velocity * self._cell.policy.speed)).max())
        seconds /= self._speed
        began = time.monotonic()
        self._set(_moving=arm.name)
        while (passed := time.monotonic() - began) < seconds and not self._stop.is_set():
            with self._lock:
                self._q[arm.name] = start + (goal - start) * (passed / seconds)
            # A client that has gone must not be obeyed to the end of its last word.
            if select.select([client], [], [], min(TICK, seconds - passed))[0]:
                if not client.recv(1, socket.MSG_PEEK):
                    raise LinkError(IN_THE_HAND)
                raise ProtocolError("a message came before it was asked for")
        with self._lock:
            self._q[arm.name] = goal
        self._set(_moving="")

    def _set(self, **fields: Any) -> None:
        with self._lock:
            for name, value in fields.items():
                setattr(self, name, value)

    # -- state reports ---------------------------------------------------------------------

    def _report(self) -> None:
        watchers: list[socket.socket] = []
        told = b""
        while not self._stop.is_set():
            fresh = select.select([self._states], [], [], REPORT)[0]
            line = json.dumps(self.state()).encode() + b"\n"
            if fresh:
                watcher, _ = self._states.accept()
                watcher.setblocking(False)
                watchers.append(watcher)
                if len(watchers) > MOST_WATCHERS or not _told(watcher, line):
                    watchers.remove(watcher)
                    watcher.close()
            if line != told:
                for watcher in [w for w in watchers if not _told(w, line)]:
                    watchers.remove(watcher)
                    watcher.close()
                told = line
        for watcher in watchers:
            watcher.close()


def _told(watcher: socket.socket, line: bytes) -> bool:
    """Whether a watcher took a whole line; one that is too slow for it is let go."""
    with suppress(OSError):
        return watcher.send(line) == len(line)
    return False


def _listening(host: str, port: int) -> socket.socket:
    try:
        return socket.create_server((host, port))
    except OSError as error:
        raise LinkError(f"cannot listen on {host}:{port}: {error.strerror or error}") from None


def serve(
    cell: Cell,
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    state_port: int = 0,
    speed: float = 1.0,
    record: Path | None = None,
    ready: Callable[[SimulatedController], None] = lambda controller: None,
) -> None:
    """Run a simulated controller in this thread until it is stopped; see `SimulatedController`.

    `ready` is called once the ports are open.
    """
    controller = SimulatedController(cell, host, port, state_port, speed=speed, record=record)
    ready(controller)
    controller.run()

"""A simulated robot controller: speaks both protocols, moves in time, reports its state."""

import json
import logging
import select
import socket
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from workbench.devices.abb_simulated.body import SimulatedBody
from workbench.devices.abb_simulated.faults import Faults, parse_fault
from workbench.devices.abb_simulated.serve_program import TICK, ProgramClient, ServedRobot
from workbench.devices.abb_simulated.serve_requests import RequestClient
from workbench.devices.abb_socket.messages import REQUEST
from workbench.model.cell import Cell
from workbench.model.errors import LinkError
from workbench.plugins.robot_link import USUAL, LinkPatience, Simulation

log = logging.getLogger(__name__)

REPORT = 0.05
"""[s] Between two state reports while something changes."""

HOMING = 1.0
"""[rad/s] At speed 1, of the joint with the longest way home."""

MOST_WATCHERS = 32


class SimulatedController:
    """Two TCP servers: one takes motion, one client at a time; the other reports state to many.

    The first byte of a client says which protocol it speaks: `abb-socket/2` begins with a digit.

    Lifetime: the ports are open from construction; `run` serves until `stop` is called, and
    ends within a tick.
    Concurrency: `run` owns the motion; reports go out from a thread of their own, so a slow
    watcher never holds up the robot.  `stop` may be called from anywhere.
    """

    def __init__(
        self,
        cell: Cell,
        simulation: Simulation,
        *,
        paces: Mapping[str, float] | None = None,
        patience: LinkPatience = USUAL,
    ) -> None:
        """Open the ports.

        Args:
            cell: whose arms it has.
            simulation: where it listens and how it moves.  To `record` it appends every
                configuration that arrives, to `trace` every state that the arms go through, as
                JSON lines.  Each of the faults happens once.
            paces: arms that run legs slower than planned, or faster, where they may; 1 is
                as planned.
            patience: how long clients are waited for.

        Raises:
            InputError: a fault is not known.
            LinkError: a port is taken.
        """
        faults = [parse_fault(text) for text in simulation.faults]
        self._patience = patience
        self._stop = threading.Event()
        self._body = SimulatedBody(
            cell, simulation.speed, simulation.record, simulation.trace, Faults(faults)
        )
        self._station = ServedRobot(
            self._body, self._stop.is_set, self._refuse_others, paces or {}, patience=patience
        )
        self._home_after = simulation.home_after
        self._motion = _listening(simulation.host, simulation.port)
        try:
            self._states = _listening(simulation.host, simulation.state_port)
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

    @property
    def tools(self) -> dict[str, str]:
        """The tool that each arm carries, empty for a bare flange."""
        return {arm.name: arm.tool.name for arm in self._body.cell.arms}

    def state(self) -> dict[str, Any]:
        """The present state as it is reported."""
        return self._body.state()

    def stop(self) -> None:
        """End `run`."""
        self._stop.set()

    def run(self) -> None:
        """Serve clients one after the other until `stop`."""
        reporter = threading.Thread(target=self._report, name="state reports", daemon=True)
        reporter.start()
        left_at = time.monotonic()
        try:
            while not self._stop.is_set():
                if select.select([self._motion], [], [], TICK)[0]:
                    client, address = self._motion.accept()
                    log.info("client %s connected", address)
                    with client:
                        self._serve(client)
                    left_at = time.monotonic()
                elif time.monotonic() > left_at + self._home_after and not self._body.is_home():
                    self._body.step_home(HOMING * TICK * self._body.speed)
        finally:
            self._stop.set()
            reporter.join()
            self._motion.close()
            self._states.close()

    # -- one client ------------------------------------------------------------------------

    def _serve(self, client: socket.socket) -> None:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._body.halt("")
        try:
            client.sendall(REQUEST)
            first = self._first_byte(client)
            if first:
                talk = ProgramClient if first.isdigit() else RequestClient
                talk(client, self._station).serve()
        except (LinkError, OSError) as error:
            log.warning("fault: %s", error)
            self._body.halt(str(error))

    def _first_byte(self, client: socket.socket) -> bytes:
        """By which the protocol is known; empty when the client leaves before, or stays silent."""
        until = self._patience.clock() + self._patience.answer
        while not self._stop.is_set() and self._patience.clock() < until:
            self._refuse_others()
            if select.select([client], [], [], TICK)[0]:
                return client.recv(1, socket.MSG_PEEK)
        return b""

    def _refuse_others(self) -> None:
        if select.select([self._motion], [], [], 0)[0]:
            other, address = self._motion.accept()
            log.warning("client %s refused: another one is connected", address)
            other.close()

    # -- state reports ---------------------------------------------------------------------

    def _report(self) -> None:
        watchers: list[socket.socket] = []
        last_line = b""
        while not self._stop.is_set():
            ready = select.select([self._states, *watchers], [], [], REPORT)[0]
            for watcher in [w for w in watchers if w in ready and _has_left(w)]:
                watchers.remove(watcher)
                watcher.close()
            line = json.dumps(self.state()).encode() + b"\n"
            if self._states in ready:
                watcher, _ = self._states.accept()
                watcher.setblocking(False)
                watchers.append(watcher)
                if len(watchers) > MOST_WATCHERS or not _send_line(watcher, line):
                    watchers.remove(watcher)
                    watcher.close()
            if line != last_line:
                for watcher in [w for w in watchers if not _send_line(w, line)]:
                    watchers.remove(watcher)
                    watcher.close()
                last_line = line
        for watcher in watchers:
            watcher.close()


def _has_left(watcher: socket.socket) -> bool:
    """Whether a watcher that can be read from has closed; nothing that one says counts."""
    try:
        return watcher.recv(4096) == b""
    except OSError:
        return True


def _send_line(watcher: socket.socket, line: bytes) -> bool:
    """Whether a watcher took a whole line; one that is too slow for it is let go."""
    with suppress(OSError):
        return watcher.send(line) == len(line)
    return False


def _listening(host: str, port: int) -> socket.socket:
    try:
        return socket.create_server((host, port))
    except OSError as error:
        raise LinkError(f"cannot listen on {host}:{port}: {error.strerror or error}") from None

"""A controller of Universal Robots, simulated: it takes programs, moves in time, and can fail.

It has the ports of the real one, since the foreign client chooses none of them but that for
programs: RTDE on 30004, the dashboard on 29999.  Several live on one machine at addresses of their
own, 127.x.y.z.
"""

import json
import math
import socket
import struct
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

from workbench.devices.universal_robots import rtde
from workbench.devices.universal_robots.following import Following
from workbench.devices.universal_robots.twin_rtde import RtdePort
from workbench.devices.universal_robots.urscript import READ, Line, read_program
from workbench.devices.universal_robots.ways import Positions, UrWay
from workbench.model.errors import InputError
from workbench.plugins.robot_link import Simulation

DASHBOARD_PORT = 29999

NORMAL, PROTECTIVE = 1 << 0, 1 << 2

TICK = 0.01
"""[s] Between two positions of the arm."""

POLL_EVERY = 0.05

LONGEST_PROGRAM = 1 << 22
"""[bytes] Who says more before an end is not listened to."""

MOST_PROGRAMS = 100
"""Number of received programs that are stored."""

FAULTS = ("protective-stop", "cut", "local", "brakes", "stray")
"""A protective stop in a leg; all connections cut in a leg; the robot is in local control; a stop
of which it never says that it has ended; an arm that goes elsewhere in a leg."""

STRAYS = 0.2
"""[rad/s] By the first axis, for a second."""


class SimulatedUr:
    """Six axes and three ports; `run` serves until `stop`."""

    def __init__(
        self, simulation: Simulation, start: Sequence[float], *, positions: Positions
    ) -> None:
        """Take the ports.

        Args:
            simulation: programs come to its port.  `home_after` [s] after a program was ended
                somebody clears what has ended it, and the axes are where they were at first.  The
                faults are of `FAULTS`; `protective-stop@3` is one in the third leg.  `record` takes
                the programs that arrive.
            start: (6,) [rad] where the axes are.
            positions: of the flange, about which radii of blends are.

        Raises:
            InputError: a fault is not known, or a port is taken.
        """
        self._faults = dict(_fault(text) for text in simulation.faults)
        self._speed = simulation.speed
        self._record, self._trace = simulation.record, simulation.trace
        self._over, self._ended, self._cut = threading.Event(), threading.Event(), threading.Event()
        self._lock = threading.Lock()
        # One program begins or ends at a time: one client sends them, another one stops.
        self._changing = threading.Lock()
        self._q = self._home = tuple(float(value) for value in start)
        self._positions, self._left_at = positions, math.inf
        self._home_after = simulation.home_after
        self._registers: dict[int, int] = dict.fromkeys((rtde.PROGRESS, *rtde.BEGUN), 0)
        self._runtime, self._safety = rtde.STOPPED, NORMAL
        self._began = self._alive_at = time.monotonic()
        self._watchdog = 0.0
        self._program: threading.Thread | None = None
        self.outputs: dict[int, bool] = {}
        self.payloads: list[tuple[float, ...]] = []
        self.programs: list[str] = []
        self._listening: list[tuple[socket.socket, Callable[[socket.socket], None]]] = []
        for port, serve in (
            (simulation.port, self._take_programs),
            (rtde.RTDE_PORT, RtdePort(self._state, self._take_registers, self._receive).serve),
            (DASHBOARD_PORT, self._dashboard),
        ):
            try:
                listener = socket.create_server((simulation.host, port))
            except OSError as error:
                self._close()
                reason = error.strerror or error
                address = f"{simulation.host}:{port}"
                raise InputError(f"{address} cannot be listened on: {reason}") from None
            listener.settimeout(POLL_EVERY)
            self._listening.append((listener, serve))
        self.port: int = self._listening[0][0].getsockname()[1]
        self.state_port: int = rtde.RTDE_PORT

    @property
    def q(self) -> tuple[float, ...]:
        """Where the axes are [rad]."""
        return self._q

    @property
    def _leg(self) -> int:
        return self._registers[rtde.PROGRESS] % rtde.TICKETS

    @property
    def is_playing(self) -> bool:
        """Whether a program runs."""
        return self._runtime == rtde.PLAYING

    @property
    def is_protective(self) -> bool:
        """Whether it has stopped for its own protection."""
        return self._safety == PROTECTIVE

    def stop(self) -> None:
        """End `run`."""
        self._over.set()

    def run(self) -> None:
        """Serve until somebody stops it."""
        threads = [
            threading.Thread(target=self._accept, args=listener, daemon=True)
            for listener in self._listening
        ]
        for thread in threads:
            thread.start()
        while not self._over.wait(POLL_EVERY):
            with self._lock:
                is_silent = time.monotonic() - self._alive_at > self._watchdog
                if self._runtime == rtde.PLAYING and self._watchdog and is_silent:
                    self._safety, self._runtime = PROTECTIVE, rtde.STOPPED
                    self._leave()
                elif time.monotonic() - self._left_at > self._home_after:
                    self._safety, self._q, self._left_at = NORMAL, self._home, math.inf
        self._end_program()
        for thread in threads:
            thread.join()
        self._close()

    def _leave(self) -> None:
        """The program is ended where it is; the lock is held."""
        self._left_at = time.monotonic()
        self._ended.set()

    def _close(self) -> None:
        for listener, _ in self._listening:
            listener.close()

    def _accept(self, listener: socket.socket, serve: Callable[[socket.socket], None]) -> None:
        clients: list[threading.Thread] = []
        while not self._over.is_set() and not self._cut.is_set():
            try:
                client, _ = listener.accept()
            except TimeoutError:
                continue
            client.settimeout(POLL_EVERY)
            clients = [thread for thread in clients if thread.is_alive()]
            clients.append(threading.Thread(target=self._serve, args=(client, serve), daemon=True))
            clients[-1].start()
        for thread in clients:
            thread.join()

    def _serve(self, client: socket.socket, serve: Callable[[socket.socket], None]) -> None:
        # A client that goes, or talks nonsense, is no fault of the controller.
        with client, suppress(OSError, struct.error, ValueError, LookupError, ArithmeticError):
            serve(client)

    def _receive(self, client: socket.socket, most: int) -> bytes | None:
        """What a client says; nothing within a moment is empty, None when it is over."""
        if self._over.is_set() or self._cut.is_set():
            return None
        try:
            return client.recv(most) or None
        except TimeoutError:
            return b""

    # -- programs --------------------------------------------------------------------------

    def _take_programs(self, client: socket.socket) -> None:
        heard = b""
        while (data := self._receive(client, 1 << 16)) is not None:
            heard += data
            while b"\nend\n" in heard:
                text, _, heard = heard.partition(b"\nend\n")
                self._begin(text.decode("ascii", "replace") + "\nend\n")
            if len(heard) > LONGEST_PROGRAM:
                return

    def _begin(self, text: str) -> None:
        self.programs.append(text)
        del self.programs[:-MOST_PROGRAMS]
        if self._record is not None:
            with self._record.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"program": text}) + "\n")
        try:
            lines = read_program(text)
        except InputError:
            return  # as a controller: what does not compile does not start
        with self._changing:
            self._end_running()
            if self._safety != NORMAL or "local" in self._faults:
                return
            self._ended.clear()
            with self._lock:
                self._runtime, self._watchdog, self._alive_at = rtde.PLAYING, 0.0, time.monotonic()
                self._left_at = math.inf
            self._program = threading.Thread(target=self._execute, args=(lines,), daemon=True)
            self._program.start()

    def _end_program(self) -> None:
        with self._changing:
            self._end_running()

    def _end_running(self) -> None:
        was_playing = self._brake()
        self._ended.set()
        if self._program is not None:
            self._program.join()
        while was_playing and "brakes" in self._faults and not self._over.wait(POLL_EVERY):
            pass
        with self._lock:
            self._runtime = rtde.STOPPED

    def _brake(self) -> bool:
        with self._lock:
            was_playing = self._runtime == rtde.PLAYING
            if was_playing:
                self._runtime, self._left_at = rtde.STOPPING, time.monotonic()
        return was_playing

    def _execute(self, lines: Sequence[Line]) -> None:
        moves: list[Line] = []
        is_passed = False
        for line in (*lines, Line("stopj")):
            if self._ended.is_set() or (line.name == "halt" and not is_passed):
                break
            if line.name == "if":
                is_passed = self._registers.get(int(line.words[0]), 0) != int(line.words[1])
            is_passed = is_passed and line.name != "end"
            if is_passed:
                continue
            if moves and not moves[-1].goes_on_in(line):
                is_stream = moves[0].name == "servoj"
                self._move(
                    Following(self._q, moves)
                    if is_stream
                    else UrWay(self._q, moves, self._positions)
                )
                moves = []
            if line.q:
                moves.append(line)
            else:
                self._carry_out(line)
        with self._lock:
            if self._runtime == rtde.PLAYING:
                self._runtime = rtde.STOPPED

    def _carry_out(self, line: Line) -> None:
        match line.name:
            case "sleep":
                self._ended.wait(float(line.words[0]) / self._speed)
            case "set_standard_digital_out":
                self.outputs[int(line.words[0])] = line.words[1] == "True"
            case "rtde_set_watchdog":
                with self._lock:
                    self._watchdog, self._alive_at = 1 / float(line.words[1]), time.monotonic()
            case "write_output_integer_register":
                self._write(*line.words)
            case "set_payload" | "set_target_payload":
                self.payloads.append(tuple(map(float, line.words)))
            case "stopj" | "set_tcp" | "if" | "end":
                return  # the axes stand as soon as the program before has ended; the TCP is there
            case name:
                raise AssertionError(f"the reader knows {name}, and nobody runs it")

    def _write(self, register: str, value: str) -> None:
        read = READ.fullmatch(value)
        self._registers[int(register)] = (
            self._registers.get(int(read[1]), 0) if read else int(value)
        )
        if int(register) == rtde.PROGRESS:
            self._fail()

    def _fail(self) -> None:
        leg = self._leg
        if self._faults.get("protective-stop") == leg:
            with self._lock:
                self._safety, self._runtime = PROTECTIVE, rtde.STOPPED
                self._leave()
        if self._faults.get("cut") == leg:
            self._cut.set()

    def _move(self, way: UrWay | Following) -> None:
        began, first, *others = time.monotonic(), *self._q
        is_astray = self._faults.get("stray") == self._leg
        while not self._ended.is_set():
            t = (time.monotonic() - began) * self._speed
            if is_astray:
                self._q = (first + STRAYS * min(t, 1.0), *others)
            else:
                self._q = way.at(t)
            if self._trace is not None:
                with self._trace.open("a", encoding="utf-8") as file:
                    file.write(json.dumps({"at": time.time(), "q": self._q}) + "\n")
            if t >= way.seconds:
                return
            self._ended.wait(min(TICK, (way.seconds - t) / self._speed))

    def _state(self) -> dict[str, object]:
        registers = {
            f"output_int_register_{number}": value for number, value in self._registers.items()
        }
        return {
            # Faster than in real time its clock is, too.
            "timestamp": self._began + (time.monotonic() - self._began) * self._speed,
            "actual_q": self._q,
            "robot_mode": rtde.RUNNING_MODE,
            "safety_status_bits": self._safety,
            "runtime_state": self._runtime,
            **registers,
        }

    def _take_registers(self, values: dict[str, object]) -> None:
        if f"input_int_register_{rtde.ALIVE}" in values:
            with self._lock:
                self._alive_at = time.monotonic()

    # -- dashboard -------------------------------------------------------------------------

    def _dashboard(self, client: socket.socket) -> None:
        client.sendall(b"Connected: Universal Robots Dashboard Server\n")
        heard = b""
        while (data := self._receive(client, rtde.LONGEST_PACKET)) is not None:
            *lines, heard = (heard + data).split(b"\n")
            for line in lines:
                client.sendall(self._answer(line.decode("ascii", "replace").strip()) + b"\n")

    def _answer(self, asked: str) -> bytes:
        match asked.lower():
            case "is in remote control":
                return b"false" if "local" in self._faults else b"true"
            case "polyscopeversion":
                return b"URSoftware 5.11.0.0"
            case "stop":
                self._end_program()
                return b"Stopped"
            case "quit":
                return b"Disconnected"
            case _:
                return f"could not understand: '{asked}'".encode()


def _fault(text: str) -> tuple[str, int]:
    word, _, leg = text.partition("@")
    if word not in FAULTS or (leg and not leg.isdecimal()):
        raise InputError(f"fault {text!r:.40}: one of {', '.join(FAULTS)} is expected, with @LEG")
    return word, int(leg or 1)

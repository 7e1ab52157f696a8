"""The controller's side of `abb-socket/2` without sockets: what is in order, and the answer.

It keeps to the table in `abb_socket.states`.  What moves is somebody else's: `run` and `abort` go
to whoever owns the motion, and what comes of it is reported by `note`.
"""

import re
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from workbench.devices.abb_simulated.loading import Loading
from workbench.devices.abb_socket.frames import Frames, MessageFrame, make_frame, number_after
from workbench.devices.abb_socket.program import SocketProgram
from workbench.devices.abb_socket.sending import VERSION, arms_of
from workbench.devices.abb_socket.states import NEXT, ControllerPhase
from workbench.model.cell import Cell
from workbench.model.errors import LinkError, ProtocolError
from workbench.model.geometry import Floats

START_TOLERANCE = np.deg2rad(0.5)
"""[rad] How far an arm may stand from where the program begins."""

MOST_TICKETS = 16
"""This many of the last tickets are remembered, and not run again."""

LONGEST_WORDS = 60
"""Characters of a refusal or a fault that fit a frame."""


class Serving:
    """One conversation in which one client may load and run programs.

    Lifetime: one connection; `tickets` outlives it.
    """

    def __init__(
        self, cell: Cell, standing: Callable[[], Mapping[str, Floats]], tickets: list[str]
    ) -> None:
        """Wait for `hello`.

        Args:
            cell: whose arms the controller has.
            standing: gives the configuration (n,) [rad] of every arm now.
            tickets: those that were run; the next one is added.
        """
        self.phase: ControllerPhase = "greeted"
        self.program: SocketProgram | None = None
        self._cell, self._standing, self._tickets = cell, standing, tickets
        self._frames = Frames()
        self._loading = Loading(cell)
        self._number = self._waits = 0

    def hear(self, data: bytes) -> Iterator[tuple[MessageFrame, str]]:
        """Take what arrived: each message that is in order, and the answer to it.

        Raises:
            ProtocolError: one is not in order, or not a frame.
            LinkError: it is, but cannot be done.
        """
        for frame in self._frames.hear(data):
            after = NEXT.get((self.phase, frame.word))
            if after is None or frame.word in ("done", "fault", "wait"):
                raise ProtocolError(f"{frame.word} is not in order when {self.phase}")
            answer = self._answer(frame)
            self.phase = after
            yield frame, answer

    def say(self, text: str) -> bytes:
        """A message of ours as a frame."""
        self._number = number_after(self._number)
        return make_frame(self._number, text)

    def refusal(self, error: LinkError) -> str:
        """What is said before the link is closed; nothing is in order after it."""
        heard = re.sub(r"[^ -~]", "?", str(error))[:LONGEST_WORDS]
        return f"no {self._frames.number:04d} {heard}"

    def note(self, event: str, waits: int = 0) -> None:
        """What the robot did: `done`, `fault`, or `wait` before the step `waits`."""
        self.phase, self._waits = NEXT[self.phase, event], waits

    def _answer(self, frame: MessageFrame) -> str:
        match frame.word:
            case "hello":
                if frame.rest != VERSION:
                    raise ProtocolError(f"{frame.rest!r} is not {VERSION}")
                return f"hello {VERSION} {arms_of(self._cell)}"
            case "plan":
                self._loading = Loading(self._cell)
                self._loading.take(frame)
            case "ticket" | "start" | "load" | "axes" | "leg" | "to" | "end":
                self.program = self._loading.take(frame)
            case "run":
                self._check_run(frame)
            case "next":
                if frame.rest != f"{self._waits:02d}":
                    raise ProtocolError(f"step {self._waits:02d} waits, not {frame.rest!r}")
            case "abort":
                return "stopped"
            case _:
                pass
        return f"ok {frame.number:04d} {frame.crc}"

    def _check_run(self, frame: MessageFrame) -> None:
        program = self.program
        if program is None or frame.rest != program.ticket:
            raise ProtocolError(f"run has ticket {frame.rest!r}, another one was loaded")
        if program.ticket in self._tickets:
            raise LinkError(f"ticket {program.ticket} was run before")
        for arm, q in self._standing().items():
            off = float(np.abs(q - program.starts[arm]).max())
            if off > START_TOLERANCE:
                raise LinkError(f"arm {arm} is {np.rad2deg(off):.1f} degrees from its start")
        self._tickets.append(program.ticket)
        del self._tickets[:-MOST_TICKETS]

"""A simulated controller with a client that speaks `abb-socket/2`: loads, runs, reports."""

import select
import socket
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from workbench.devices.abb_simulated.body import SimulatedBody
from workbench.devices.abb_simulated.faults import SLOW_SECONDS
from workbench.devices.abb_simulated.motion import Motion
from workbench.devices.abb_simulated.serving import LONGEST_WORDS, Serving
from workbench.devices.abb_socket.frames import MessageFrame
from workbench.devices.abb_socket.messages import in_degrees
from workbench.model.errors import LinkError, ProtocolError
from workbench.plugins.robot_link import USUAL, LinkPatience

TICK = 0.02
"""[s] Between two looks at the client while the robot moves."""

REPORT = 0.2
"""[s] Between two reports of the state."""

SLICE = 1.0
"""[s] Of the robot's time that is computed at once: between two of them the client is heard."""

LEFT = "the client left while the robot moved"


@dataclass(slots=True)
class ServedRobot:
    """What stays from client to client: the robot, and what it remembers.

    `is_over` says that the controller is to end, `look_around` turns others away meanwhile.
    """

    body: SimulatedBody
    is_over: Callable[[], bool]
    look_around: Callable[[], None]
    paces: Mapping[str, float] = field(default_factory=dict[str, float])
    tickets: list[str] = field(default_factory=list[str])
    patience: LinkPatience = USUAL

    def wait(self, seconds: float) -> None:
        """Do nothing for that long, unless the controller ends."""
        until = self.patience.clock() + seconds
        while self.patience.clock() < until and not self.is_over():
            time.sleep(TICK)

    def play_dead(self, client: socket.socket) -> None:
        """Say nothing, move nothing, close nothing, for as long as the client is there."""
        while not self.is_over():
            self.look_around()
            if select.select([client], [], [], TICK)[0] and not client.recv(4096):
                return


class ProgramClient:
    """One client, from `hello` to its end.

    Lifetime: one connection.  Concurrency: one thread.
    """

    def __init__(self, client: socket.socket, station: ServedRobot) -> None:
        """Serve a `client` that got `send` and has sent no plan yet."""
        self._client, self._station, self._body = client, station, station.body
        self._serving = Serving(self._body.cell, self._body.standing, station.tickets)
        self._motion: Motion | None = None
        self._messages = 0
        self._silence, self._clock = station.patience.silence, station.patience.clock
        self._heard_at = self._moved_at = self._clock()
        self._behind = 0.0
        self._reported_at = 0.0

    def serve(self) -> None:
        """Answer until the client leaves, or something is wrong.

        Raises:
            LinkError: something was; nothing moves any more.
        """
        self._client.settimeout(self._silence)
        try:
            while not self._station.is_over():
                tick = 0.0 if self._motion is not None and self._behind else TICK
                if select.select([self._client], [], [], tick)[0] and not self._hear():
                    return
                # Only now: who comes after this one has left is not turned away.
                self._station.look_around()
                self._check_silence()
                self._move()
                self._report()
        except LinkError as error:
            self._say(self._serving.refusal(error))
            raise
        finally:
            self._motion = None

    def _hear(self) -> bool:
        """Take what arrived; False when the client has left, as it may."""
        try:
            data = self._client.recv(4096)
        except ConnectionError:
            # Who leaves with reports unread resets the connection.
            data = b""
        if not data:
            if self._motion is not None:
                raise LinkError(LEFT)
            return False
        self._heard_at = self._clock()
        for frame, answer in self._serving.hear(data):
            self._messages += 1
            self._body.count_message()
            if not self._answer(frame, answer):
                return False
        return True

    def _answer(self, frame: MessageFrame, answer: str) -> bool:
        """Do what a message asks for, and answer it, unless a fault comes between."""
        faults, count, program = self._body.faults, self._messages, self._serving.program
        if frame.word == "end" and program is not None:
            for leg in program.legs:
                self._body.record(leg.arm, "to", np.asarray(leg.q[1:]))
        if frame.word == "run" and program is not None:
            if faults.is_due("start-refused", count):
                raise LinkError("an arm is 12.3 degrees from its start")
            self._body.reckon(program.loads)
            self._motion = Motion(program, self._body, self._station.paces)
            self._moved_at, self._behind = self._clock(), 0.0
        if frame.word == "next" and self._motion is not None:
            self._motion.let()
            self._moved_at, self._behind = self._clock(), 0.0
        if frame.word == "abort":
            self._motion = None
            self._body.halt("stopped by the client")
        if faults.is_due("half-open", count):
            self._motion = None
            self._body.halt("nobody is there")
            self._station.play_dead(self._client)
            return False
        if faults.is_due("slow", count):
            self._station.wait(SLOW_SECONDS)
        if faults.is_due("garbage", count):
            self._client.sendall(b"\x00\x13 garbage \xff" * 8)
        data = self._serving.say(answer)
        self._client.sendall(data)
        if faults.is_due("double-send", count):
            self._client.sendall(data)
        if faults.is_due("drop", count):
            self._motion = None
            self._body.halt("the link was dropped on demand")
            return False
        return True

    def _check_silence(self) -> None:
        if self._motion is not None and self._clock() - self._heard_at > self._silence:
            self._fail(f"the client was silent for {self._silence:.0f} s while the robot moved")

    def _move(self) -> None:
        if self._motion is None:
            return
        now = self._clock()
        due = self._behind + (now - self._moved_at) * self._body.speed
        seconds, self._moved_at = min(due, SLICE), now
        self._behind = due - seconds
        try:
            motion = self._motion
            for event in motion.advance(seconds):
                if event == "wait":
                    self._serving.note(event, motion.waits)
                    continue
                if event.startswith("done"):
                    self._serving.note("done")
                    self._motion = None
                self._say(event)
        except LinkError as error:
            self._fail(str(error))

    def _fail(self, why: str) -> None:
        """The robot stops by itself; the link stays, so that the client hears why."""
        self._motion = None
        self._serving.note("fault")
        self._body.halt(why)
        self._say(f"fault {why}"[:LONGEST_WORDS])

    def _report(self) -> None:
        now = self._clock()
        if self._serving.phase == "greeted" or now - self._reported_at < REPORT:
            return
        self._reported_at = now
        idle = "00 " + " ".join(f"{arm.controller_id}00" for arm in self._body.cell.arms)
        report = idle if self._motion is None else self._motion.report
        self._say(f"state {self._serving.phase} {report}")
        standing = self._body.standing()
        for arm in self._body.cell.arms:
            self._say(f"at {arm.controller_id} {' '.join(in_degrees(arm, standing[arm.name]))}")

    def _say(self, text: str) -> None:
        try:
            self._client.sendall(self._serving.say(text))
        except OSError as error:
            if self._motion is not None:
                raise ProtocolError(f"the client takes nothing any more: {error}") from None

"""A simulated controller for a client that speaks `abb-socket`: requests commands and runs them."""

import select
import socket
import time
from typing import Any

import numpy as np

from workbench.devices.abb_simulated.faults import SLOW_SECONDS, STOPS
from workbench.devices.abb_simulated.serve_program import TICK, ServedRobot
from workbench.devices.abb_socket.messages import REQUEST, Commands, SocketMessage
from workbench.model.cell import Arm
from workbench.model.errors import LinkError, ProtocolError
from workbench.model.geometry import Floats

LEFT = "the client left in the middle of a sequence"


class RequestClient:
    """One client, to its end.

    Lifetime: one connection.  Concurrency: one thread.
    """

    def __init__(self, client: socket.socket, station: ServedRobot) -> None:
        """Serve a `client` that got `send` once."""
        self._client, self._station, self._body = client, station, station.body
        self._commands = Commands(self._body.cell)
        self._patience = station.patience
        self._messages = 0

    def serve(self) -> None:
        """Ask and obey until the client leaves between two sequences.

        Raises:
            LinkError: it left within one, or said something else; nothing moves any more.
        """
        last: SocketMessage | None = None
        while not self._station.is_over():
            message = self._next()
            if message is None:
                return
            self._messages += 1
            self._execute(message, last)
            last = message
            if not self._ask():
                return

    def _ask(self) -> bool:
        """Ask for the next message, unless a fault comes between; False when that ends it."""
        faults, count = self._body.faults, self._messages
        if faults.is_due("drop", count):
            raise LinkError("the link was dropped on demand")
        if faults.is_due("half-open", count):
            self._station.play_dead(self._client)
            return False
        if faults.is_due("slow", count):
            self._station.wait(SLOW_SECONDS)
        if faults.is_due("garbage", count):
            self._client.sendall(b"\x00\x13 garbage \xff")
        self._client.sendall(REQUEST * (2 if faults.is_due("double-send", count) else 1))
        return True

    def _next(self) -> SocketMessage | None:
        """The next message; None when the client leaves between two sequences.

        Between sequences it may take as long as it likes.
        """
        answer, clock = self._patience.answer, self._patience.clock
        until = clock() + answer
        while not self._station.is_over():
            self._station.look_around()
            if not select.select([self._client], [], [], TICK)[0]:
                if clock() > until and not self._commands.is_between:
                    raise LinkError(f"no message for {answer:.0f} s within a sequence")
                continue
            data = self._client.recv(256)
            if not data:
                if self._commands.is_between:
                    return None
                raise LinkError(LEFT)
            message = self._commands.hear(data)
            if message is not None:
                return message
        return None

    def _execute(self, message: SocketMessage, last: SocketMessage | None) -> None:
        arm, body = self._body.cell.arm(message.arm), self._body
        body.count_message()
        body.record(message.arm, message.kind, message.q)
        match message.kind:
            case "start":
                if body.faults.is_due("start-refused", self._messages):
                    raise LinkError(f"arm {arm.name} is 12.3 degrees from its start")
                body.forget(arm.name)
            case "in" | "out":
                if message.kind == "out" and last is not None and last.kind == "in":
                    body.grip(arm.name, 0.0)
                elif message.kind == "in" and last is not None and last.kind == "start":
                    body.open(arm.name, arm.tool.stroke[1])
                if message.q is not None:
                    self._move(arm, np.asarray(message.q))
            case "stop":
                if body.has_gripped(arm.name):
                    body.open(arm.name, arm.tool.stroke[1])

    def _move(self, arm: Arm, goal: Floats) -> None:
        """All joints linearly, as fast as the slowest of them may."""
        body = self._body
        others = [other for other in body.cell.arms if other.name != arm.name]
        if others and body.faults.is_due("wrong-arm", self._messages):
            arm = others[0]
            goal = np.asarray(arm.home) + 0.2
        _, _, velocity = body.cell.robot.limits(arm.joints)
        start = body.standing()[arm.name]
        seconds = float((np.abs(goal - start) / (velocity * body.cell.policy.speed)).max())
        seconds /= body.speed
        began = time.monotonic()
        body.put({}, arm.name)
        self._check_stops()
        while (passed := time.monotonic() - began) < seconds and not self._station.is_over():
            q = start + (goal - start) * (passed / seconds)
            body.put({arm.name: q}, arm.name)
            body.trace([self._trace(arm, q)] if body.is_traced else [])
            # A client that has gone must not be obeyed to the end of its last word.
            if select.select([self._client], [], [], min(TICK, seconds - passed))[0]:
                if not self._client.recv(1, socket.MSG_PEEK):
                    raise LinkError(LEFT)
                raise ProtocolError("a message came before it was asked for")
        body.put({arm.name: goal}, "")

    def _check_stops(self) -> None:
        """An emergency stop, or a program that has lost its place: nobody answers any more."""
        for name, fault in STOPS.items():
            if self._body.faults.is_due(name, self._messages):
                self._body.halt(fault)
                self._station.play_dead(self._client)
                raise LinkError(fault)

    def _trace(self, arm: Arm, q: Floats) -> dict[str, Any]:
        return {"step": self._messages, "q": {arm.name: np.asarray(q).tolist()}}

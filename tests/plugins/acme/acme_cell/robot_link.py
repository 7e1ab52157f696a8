"""Acme's controller: one JSON object a line over TCP, one leg at a time.

We send {"arm", "leg", "q", "t", "opening", "holding"}; it answers {"done": leg} when the leg has
been executed, with "picked" true or false after the part was put down, or {"fault": why}.
{"stop": true} is answered by {"stopped": true} once the robot stands.  The second port tells the
state.
"""

import json
import select
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.model.cell import Cell
from workbench.model.errors import InputError, JobCancelled, LinkError
from workbench.model.motion import MotionModel
from workbench.model.plan import Plan
from workbench.model.release import Approval, LinkStatus, PartReport, Receipt, RobotState
from workbench.plugins.options import option
from workbench.plugins.robot_link import LinkPatience, Running, Simulation, check_approval

POLL = 0.05
"""[s] Between two looks whether to stop."""


class Lines:
    """JSON objects that come over a connection."""

    def __init__(self, link: socket.socket):
        self._link, self._heard = link, b""

    def next(self, seconds: float) -> dict[str, Any] | None:
        """The next one, None when none came within so long."""
        while b"\n" not in self._heard:
            if not select.select([self._link], [], [], seconds)[0]:
                return None
            data = self._link.recv(1 << 16)
            if not data:
                raise LinkError("the controller closed the link")
            self._heard += data
        line, self._heard = self._heard.split(b"\n", 1)
        try:
            return dict(json.loads(line))
        except (ValueError, TypeError):
            raise LinkError(f"the controller said {line[:40]!r}") from None

    def say(self, **words: Any) -> str:
        """Send one object."""
        text = json.dumps(words)
        self._link.sendall(text.encode() + b"\n")
        return text


class AcmeLink:
    """Stops at each waypoint, moves one arm at a time, and tells what became of each part."""

    @dataclass(frozen=True)
    class Options:
        """Keys in `[controller.options]`."""

        tries: int = option(1, low=1, high=10, says="how often a connection is tried")

    motion = MotionModel("acme-json", corners="stop", unit="rad", decimals=5, reports_progress=True)

    def check(self, cell: Cell) -> None:
        """Arms are told by name: any cell."""

    def send(
        self,
        plan: Plan,
        approval: Approval,
        cell: Cell,
        *,
        now: Callable[[], float],
        cancelled: Callable[[], bool],
        show: Callable[[LinkStatus], None],
        patience: LinkPatience,
    ) -> Iterator[Receipt]:
        """Leg after leg."""
        check_approval(plan, approval, cell, now())
        runs = [run for step in plan.sequence for run in step.runs]
        if any(len(step.runs) != 1 for step in plan.sequence):
            raise InputError("the robot link acme-json moves one arm at a time")
        try:
            with socket.create_connection((cell.controller.host, cell.controller.port), 3) as link:
                lines = Lines(link)
                for number, (arm, name) in enumerate(runs, start=1):
                    leg = plan.arm(arm).leg(name)
                    check_approval(plan, approval, cell, now())
                    text = lines.say(
                        arm=arm,
                        leg=name,
                        q=np.round(leg.q, 5).tolist(),
                        t=leg.t.tolist(),
                        opening=leg.opening,
                        holding=leg.holding,
                    )
                    show(LinkStatus("acme-json", "moving", number, len(runs), "", now(), now()))
                    yield Receipt(now(), arm, name, text, number, len(runs))
                    answer = self._awaited(lines, leg.seconds, cancelled, patience)
                    if name == "place":
                        done = PartReport(
                            arm, plan.arm(arm).detection, answer.get("picked") is True
                        )
                        heard = json.dumps(answer)
                        yield Receipt(now(), arm, "heard", "", number, len(runs), heard, done)
        except OSError as error:
            raise LinkError(f"the controller cannot be reached: {error}") from None

    def _awaited(
        self,
        lines: Lines,
        seconds: float,
        cancelled: Callable[[], bool],
        patience: LinkPatience,
    ) -> dict[str, Any]:
        until = patience.clock() + 10 * seconds + patience.answer
        while patience.clock() < until:
            if cancelled():
                lines.say(stop=True)
                stopped = lines.next(patience.stop)
                sure = "the robot stands" if stopped else "nobody said that the robot stands"
                raise JobCancelled(f"sending was stopped; {sure}")
            answer = lines.next(POLL)
            if answer is not None:
                if "fault" in answer:
                    raise LinkError(f"the controller says: {answer['fault']}")
                return answer
        raise LinkError("the controller was silent")

    def states(self, cell: Cell, cancelled: Callable[[], bool]) -> Iterator[RobotState]:
        """One object a line, whenever something has changed."""
        at = (cell.controller.host, cell.controller.state_port)
        try:
            with socket.create_connection(at, 3) as link:
                lines = Lines(link)
                while not cancelled():
                    told = lines.next(POLL)
                    if told is not None:
                        joints = {arm: tuple(q) for arm, q in told["joints"].items()}
                        yield RobotState(joints, {}, told["moving"], 0, told["placed"], "")
        except OSError as error:
            raise LinkError(f"no state is reported: {error}") from None

    def serve(self, cell: Cell, simulation: Simulation, ready: Callable[[Running], None]) -> None:
        """A controller that does what it is told, one client after the other."""
        if simulation.faults:
            raise InputError("this simulated controller has no faults to ask for")
        robot = SimulatedAcme(cell, simulation)
        ready(robot)
        robot.run()


class SimulatedAcme:
    """Jumps from waypoint to waypoint, as late as the robot would come there."""

    def __init__(self, cell: Cell, simulation: Simulation):
        self._speed, self._over = simulation.speed, threading.Event()
        self._motion = socket.create_server((simulation.host, simulation.port))
        self._state = socket.create_server((simulation.host, simulation.state_port))
        self._motion.settimeout(POLL)
        self._state.settimeout(POLL)
        self.port: int = self._motion.getsockname()[1]
        self.state_port: int = self._state.getsockname()[1]
        self._joints = {arm.name: arm.home.tolist() for arm in cell.arms}
        self._moving, self._placed = "", 0

    def stop(self) -> None:
        """End `run`."""
        self._over.set()

    def run(self) -> None:
        """Until somebody stops it."""
        reports = threading.Thread(target=self._report)
        reports.start()
        while not self._over.is_set():
            try:
                link, _ = self._motion.accept()
            except TimeoutError:
                continue
            # A client that has gone is no fault: the next one may come.
            with link, suppress(LinkError, OSError):
                self._converse(Lines(link))
            self._moving = ""
        reports.join()
        self._motion.close()
        self._state.close()

    def _converse(self, lines: Lines) -> None:
        while not self._over.is_set():
            told = lines.next(POLL)
            if told is None:
                continue
            if told.get("stop"):
                lines.say(stopped=True)
                return
            self._moving, before = told["arm"], 0.0
            for q, t in zip(told["q"], told["t"], strict=True):
                asked = lines.next(max(t - before, 0.0) / self._speed)
                if asked is not None and asked.get("stop"):
                    lines.say(stopped=True)
                    return
                self._joints[told["arm"]], before = q, t
            self._moving = ""
            self._placed += told["leg"] == "place"
            lines.say(done=told["leg"], picked=told["leg"] == "place")

    def _report(self) -> None:
        watchers: list[socket.socket] = []
        said = b""
        while not self._over.is_set():
            try:
                watchers.append(self._state.accept()[0])
                said = b""
            except TimeoutError:
                pass
            state = {"joints": self._joints, "moving": self._moving, "placed": self._placed}
            line = json.dumps(state).encode() + b"\n"
            if line != said:
                for watcher in list(watchers):
                    try:
                        watcher.sendall(line)
                    except OSError:
                        watchers.remove(watcher)
                said = line
        for watcher in watchers:
            watcher.close()

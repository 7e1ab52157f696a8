"""A simulated robot program: it asks for what people have sent, and moves its arm in time."""

import random
import socket
import threading
import time
from contextlib import suppress

import numpy as np

from workbench.devices.pick_server.asking import Asker
from workbench.devices.pick_server.axes import AxisWords
from workbench.devices.pick_server.carrying import MISSED
from workbench.devices.pick_server.conversation import POSES_VERSION, VERSION, Words
from workbench.devices.pick_server.lines import LAST
from workbench.devices.pick_server.poses import POSES
from workbench.model.cell import Cell
from workbench.model.errors import InputError, LinkError
from workbench.model.geometry import Floats
from workbench.plugins.robot_link import Simulation

FAULTS = ("cut", "silent", "stray", "anew", "empty-hand")
"""By word: the connection ends in that leg; nothing is asked any more; the arm goes elsewhere; the
program begins anew; the hand grips nothing."""

HEARTBEAT = 0.1
"""[s] Between two reports of the joints."""

STRAY = np.deg2rad(3.0)


class Stopped(Exception):
    """The server answers by `STOP`."""


class SimulatedProgram:
    """Asks at `port` of the simulation's host until `stop`.

    Lifetime: `run` returns after `stop`, which any thread may call.
    """

    def __init__(self, cell: Cell, axes: AxisWords, simulation: Simulation) -> None:
        """Choose a free port where none is given.

        Raises:
            InputError: a fault is not known.
        """
        self._axes, self._arm, self._simulation = axes, cell.arms[0], simulation
        self._sends_poses = cell.controller.motion.sends_poses
        self._host = simulation.host
        self.port = simulation.port or _free_port(simulation.host)
        self.state_port = simulation.state_port
        self._faults = [_fault(text) for text in simulation.faults]
        self._over = threading.Event()
        self.q = np.asarray(cell.arms[0].home)
        self._asker = self._new_asker()
        self.tickets: list[str] = []

    def stop(self) -> None:
        """End it."""
        self._over.set()

    def run(self) -> None:
        """Ask until somebody stops it."""
        while not self._over.is_set():
            with suppress(LinkError):
                try:
                    self._cycle()
                except Stopped:
                    self._ask("stop")
                    self._go_home()
                    continue
            if not self._over.wait(HEARTBEAT):
                continue
        self._asker.close()

    def _new_asker(self) -> Asker:
        run = random.SystemRandom().randint(1, LAST)
        version = POSES_VERSION if self._sends_poses else VERSION
        form, is_over = self._axes.form, self._over.is_set
        return Asker(self._host, self.port, form, run, is_over, version=version)

    def _cycle(self) -> None:
        try:
            answer = self._ask("state", *self._joints())
        except LinkError:
            self._asker = self._new_asker()
            return
        if answer[0] == "STOP":
            raise Stopped
        if answer[:2] != ("OK", "offered"):
            return
        answer = self._ask_or_stop("next", *self._joints())
        if answer[0] == "PICK":
            self._take(answer[2])
            self._pick()
        if answer[0] != "PLAN":
            return
        self._take(answer[1])
        is_held = is_reported = False
        for number in range(1, int(answer[2]) + 1):
            leg = self._ask_or_stop("leg", str(number))
            hand, points = leg[2], int(leg[4])
            ways = [self._ask_or_stop("point", str(number), str(k + 1)) for k in range(points)]
            if hand == "grip":
                is_held = "empty-hand" not in self._happens(number)
            if hand == "open" and is_held and not is_reported:
                self._ask_or_stop("placed")
                is_reported = True
            self._misbehave(number)
            for words in ways:
                self._move(words)
            if "stray" in self._happens(number):
                self.q = self.q + STRAY
            self._ask_or_stop("done", str(number), *self._joints())
            if hand == "grip":
                self._ask_or_stop(*(("picked",) if is_held else ("failed", MISSED)))

    def _take(self, ticket: str) -> None:
        if ticket in self.tickets:
            raise Stopped
        self.tickets.append(ticket)

    def _pick(self) -> None:
        """Ask for the poses of a pick; what moves there is not simulated."""
        for number in range(1, len(POSES) + 1):
            self._misbehave(number)
            self._ask_or_stop("pose", str(number))
        if self._happens(len(POSES)).count("empty-hand"):
            self._ask_or_stop("failed", MISSED)
            return
        self._ask_or_stop("picked")
        self._ask_or_stop("placed")

    def _move(self, words: Words) -> None:
        """Go straight in the joints to a waypoint, in its time."""
        count = len(self._arm.joints)
        begin, there = self.q, self._axes.read(words[1 : count + 1], in_motion=True)
        seconds = float(words[count + 2]) / self._simulation.speed
        began = time.monotonic()
        while (share := (time.monotonic() - began) / seconds) < 1.0:
            self.q = begin + share * (there - begin)
            self._over.wait(min(HEARTBEAT, seconds))
            if self._over.is_set():
                raise LinkError("ended")
            if seconds > HEARTBEAT:
                self._ask_or_stop("state", *self._joints())
        self.q = there

    def _misbehave(self, leg: int) -> None:
        for fault in self._happens(leg):
            match fault:
                case "cut":
                    self._asker.close()
                case "silent":
                    self._over.wait()
                case "anew":
                    self._asker.close()
                    self._asker = self._new_asker()
                case _:
                    pass

    def _happens(self, leg: int) -> list[str]:
        return [name for name, number in self._faults if number in (0, leg)]

    def _ask_or_stop(self, job: str, *words: str) -> Words:
        answer = self._ask(job, *words)
        if answer[0] == "STOP":
            raise Stopped
        return answer

    def _ask(self, job: str, *words: str) -> Words:
        if self._simulation.record is not None:
            with self._simulation.record.open("a", encoding="utf-8") as file:
                file.write(" ".join((job, *words)) + "\n")
        return self._asker.ask(job, *words)

    def _joints(self) -> list[str]:
        return self._axes.format(self.q)

    def _go_home(self) -> None:
        if not self._over.wait(min(self._simulation.home_after, threading.TIMEOUT_MAX)):
            self.q: Floats = np.asarray(self._arm.home)


def _fault(text: str) -> tuple[str, int]:
    name, _, leg = text.partition("@")
    if name not in FAULTS or not (leg.isdecimal() or not leg):
        raise InputError(f"--fault {text!r}: one of {', '.join(FAULTS)} with @LEG is expected")
    return name, int(leg or 0)


def _free_port(host: str) -> int:
    with socket.create_server((host, 0)) as one:
        return one.getsockname()[1]

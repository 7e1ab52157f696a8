"""A controller that runs RAPID: its tasks, robots, signals, operator and network, in one loop."""

import logging
import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from workbench.devices.rapid.kinematics import Axes
from workbench.devices.rapid.motion import TIME_STEP, Mechanism, pair
from workbench.devices.rapid.moving import MotionInstructions
from workbench.devices.rapid.sockets import Device, Network
from workbench.devices.rapid.sockets import natives as socket_natives
from workbench.devices.rapid.tasks import Meetings, Task
from workbench.devices.rapid.waiting import Clock, Signals, Waiting
from workbench.formats.rapid.hosts import Key
from workbench.formats.rapid.loading import Loaded
from workbench.formats.rapid.setup import Setup
from workbench.formats.rapid.texts import NATIVES
from workbench.model.cell import Cell
from workbench.model.errors import InputError, WorkbenchError
from workbench.model.geometry import Floats

log = logging.getLogger(__name__)

TICK = 0.005
"""[s] Between two looks while a robot moves."""

IDLE = 0.02
"""[s] Between two looks while nothing does; what arrives on a socket ends it."""

MOST_STEPS = 250
"""Of a robot's time, that are computed at once: between them the link is heard."""

MOST_HELD = 100
"""Turns in a row, of some hundred statements each, that a robot's program may hold robots' time."""

MOST_LINES = 10_000
"""Lines of `written`, the newest."""

PART = 15.0
"""[mm] How far a finger is out when it has closed around a part, unless `closes_at` says else."""


@dataclass
class Operator:
    """Who stands at the robot: answers questions, sets pointers to main, presses start.

    `answers` are the keys pressed next, from 1 on; after them it is `usual`, 0 for nobody answers.
    `comes_after` [s] robots have been stopped, pointers are set to main and programs started.
    """

    answers: list[int] = field(default_factory=list[int])
    usual: int = 0
    comes_after: float = math.inf
    asked: list[str] = field(default_factory=list[str])

    def press(self, task: str, text: str, keys: Sequence[str]) -> int | None:
        """The key that is pressed."""
        question = f"{task}: {text}"
        if not self.asked or self.asked[-1] != question:
            self.asked.append(question)
            log.info("%s [%s]", question, "; ".join(key for key in keys if key))
        return self.answers.pop(0) if self.answers else self.usual or None


class RapidController:
    """Tasks in turns, and robots that move meanwhile.

    Lifetime: the port is open from construction until `run` ends; `stop` ends it, from anywhere.
    Concurrency: `run` owns everything; other threads may read `written`, `covered` and `state`, and
    have things done by `do`.
    """

    def __init__(
        self,
        cell: Cell,
        setup: Setup,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        speed: float = 1.0,
        operator: Operator | None = None,
        clock: Callable[[], float] = time.monotonic,
        peek_reports_end: bool = True,
    ) -> None:
        """Load everything.

        Args:
            cell: whose arms the tasks move.
            setup: tasks and system outputs.
            host: address to listen on, whichever the modules name.
            port: port to listen on, whichever the modules name; 0 takes any free one.
            speed: how fast the robots' time goes; that of programs and of the link is real.
            operator: who stands at the robot; nobody answers when not given.
            clock: [s] never goes back.
            peek_reports_end: whether SocketPeek raises ERR_SOCK_CLOSED once the peer has left.

        Raises:
            BadModule: a module cannot run.
            LinkError: the port is taken.
        """
        self.setup, self.operator, self.clock = setup, operator or Operator(), clock
        self.written: list[str] = []
        self.covered: set[Key] = set()
        self.time = 0.0
        self.is_emergency = False
        self.before_move: Callable[[str], None] = lambda task: None
        self.closes_at: Callable[[str], float] = lambda task: PART
        self._speed, self._due, self._seen = speed, 0.0, clock()
        self._over = threading.Event()
        self._orders: list[tuple[Callable[[], None], threading.Event]] = []
        self._stopped_since: float | None = None
        self._held, self._warned = 0, ""
        outputs = setup.outputs.items()
        self.signals = Signals(made={name.lower(): self._output(*words) for name, words in outputs})
        self.tasks = {name: Task(name, clock, self.covered) for name in setup.tasks}
        self.mechanisms = {
            name: Mechanism(name, Axes(cell, cell.arm(task.arm)))
            for name, task in setup.tasks.items()
            if task.arm
        }
        self.moving: dict[str, MotionInstructions] = {}
        self.shared: dict[str, list[Any]] = {}
        self._meetings = Meetings(list(self.mechanisms))
        self.network = Network(host, port, peek_reports_end)
        try:
            for name in setup.tasks:
                self._load(name)
        except InputError:
            self.network.close()
            raise

    def _load(self, name: str) -> None:
        task = self.tasks[name]
        task.mechanism = self.mechanisms.get(name)
        waiting = Waiting(task, self._meetings, self.signals, self.operator.press, self._write)
        moving = MotionInstructions(
            task,
            self.mechanisms,
            lambda: self.time,
            lambda: self.before_move(name),
            lambda: self.closes_at(name),
        )
        self.moving[name] = moving
        natives = {**NATIVES, **waiting.natives(), **moving.natives()}
        natives |= {**socket_natives(task, self.network), **self.more_natives(task)}
        task.loaded = Loaded(
            self.setup.tasks[name].modules,
            task,
            natives=natives,
            makers={**MAKERS, "socketdev": lambda name: self.network.device()},
            shared=self.shared,
            signals=dict.fromkeys(self.setup.outputs, "signaldo"),
            on_error=task.set_errno,
        )
        task.loaded.check()

    def more_natives(self, task: Task) -> dict[str, Callable[..., Any]]:
        """What an option of the controller adds for a task, by small name."""
        return {}

    @property
    def port(self) -> int:
        """Where clients come."""
        return self.network.port

    @property
    def state_port(self) -> int:
        """None: what is to be known is reported on the link."""
        return 0

    @property
    def keys(self) -> set[Key]:
        """All statements of all modules."""
        return {key for task in self.tasks.values() if task.loaded for key in task.loaded.keys}

    def axes(self) -> dict[str, Floats]:
        """Where the robots are, (n,) [deg], by task."""
        return {name: np.array(mechanism.here) for name, mechanism in self.mechanisms.items()}

    # -- what people and faults do

    def later(self, act: Callable[[], None]) -> None:
        """Do something between two turns."""
        self._orders.append((act, threading.Event()))

    def do(self, act: Callable[[], None]) -> None:
        """Do something between two turns, and wait until it is done."""
        done = threading.Event()
        self._orders.append((act, done))
        while not done.wait(0.05) and not self._over.is_set():
            pass

    def stop(self) -> None:
        """End `run`."""
        self._over.set()

    def start_anew(self) -> None:
        """Robots' pointers to main, stops of the emergency reset, everything started."""
        self.is_emergency = False
        for name, mechanism in self.mechanisms.items():
            mechanism.stops.discard("emergency")
            self.tasks[name].take_pointer()
        for task in self.tasks.values():
            task.start()

    def emergency_stop(self) -> None:
        """The robots stop where they are, and their programs with them; T_LINK goes on."""
        self.is_emergency = True
        for name, mechanism in self.mechanisms.items():
            mechanism.stops.add("emergency")
            self.tasks[name].is_running = False

    def lose_pointer(self, task: str) -> None:
        """A program loses its place, its robot stands."""
        self.mechanisms[task].stops.add("emergency")
        self.tasks[task].take_pointer()

    def _output(self, what: str, task: str = "") -> Callable[[], bool]:
        if what == "Emergency Stop" and not task:
            return lambda: self.is_emergency
        if what == "Task Executing" and task in self.setup.tasks:
            return lambda: self.tasks[task].is_running
        raise InputError(f"there is no system output {what!r} of {task or 'the controller'}")

    def _write(self, task: str, text: str) -> None:
        self.written.append(text)
        del self.written[:-MOST_LINES]
        log.info("%s: %s", task, text)

    # -- the loop

    def run(self) -> None:
        """Run the programs until `stop`.

        Raises:
            WorkbenchError: the controller failed in itself.
        """
        self._seen = self.clock()
        for task in self.tasks.values():
            task.start()
        try:
            while not self._over.is_set():
                self.turn()
        except Exception as error:
            log.exception("the controller failed")
            raise WorkbenchError(f"the controller failed: {error!r}") from error
        finally:
            self._over.set()
            for task in self.tasks.values():
                task.take_pointer()
            self.network.close()

    def turn(self) -> None:
        """Everybody's turn once; waits when there is nothing to do."""
        while self._orders:
            act, done = self._orders.pop(0)
            act()
            done.set()
        went_on = self._run_ready(list(self.tasks.values()))
        self._due += (self.clock() - self._seen) * self._speed
        self._seen = self.clock()
        movers = [self.tasks[name] for name in self.mechanisms]
        steps = 0
        # A robot's time stands still while its program has something to do: a fast robot must not
        # find its next way missing because this machine was slow.
        while self._due >= TIME_STEP and steps < MOST_STEPS and not self._holds(movers):
            self._due, steps = self._due - TIME_STEP, steps + 1
            self.advance()
        self._due = min(self._due, self._speed)
        self._help()
        if not went_on and self._due < TIME_STEP:
            self.network.idle(self._rest())

    def _holds(self, movers: Sequence[Task]) -> bool:
        """Let programs of robots run; whether one still has something to do, but not for ever."""
        self._held = self._held + 1 if self._run_ready(movers) else 0
        if self._held == MOST_HELD:
            log.warning("a program of a robot does not wait: robots go on meanwhile")
        return 0 < self._held < MOST_HELD

    def _run_ready(self, tasks: Sequence[Task]) -> bool:
        ready = [task for task in tasks if task.is_ready()]
        for task in ready:
            task.resume()
        return bool(ready)

    def advance(self) -> None:
        """One step of the robots' time."""
        self.time += TIME_STEP
        wrong = pair(list(self.mechanisms.values()))
        if wrong != self._warned:
            self._warned = wrong
            log.warning("%s", wrong or "synchronised movements go on")
        if wrong:
            for mechanism in self.mechanisms.values():
                mechanism.stops.add("emergency")
        for mechanism in self.mechanisms.values():
            mechanism.advance(TIME_STEP)

    def _rest(self) -> float:
        now = self.clock()
        rest = (
            IDLE if all(mechanism.is_standing for mechanism in self.mechanisms.values()) else TICK
        )
        deadlines = [task.deadline for task in self.tasks.values() if task.is_running]
        return max(
            0.0005, min([rest, *(deadline - now for deadline in deadlines if deadline is not None)])
        )

    def _help(self) -> None:
        """What the operator does by himself."""
        is_stopped = self.is_emergency or any(
            mechanism.stops for mechanism in self.mechanisms.values()
        )
        if not is_stopped:
            self._stopped_since = None
        elif self._stopped_since is None:
            self._stopped_since = self.clock()
        elif self.clock() - self._stopped_since >= self.operator.comes_after:
            self._stopped_since = None
            self.start_anew()


MAKERS: dict[str, Callable[[str], Any]] = {
    "socketdev": lambda name: Device(),
    "clock": lambda name: Clock(),
    "syncident": lambda name: name,
    "iodev": lambda name: None,
}

"""Tasks of a controller: programs that take turns, as RAPID's multitasking lets them.

Each task has a thread, but only who holds the baton runs: a task gives it back when it has to wait,
and after some hundred statements.  So nothing happens at the same time, and a program that waits
for another one's persistents sees them whole.
"""

import logging
import threading
from collections.abc import Callable, Sequence
from typing import Any

from workbench.formats.rapid.hosts import Key
from workbench.formats.rapid.loading import Loaded
from workbench.formats.rapid.prelude import NUMBERS
from workbench.formats.rapid.problems import PointerMoved, RapidError, RapidStop
from workbench.formats.rapid.symbols import Routine

log = logging.getLogger(__name__)

SLICE = 300
"""Statements after which the next task has its turn."""

MOST_TURNS = 1000
"""That UNDO handlers have, when a pointer is taken out, before they are broken off."""

FOREVER = 8388608.0
"""[s] WAIT_MAX: waiting without end."""


class TimedOut(Exception):
    """What was waited for did not come in time."""


class Interrupts:
    """The interrupts of one task: which trap each calls, and which are due.

    Source: RAPID overview (3HAC050947), "Interrupts": a trap runs between two instructions, or in
    one that waits; IDisable keeps all, ISleep one; those that come meanwhile are kept, or lost.
    """

    def __init__(self) -> None:
        self._traps: dict[int, Routine] = {}
        self._conditions: dict[int, tuple[Callable[[], bool], bool]] = {}
        self._sleeping: set[int] = set()
        self._due: list[int] = []
        self._is_disabled = False

    def connect(self, place: Any, trap: Routine) -> None:
        """Give an interrupt a number and its trap."""
        holder, at = place
        if holder[at] in self._traps:
            raise RapidError("ERR_ALRDYCNT")
        number = max(self._traps, default=0) + 1
        self._traps[number], holder[at] = trap, float(number)

    def order(self, number: float, condition: Callable[[], bool], once: bool) -> None:
        """Let an interrupt come whenever `condition` says so, or once."""
        if int(number) not in self._traps:
            raise RapidError("ERR_UNKINO")
        self._conditions[int(number)] = (condition, once)

    def delete(self, number: float) -> None:
        """IDelete."""
        self._traps.pop(int(number), None)
        self._conditions.pop(int(number), None)
        # The number may be given anew.
        self._sleeping.discard(int(number))
        self._due = [due for due in self._due if due != int(number)]

    def sleep(self, number: float, is_asleep: bool) -> None:
        """ISleep and IWatch: what comes while it sleeps is lost."""
        (self._sleeping.add if is_asleep else self._sleeping.discard)(int(number))

    def disable(self, is_disabled: bool) -> None:
        """IDisable and IEnable: what comes meanwhile is kept."""
        self._is_disabled = is_disabled

    def is_due(self) -> bool:
        """Whether a trap is to run now."""
        for number, (condition, once) in list(self._conditions.items()):
            if condition() and number not in self._sleeping:
                if number not in self._due:
                    self._due.append(number)
                if once:
                    del self._conditions[number]
        return bool(self._due) and not self._is_disabled

    def next(self) -> tuple[int, Routine] | None:
        """The trap that is due now, if any."""
        while self.is_due():
            number = self._due.pop(0)
            if number in self._traps:
                return number, self._traps[number]
        return None


class Task:
    """One program and where it is.

    Lifetime: as long as the controller; `start` begins at main, or goes on after `Stop`.
    Concurrency: `resume` lets the program's thread run until it waits, and returns then; all else
    is called by whoever calls `resume`, or by the program itself.
    """

    def __init__(self, name: str, clock: Callable[[], float], covered: set[Key]) -> None:
        """A task without a program; `clock` is in s, `covered` takes every statement that ran."""
        self.name, self.clock, self._covered = name, clock, covered
        self.loaded: Loaded | None = None
        self.mechanism: Any = None
        self.is_running = False
        self.stopped_by = ""
        self.interrupts = Interrupts()
        self._thread: threading.Thread | None = None
        self._go, self._back = threading.Semaphore(0), threading.Semaphore(0)
        self._fuel = SLICE
        self._condition: Callable[[], Any] | None = None
        self._deadline: float | None = None
        self._found: Any = None
        self._is_cancelled = self._is_trapped = self._is_leaving = False

    # -- from outside

    @property
    def is_alive(self) -> bool:
        """Whether there is a program pointer."""
        return self._thread is not None

    def start(self) -> None:
        """Begin at main, or go on where `Stop` was."""
        if self._thread is None:
            self.interrupts = Interrupts()
            self._condition, self._found, self._is_cancelled = None, None, False
            self._thread = threading.Thread(target=self._main, name=self.name, daemon=True)
            self._thread.start()
        self.is_running, self.stopped_by = True, ""

    def take_pointer(self) -> None:
        """Move the program pointer out: UNDO handlers run, then the task has none.

        One that fails ends there; one that does not end is broken off.
        """
        self._is_leaving, turns = True, MOST_TURNS
        while self.is_alive:
            self._is_cancelled, left = True, turns
            while self.is_alive and left:
                self.resume()
                left -= 1
            if self.is_alive:
                log.warning("%s: an UNDO handler does not end and is broken off", self.name)
                turns = 1
        self._is_leaving = self.is_running = False

    def is_ready(self) -> bool:
        """Whether it has anything to do now."""
        if not self.is_running or self._thread is None:
            return False
        if self._condition is None or (not self._is_trapped and self.interrupts.is_due()):
            return True
        if self._deadline is not None and self.clock() >= self._deadline:
            return True
        # What was found is kept: looking may take something that comes once, as a connection.
        self._found = self._found or self._condition()
        return bool(self._found)

    @property
    def deadline(self) -> float | None:
        """Until when it waits at most."""
        return self._deadline if self._condition is not None else None

    def resume(self) -> None:
        """Let it run until it waits or its turn is over."""
        self._go.release()
        self._back.acquire()

    # -- from the program

    def step(self, key: Key) -> None:
        """A statement begins: turns and interrupts come here."""
        self._covered.add(key)
        self._fuel -= 1
        if self._fuel <= 0:
            self._fuel = SLICE
            self._pause()
        self._trap()

    def wait(self, condition: Callable[[], Any], seconds: float = FOREVER) -> Any:
        """Wait until `condition` is anything but false, and give what it was.

        Raises:
            TimedOut: it was not within this many seconds.
        """
        until = None if seconds >= FOREVER else self.clock() + seconds
        while True:
            found = condition()
            if found:
                return found
            if until is not None and self.clock() >= until:
                raise TimedOut
            self._condition, self._deadline = condition, until
            self._pause()
            self._condition = None
            found, self._found = self._found, None
            self._trap()
            if found:
                return found

    def stop(self) -> None:
        """`Stop`: until the operator presses start."""
        self.is_running = False
        self._pause()

    def hold(self, why: RapidStop) -> None:
        """An error that nothing takes: the pointer stays; start tries the instruction again."""
        if self._is_leaving:
            log.warning("%s: UNDO: %s", self.name, why)
            raise PointerMoved
        self.stopped_by = str(why)
        log.info("%s: %s", self.name, why)
        self.stop()

    def exit(self) -> None:
        """EXIT: the program ends, and begins at main when it is started."""
        self.stopped_by = "EXIT"
        raise PointerMoved

    def connect(self, place: Any, trap: Routine) -> None:
        """CONNECT."""
        self.interrupts.connect(place, trap)

    def set_errno(self, error: RapidError) -> None:
        """ERRNO has the number of the error that a handler begins with."""
        assert self.loaded is not None
        holder, at = self.loaded.globals["errno"].place
        holder[at] = error.number or NUMBERS[error.name]
        log.debug("%s: %s", self.name, error)

    def _pause(self) -> None:
        self._back.release()
        self._go.acquire()
        if self._is_cancelled:
            self._is_cancelled = False
            raise PointerMoved

    def _trap(self) -> None:
        if self._is_trapped:
            return
        while (found := self.interrupts.next()) is not None:
            number, trap = found
            assert self.loaded is not None
            holder, at = self.loaded.globals["intno"].place
            holder[at] = float(number)
            self._is_trapped = True
            try:
                trap.call([])
            finally:
                self._is_trapped = False

    def _main(self) -> None:
        self._go.acquire()
        try:
            assert self.loaded is not None
            if not self._is_cancelled:
                self.loaded.find("main").call([])
                self.stopped_by = "the program has ended"
        except PointerMoved:
            self.stopped_by = self.stopped_by or "the program pointer was moved"
        except (RapidError, RapidStop) as error:
            self.stopped_by = f"nothing handles {error}"
        except Exception as error:  # the thread's rim: whoever resumes must not wait for ever
            log.exception("%s: the interpreter failed", self.name)
            self.stopped_by = f"the interpreter failed: {error!r}"
        finally:
            log.info("%s: %s", self.name, self.stopped_by)
            self.is_running, self._thread = False, None
            self._back.release()


class Meetings:
    """Rendezvous by name: WaitSyncTask, SyncMoveOn, SyncMoveOff.

    Source: Application manual MultiMove (3HAC050961): each task waits until all of the list have
    come to the same syncident; names of the data count, not the data.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = set(names)
        self._came: dict[tuple[str, str], int] = {}

    def wait(self, task: Task, ident: str, with_whom: Sequence[str], seconds: float) -> None:
        """Wait for the others.

        Raises:
            TimedOut: they did not come; this task has not come then, either.
            RapidStop: the list of tasks cannot be.
        """
        if task.name not in with_whom or not set(with_whom) <= self._names:
            raise RapidStop(f"the tasks {', '.join(with_whom)} cannot meet from {task.name}")
        mine = (ident, task.name)
        self._came[mine] = turn = self._came.get(mine, 0) + 1

        def all_here() -> bool:
            return all(self._came.get((ident, name), 0) >= turn for name in with_whom)

        try:
            task.wait(all_here, seconds)
        except BaseException:
            if not all_here():
                self._came[mine] -= 1
            raise

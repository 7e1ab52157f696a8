"""Instructions that wait, measure time, interrupt, signal, and talk to the operator.

Source: Technical reference manual: RAPID instructions, functions and data types (3HAC050917).
"""

# The prelude gives the types of what natives take, and every call is checked against it.
# pyright: reportUnknownLambdaType=false

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from workbench.devices.rapid.tasks import FOREVER, Meetings, Task, TimedOut
from workbench.formats.rapid.problems import RapidError, RapidStop
from workbench.formats.rapid.texts import check_length
from workbench.formats.rapid.values import Place, single

SHORTEST_POLL = 0.004
"""[s] Between two looks of WaitUntil; the longest, which holds without \\PollRate, is 0.1."""

USUAL_POLL = 0.1


@dataclass
class Clock:
    """A stopwatch of RAPID."""

    total: float = 0.0
    since: float | None = None

    def read(self, now: float) -> float:
        """How long it has run [s]."""
        return self.total + (0.0 if self.since is None else now - self.since)


@dataclass
class Signals:
    """Digital outputs by small name; those in `made` are system outputs, made of what is."""

    values: dict[str, float] = field(default_factory=dict[str, float])
    made: dict[str, Callable[[], bool]] = field(default_factory=dict[str, Callable[[], bool]])

    def get(self, name: str) -> float:
        """DOutput."""
        made = self.made.get(name.lower())
        return float(made()) if made is not None else self.values.get(name.lower(), 0.0)

    def set(self, name: str, value: float) -> None:
        """SetDO; a system output is not a program's to set."""
        if name.lower() in self.made:
            raise RapidStop(f"{name} is a system output")
        self.values[name.lower()] = float(value != 0)


Asked = Callable[[str, str, Sequence[str]], int | None]
"""Task, question and keys; the key that the operator has pressed, from 1 on, None for not yet."""


class Waiting:
    """These instructions, for one task."""

    def __init__(
        self,
        task: Task,
        meetings: Meetings,
        signals: Signals,
        asked: Asked,
        written: Callable[[str, str], None],
    ) -> None:
        self._task, self._meetings, self._signals = task, meetings, signals
        self._asked, self._written = asked, written
        self._sync: list[str] = []

    def natives(self) -> dict[str, Callable[..., Any]]:
        """By small name."""
        task, signals, interrupts = self._task, self._signals, lambda: self._task.interrupts
        return {
            "clkreset": self._reset,
            "clkstart": self._start,
            "clkstop": self._stop,
            "clkread": lambda place: single(round(_clock(place).read(task.clock()), 3)),
            "waittime": self._wait_time,
            "waituntil": self._wait_until,
            "waitdo": lambda signal, value, time, flag: self._wait_until(
                None, lambda: signals.get(signal) == value, time, flag, SHORTEST_POLL
            ),
            "waitsynctask": self._meet,
            "syncmoveon": self._sync_on,
            "syncmoveoff": self._sync_off,
            "syncmoveundo": self._sync_undo,
            "issyncmoveon": lambda: bool(self._sync),
            "stop": lambda no_regain: task.stop(),
            "break": task.stop,
            "tpwrite": self._write,
            "tperase": lambda: None,
            "tpreadfk": self._ask,
            "setdo": signals.set,
            "set": lambda signal: signals.set(signal, 1.0),
            "reset": lambda signal: signals.set(signal, 0.0),
            "doutput": signals.get,
            "itimer": self._timer,
            "isignaldo": self._signal,
            "idelete": lambda place: interrupts().delete(place[0][place[1]]),
            "isleep": lambda place: interrupts().sleep(place[0][place[1]], True),
            "iwatch": lambda place: interrupts().sleep(place[0][place[1]], False),
            "idisable": lambda: interrupts().disable(True),
            "ienable": lambda: interrupts().disable(False),
        }

    # -- clocks and waits

    def _reset(self, place: Place) -> None:
        clock = _clock(place)
        clock.total = 0.0
        clock.since = None if clock.since is None else self._task.clock()

    def _start(self, place: Place) -> None:
        clock = _clock(place)
        clock.since = self._task.clock() if clock.since is None else clock.since

    def _stop(self, place: Place) -> None:
        clock = _clock(place)
        clock.total, clock.since = clock.read(self._task.clock()), None

    def _in_position(self) -> None:
        if self._task.mechanism is None:
            raise RapidStop("\\InPos is for tasks that move a robot")
        self._task.wait(lambda: self._task.mechanism.is_standing)

    def _wait_time(self, in_position: bool | None, seconds: float) -> None:
        if in_position:
            self._in_position()
        try:
            self._task.wait(lambda: None, max(seconds, 0.0))
        except TimedOut:
            return

    def _wait_until(
        self,
        in_position: bool | None,
        condition: Callable[[], bool],
        most: float | None,
        flag: Place | None,
        poll: float | None,
    ) -> None:
        if in_position:
            self._in_position()
        clock, every = self._task.clock, max(SHORTEST_POLL, USUAL_POLL if poll is None else poll)
        until = clock() + (FOREVER if most is None else most)
        # The condition may call routines, so it is computed where the program runs.
        while not (is_met := condition()) and clock() < until:
            self._wait_time(None, min(every, until - clock()))
        is_late = not is_met
        if flag is not None:
            flag[0][flag[1]] = is_late
        elif is_late:
            raise RapidError("ERR_WAIT_MAXTIME")

    # -- other tasks

    def _meet(
        self,
        in_position: bool | None,
        ident: Place,
        tasks: Place,
        seconds: float | None,
    ) -> None:
        if in_position:
            self._in_position()
        self._find_condition(ident, _names(tasks), seconds, "ERR_WAITSYNCTASK")

    def _find_condition(
        self, ident: Place, names: list[str], seconds: float | None, error: str
    ) -> None:
        most = FOREVER if seconds is None else seconds
        try:
            self._meetings.wait(self._task, ident[0][ident[1]], names, most)
        except TimedOut:
            raise RapidError(error) from None

    def _sync_on(self, ident: Place, tasks: Place, seconds: float | None) -> None:
        if self._sync:
            raise RapidStop("SyncMoveOn: movements are synchronised already")
        self._in_position()
        names = _names(tasks)
        self._find_condition(ident, names, seconds, "ERR_SYNCMOVEON")
        self._sync, self._task.mechanism.is_in_step = names, True

    def _sync_off(self, ident: Place, seconds: float | None) -> None:
        if not self._sync:
            raise RapidStop("SyncMoveOff: movements are not synchronised")
        self._in_position()
        self._find_condition(ident, self._sync, seconds, "ERR_SYNCMOVEOFF")
        self._sync_undo()

    def _sync_undo(self) -> None:
        self._sync = []
        if self._task.mechanism is not None:
            self._task.mechanism.is_in_step = False

    # -- operator and interrupts

    def _write(self, text: str, number: float | None, is_it: bool | None) -> None:
        end = "" if number is None else f"{number:g}"
        end = end if is_it is None else str(is_it).upper()
        self._written(self._task.name, check_length(text + end))

    def _ask(self, answer: Place, text: str, *rest: Any) -> None:
        *keys, most = rest
        try:
            pressed = self._task.wait(
                lambda: self._asked(self._task.name, text, keys),
                FOREVER if most is None else most,
            )
        except TimedOut:
            raise RapidError("ERR_TP_MAXTIME") from None
        if not keys[pressed - 1]:
            raise RapidStop(f"TPReadFK: key {pressed} has no text")
        answer[0][answer[1]] = float(pressed)

    def _timer(self, single_: Any, safe: Any, seconds: float, place: Place) -> None:
        if seconds < (0.01 if single_ or safe else 0.1):
            raise RapidStop(f"ITimer: {seconds:g} s is too short")
        clock, due = self._task.clock, self._task.clock() + seconds

        def rings() -> bool:
            nonlocal due
            if clock() < due:
                return False
            due += seconds
            return True

        self._task.interrupts.order(place[0][place[1]], rings, bool(single_ or safe))

    def _signal(self, single_: Any, safe: Any, signal: str, value: float, place: Place) -> None:
        before = self._signals.get(signal)

        def changes() -> bool:
            nonlocal before
            last, before = before, self._signals.get(signal)
            return last != before == value

        self._task.interrupts.order(place[0][place[1]], changes, bool(single_ or safe))


def _clock(place: Place) -> Clock:
    return place[0][place[1]]


def _names(tasks: Place) -> list[str]:
    return [task[0] for task in tasks[0][tasks[1]]]

"""Commands of a PLC by their numbers, and the result of the last one.

A PLC neither approves plans nor acknowledges faults: a person does, by a login, and Modbus has no
logins.
"""

import logging
import secrets
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

from workbench.app.core.cell.bins import ChooseBin, NewBin, bin_numbered
from workbench.app.core.cell.kits import NewKit
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.cell.views import ChooseView
from workbench.app.core.command import Command
from workbench.app.core.control import ReleaseControl, TakeControl
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.empty_hand import PlanView
from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, scan_of_pile
from workbench.app.core.cycle.sending import SendPlan, Stop
from workbench.app.core.people import Role
from workbench.app.core.state import Phase, State
from workbench.app.runtime.bench import Bench
from workbench.extras.modbus.registers import (
    ACTOR,
    HIGHEST_VALUE,
    MAP_VERSION,
    Register,
    plan_words,
)
from workbench.model.derived.by_view import views_of
from workbench.model.errors import WorkbenchError
from workbench.model.robot import HOME

log = logging.getLogger(__name__)


class Answer(IntEnum):
    """The progress of the last command."""

    NONE = 0
    RUNNING = 1
    DONE = 2
    NOT_DONE = 3


class Error(IntEnum):
    """Why the last command was not carried out."""

    NONE = 0
    COMMAND = 1
    ARGUMENT = 2
    FAULT = 3
    CONTROL = 4
    NOT_NOW = 5
    NO_RESULT = 6
    INTERNAL = 7


@dataclass(frozen=True, slots=True)
class Job:
    """A command: `make` makes it from the state and two arguments; None: they are wrong.

    `brings` is the field of the state that its task renews; empty: the command starts no task.
    """

    make: Callable[[State, int, int], Command | None]
    brings: str = ""


def _scan(state: State, parts: int, new: int) -> TakeScan | None:
    if new not in (0, 1):
        return None
    return scan_of_pile(state, parts or None, drops_new=bool(new))


def _find(state: State, _a: int, _b: int) -> FindParts:
    return FindParts(state.number)


def _plan(state: State, _a: int, _b: int) -> MakePlan:
    return MakePlan("", None, state.number)


def _go_on(state: State, parts: int, new: int) -> GoOn | None:
    scan = _scan(state, parts, new)
    return None if scan is None else GoOn(scan, _find(state, 0, 0), _plan(state, 0, 0))


def _send(state: State, high: int, low: int) -> SendPlan | None:
    if state.plan is None or (high, low) != plan_words(state):
        return None
    return SendPlan(state.plan.digest)


def _report(is_picked: bool) -> Callable[[State, int, int], ReportPick | None]:
    return lambda _state, part, _: ReportPick(part - 1, is_picked) if part else None


def _choose_bin(state: State, number: int, _: int) -> ChooseBin | None:
    name = bin_numbered(state, number)
    return None if name is None else ChooseBin(name)


def _new_bin(state: State, number: int, _: int) -> NewBin | None:
    name = bin_numbered(state, number) if number else None
    return None if name is None else NewBin(name)


def _choose_view(state: State, number: int, _: int) -> ChooseView | None:
    views = views_of(state.cell)
    return ChooseView(views[number - 1].name) if 0 < number <= len(views) else None


def _plain(make: Callable[[], Command]) -> Job:
    return Job(lambda _state, _a, _b: make())


JOBS: Mapping[int, Job] = {
    1: Job(_scan, "scan"),
    2: Job(_find, "detections"),
    3: Job(_plan, "plan"),
    7: Job(_report(True)),
    8: Job(_report(False)),
    10: _plain(Stop),
    11: Job(lambda _state, number, _: ChooseRecipe(number)),
    12: _plain(NewKit),
    13: Job(_choose_bin),
    14: Job(_new_bin),
    15: Job(_choose_view),
    16: Job(lambda _state, _a, _b: PlanView(), "plan"),
    17: Job(lambda _state, _a, _b: PlanView(HOME), "plan"),
    20: Job(_send),
    21: Job(_go_on, "plan"),
    22: _plain(CancelJob),
    23: _plain(TakeControl),
    24: _plain(ReleaseControl),
}
"""The pick server uses the same numbers below 12."""


@dataclass(frozen=True, slots=True)
class Answered:
    """The last command: its counter, its number, its progress and its error."""

    counter: int = 0
    command: int = 0
    answer: Answer = Answer.NONE
    error: Error = Error.NONE


@dataclass(frozen=True, slots=True, eq=False)
class Awaited:
    """The field that a running task renews, and the state before the task."""

    brings: str
    before: State

    def is_in(self, state: State) -> bool:
        """Whether a state has a new value of the field."""
        found = getattr(state, self.brings)
        is_new = bool(found) and found is not getattr(self.before, self.brings)
        return is_new and state.phase in (Phase.SCANNED, Phase.LOCALIZED, Phase.PLANNED)


class Jobs:
    """Gives the commands of a PLC to the bench, each counter once.

    Lifetime: from construction until `close`.  Concurrency: any thread.
    """

    def __init__(self, bench: Bench) -> None:
        """Start without a command; the number of the session is random."""
        self.session = secrets.randbelow(HIGHEST_VALUE) + 1
        self.answered = Answered()
        self._given: tuple[int, ...] = ()
        self._bench, self._lock = bench, threading.Lock()
        self._waits: Awaited | None = None
        self.close = bench.subscribe(lambda _old, _new: self._look())

    def values(self) -> dict[int, int]:
        """The values of the handshake's registers."""
        last = self.answered
        return {
            Register.VERSION: MAP_VERSION,
            Register.SESSION: self.session,
            Register.LIFE: int(time.monotonic()) & HIGHEST_VALUE,
            Register.COUNTER_ANSWERED: last.counter,
            Register.COMMAND_ANSWERED: last.command,
            Register.ANSWER: last.answer,
            Register.ERROR: last.error,
        }

    def give(self, words: Sequence[int]) -> bool:
        """Carry out a command; a repetition of the last one changes nothing.

        Returns:
            Whether the words name this session and the next counter, or repeat the last words.
        """
        _, number, first, second, counter = words
        with self._lock:
            if words[Register.SESSION_MEANT] != self.session:
                return False
            last = self.answered.counter
            if counter != last % HIGHEST_VALUE + 1:
                # With equal counters two programs would each take the other's answer.
                return counter == last and tuple(words) == self._given
            self._waits, self._given = None, tuple(words)
            self.answered = Answered(counter, number, Answer.RUNNING)
        before = self._bench.state
        error = self._do(number, first, second)
        with self._lock:
            if counter != self.answered.counter:
                return True
            if error is not Error.NONE:
                self.answered = replace(self.answered, answer=Answer.NOT_DONE, error=error)
            elif brings := JOBS[number].brings:
                self._waits = Awaited(brings, before)
            else:
                self.answered = replace(self.answered, answer=Answer.DONE)
        # The task may have ended already.
        self._look()
        return True

    def _do(self, number: int, first: int, second: int) -> Error:
        if number not in JOBS:
            return Error.COMMAND
        command = JOBS[number].make(self._bench.state, first, second)
        if command is None:
            return Error.ARGUMENT
        try:
            self._bench.do(command, ACTOR, Role.OPERATOR)
        except WorkbenchError as error:
            log.info("refused the command %d over Modbus: %s", number, error)
            return _why(self._bench.state)
        except Exception:
            # A rim: the failure of one command must not end the server.
            log.exception("the command %d over Modbus failed", number)
            return Error.INTERNAL
        return Error.NONE

    def _look(self) -> None:
        """Note the end of the task of the last command."""
        with self._lock:
            # The observer's state may be older than the command.
            state = self._bench.state
            if self._waits is None or state.job is not None or state.ahead is not None:
                return
            done = replace(self.answered, answer=Answer.DONE)
            lacks = replace(self.answered, answer=Answer.NOT_DONE, error=Error.NO_RESULT)
            self.answered, self._waits = done if self._waits.is_in(state) else lacks, None


def _why(state: State) -> Error:
    if state.phase is Phase.FAULT:
        return Error.FAULT
    return Error.CONTROL if state.control not in ("", ACTOR) else Error.NOT_NOW

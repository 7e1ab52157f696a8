"""A recorded session to be viewed, moment by moment: what the page shows instead of a bench."""

import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Never

from workbench.app.core.command import Command
from workbench.app.core.people import Role
from workbench.app.core.state import State
from workbench.app.records.replay import replay
from workbench.app.records.sessions import cell_of
from workbench.app.runtime.live import Live
from workbench.journal.journal import Journal, Row
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused

MOST_SCANS = 40
"""The newest scans are kept in memory; what was before is shown without them."""


@dataclass(frozen=True, slots=True)
class Moment:
    """An entry without what it holds: its number, time [s since the epoch], actor and kind."""

    number: int
    at: float
    actor: str
    kind: str


class History:
    """All states of a session, one of which is shown; nothing can be done here.

    Lifetime: the journal has to stay open.

    Concurrency: any thread may call anything; observers are called by whoever calls `go`.
    """

    def __init__(self, journal: Journal):
        """Compute every state, and show the last one.

        Raises:
            JournalError: the journal cannot be computed again; see `replay`.
        """
        self.cell: Cell = cell_of(journal)
        self.live = Live()
        self._journal = journal
        self._moments = _moments(journal, self.cell)
        self._number = len(self._moments) - 1
        self._observers: list[Callable[[State, State], None]] = []
        self._lock = threading.Lock()

    @property
    def count(self) -> int:
        """How many moments there are."""
        return len(self._moments)

    @property
    def moments(self) -> Sequence[tuple[Moment | None, State]]:
        """All of them in order, each with the state that it led to; the first is the beginning."""
        return self._moments

    @property
    def number(self) -> int:
        """Which one is shown, from 0."""
        return self._number

    @property
    def state(self) -> State:
        """The state at the moment that is shown."""
        return self._moments[self._number][1]

    @property
    def entry(self) -> Moment | None:
        """The entry that led there; None at the beginning of the session."""
        return self._moments[self._number][0]

    def go(self, number: int) -> None:
        """Show another moment; numbers beyond the ends are the ends."""
        with self._lock:
            before = self.state
            self._number = min(max(number, 0), self.count - 1)
            observers = tuple(self._observers)
        for observer in observers:
            observer(before, self.state)

    def do(self, command: Command, actor: str, role: Role = Role.ENGINEER) -> Never:
        """Refuse.

        Raises:
            CommandRefused: always.
        """
        raise CommandRefused("this is a recorded session: it is read-only")

    def entries(self, after: int = 0) -> Iterator[Row]:
        """What is on record after the entry with that number."""
        return self._journal.entries(after)

    def subscribe(self, callback: Callable[[State, State], None]) -> Callable[[], None]:
        """Have `callback(old, new)` called when another moment is shown; returns what ends it."""
        with self._lock:
            self._observers.append(callback)

        def unsubscribe() -> None:
            with self._lock:
                if callback in self._observers:
                    self._observers.remove(callback)

        return unsubscribe


def _moments(journal: Journal, cell: Cell) -> list[tuple[Moment | None, State]]:
    first = State(cell, number=1, saved=cell.digest, message="the session begins")
    moments: list[tuple[Moment | None, State]] = [(None, first)]
    begins: deque[int] = deque()
    for entry, state in replay(journal, cell):
        if state.scan is not None and state.scan is not moments[-1][1].scan:
            begins.append(len(moments))
        kind = type(entry.command).__name__
        moments.append((Moment(entry.number, entry.at, entry.actor, kind), state))
        if len(begins) > MOST_SCANS:
            _forget_scan(moments, begins.popleft())
    return moments


def _forget_scan(moments: list[tuple[Moment | None, State]], begin: int) -> None:
    scan = moments[begin][1].scan
    for number in range(begin, len(moments)):
        entry, state = moments[number]
        if state.scan is not scan:
            return
        moments[number] = (entry, replace(state, scan=None))

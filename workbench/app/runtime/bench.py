"""The bench: here commands become states, one at a time, each recorded in the journal."""

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from workbench.app.core.command import Command, Entry
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.empty_hand import PlanStir, PlanView
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import SightPlate, TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Stop
from workbench.app.core.decide import NOT_REPORTED, check_allowed, decide
from workbench.app.core.drop_back import PlanDropBack
from workbench.app.core.effects import Effect, StopSending
from workbench.app.core.people import MACHINES, ROBOT_LINK, SESSION_START, WORKER, Role
from workbench.app.core.session import Opened, Started
from workbench.app.core.state import Phase, State
from workbench.app.core.verifying import ScanBalls
from workbench.app.picking.facts import check_installed, with_facts
from workbench.app.records.record import CommandForm, command_form, entry_record
from workbench.app.records.replay import replay
from workbench.app.records.sessions import begin
from workbench.app.records.vote_ages import VoteAges
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.live import Live
from workbench.app.runtime.observers import Observer, ObserverThread
from workbench.app.runtime.robot_link import Clock, Do
from workbench.app.runtime.worker import Question
from workbench.journal.journal import Journal, Row
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, JournalError, NotRecorded, WorkbenchError
from workbench.model.messages.work import JobText, LinkText


class Effects(Protocol):
    """Carries out effects.  `run` returns at once; results come back as commands."""

    @property
    def live(self) -> Live:
        """Live data for display."""
        ...

    def run(self, effect: Effect) -> None:
        """Start an effect, without a call of `do`.

        The bench starts one effect at a time; only a stop may come meanwhile.
        """
        ...

    def ask(self, question: Question) -> None:
        """Have a question answered between the jobs; returns at once."""
        ...

    def close(self) -> None:
        """End everything; the robot first."""
        ...


FROM_A_VIEW = (
    TakeScan, UseScan, SightPlate, ScanBalls, GoOn, JobEnded, MakePlan, PlanView, PlanStir,
)  # fmt: skip
"""Commands whose rules compare the joints with the view of a scanner on an arm."""

STOP_WAITS = 0.02
"""[s] Longest wait of a stop for each lock before it acts."""


class Bench:
    """Carries out commands, one at a time, and sends the newest state to its observers.

    Lifetime: from construction until `close`, which also closes the journal.  With an empty journal
    a session begins.  With entries the session continues, and the bench records the end of an
    interrupted job.  An interrupted sending becomes a fault: the robot's progress is unknown.
    Votes and approvals end, too: they are valid only in the bench that received them.

    Concurrency: any thread may call any method, except that an observer may not call `close`.
    Commands wait for each other and for one append to the journal, never for jobs.  Each observer
    has its own thread, so a slow observer misses intermediate states and delays nobody.  `state`,
    `live`, `head`, `wait`, `subscribe` and `stop_sending` never wait for the disk, and a stop acts
    before its record is written; `__init__` describes the locks.
    """

    def __init__(
        self,
        cell: Cell,
        journal: Journal,
        *,
        now: Clock = time.time,
        steady: Clock = time.monotonic,
        effects: Callable[[Cell, Do, Clock], Effects] = EffectRunner,
        start: Started | None = None,
    ) -> None:
        """Begin or continue a session.

        Args:
            cell: the cell of the session.
            journal: the journal of the session; `close` closes it.
            now: returns seconds since the epoch; the only input besides commands and actors.
            steady: returns monotonic seconds, which also limit the validity of a vote.
            effects: makes the object that carries out effects.
            start: command that states the installation, recorded first; None: no such record.

        Raises:
            JournalError: the journal cannot be written, another program writes to it, or its
                entries do not fit.
            CommandRefused: the end of an interrupted job or sending cannot be written.
        """
        self.cell = cell
        self._journal = journal
        self._now = now
        # Three locks, acquired in this order.  `_stopping`: a stop holds it until its record is
        # written, and the end of the link waits for it.  `_recording`: held during rules, decision,
        # one append and the start of effects, so as long as the disk takes.  `_news`: held for
        # moments, to read or change state, head and observers; its holder waits for nothing.  Code
        # that must work while the disk hangs acquires `_news` alone, or no lock.
        self._stopping = threading.RLock()
        self._recording = threading.RLock()
        self._news = threading.Condition()
        self._observers: list[ObserverThread] = []
        self._is_ending = False
        self._is_closed = False
        self._ages = VoteAges(steady)
        self._effects: Effects | None = None
        journal.claim(now())
        if journal.count == 0:
            begin(journal, cell, now())
        self._state = State(cell, number=journal.count, saved=cell.digest)
        for _, state in replay(journal, cell, is_judged=False):
            self._state = state
        self._head = journal.count, journal.head
        self._end_what_was_interrupted()
        if start is not None:
            self.do(start, SESSION_START)
        self._effects = effects(self._state.cell, self.do, now)

    @property
    def state(self) -> State:
        """The newest state."""
        return self._state

    @property
    def folder(self) -> Path:
        """The folder of the session; its parent holds the other sessions."""
        return self._journal.folder

    @property
    def live(self) -> Live:
        """Live data for display, which is not recorded and decides nothing."""
        return Live() if self._effects is None else self._effects.live

    def do(self, command: Command, actor: str, role: Role = Role.ENGINEER) -> State:
        """Carry out a command, or refuse it and change nothing.

        Args:
            command: the request of a person, or the report of a machine.
            actor: name of the person, or one of `people.MACHINES`.
            role: role of the person; commands typed at this machine have the highest.

        Returns:
            The state after the command.

        Raises:
            CommandRefused: the rules refuse it, or it could not be recorded (`NotRecorded`).
        """
        if isinstance(command, Stop):
            return self._stop(command, actor, role)
        if isinstance(command, LinkEnded):
            with self._stopping:
                pass  # a stop that has caused this end is recorded first
        joints = self.live.joints if self._asks_for_joints(command) else NOT_REPORTED
        # Checked before anything uses the values, which may be of any type.
        check_allowed(self._state, command, actor, self._now(), joints, role)
        check_installed(self._state, command)
        return self._carry_out(command, actor, role, joints)

    def _stop(self, command: Stop, actor: str, role: Role) -> State:
        """Stop the robot, then record the stop: another command may hold the lock for long."""
        is_first = self._stopping.acquire(timeout=STOP_WAITS)
        is_held = self._recording.acquire(timeout=STOP_WAITS)
        if not is_held and self._state.phase is not Phase.SENDING:
            # The command that is being recorded may be the sending that this stop is for.
            is_held = self._recording.acquire()
        try:
            check_allowed(self._state, command, actor, self._now(), role=role)
            self._run((StopSending(),))
            return self._carry_out(command, actor, role, NOT_REPORTED)
        finally:
            if is_held:
                self._recording.release()
            if is_first:
                self._stopping.release()

    def _carry_out(
        self, command: Command, actor: str, role: Role, joints: Mapping[str, float]
    ) -> State:
        """Record a command, then start its effects; see `do`."""
        command = with_facts(self._state, command)
        # A scan takes long to encode and to write: done without a lock, so no stop waits for it.
        form = command_form(command)
        self._keep(form)
        with self._recording:
            if self._is_ending and actor not in MACHINES:
                raise CommandRefused(JobText.CLOSING())
            before, now = self._state, self._now()
            check_allowed(before, command, actor, now, joints, role)
            lapse = self._ages.find_lapse(before, now)
            if lapse is not None and isinstance(command, SendPlan):
                raise CommandRefused(lapse)
            if lapse is not None and isinstance(command, LinkEnded) and before.row:
                # Expired votes release no further plan of a row.
                command = replace(command, row_ends=lapse)
                form = command_form(command)
            entry = Entry(before.number + 1, now, actor, command, joints, role)
            after, effects = decide(before, entry)
            record = entry_record(entry, form, after)
            try:
                if self._journal.count != before.number:
                    raise JournalError("somebody else has written to it")
                self._journal.append(record.kind, record.body, record.files)
            except JournalError as error:
                if isinstance(command, Stop):
                    self._run(effects)
                    unrecorded = JobText.STOP_UNRECORDED(error=error.message)
                    raise CommandRefused(unrecorded) from error
                raise NotRecorded(JobText.UNRECORDED(error=error.message)) from error
            self._publish(after)
            self._run(effects)
            if self._is_ending:
                # `stop_sending` waits for no lock, so a sending may have begun after it.
                self._run((StopSending(),))
        return after

    def _keep(self, form: CommandForm) -> None:
        try:
            self._journal.keep(form.files)
        except JournalError as error:
            raise NotRecorded(JobText.UNRECORDED(error=error.message)) from error

    def _asks_for_joints(self, command: Command) -> bool:
        """Whether the rules of a command need the joints, which its entry then records.

        The release of a plan needs them, and a drop back of what an arm holds.  For a scanner on an
        arm its scans and the motion to its view need them, too.
        """
        if self._state.cell.scanner.on_arm is not None and isinstance(command, FROM_A_VIEW):
            return True
        if isinstance(command, LinkEnded):
            return bool(self._state.row) and not command.fault
        return isinstance(command, Approve | SendPlan | PlanDropBack)

    def ask(self, question: Question) -> None:
        """Have a question answered; it is not recorded and changes nothing."""
        if self._effects is not None:
            self._effects.ask(question)

    @property
    def head(self) -> tuple[int, str]:
        """Number and hash of the last entry."""
        return self._head

    def entries(self, after: int = 0) -> Iterator[Row]:
        """The entries after the one with that number, in order.

        Raises:
            JournalError: the journal cannot be read.
        """
        return self._journal.entries(after)

    def wait(self, until: Callable[[State], bool], seconds: float) -> State:
        """The state as soon as `until` holds for it, or as it is after `seconds`."""
        with self._news:
            self._news.wait_for(lambda: until(self._state), seconds)
            return self._state

    def subscribe(self, callback: Observer) -> Callable[[], None]:
        """Call `callback(old, new)` in its own thread whenever the state has changed.

        `old` is the state of the previous call, for the first call the present state.

        Returns:
            A function that ends the subscription; it does not wait for a call in progress.
        """
        with self._news:
            observer = ObserverThread(callback, self._state)
            self._observers.append(observer)

        def unsubscribe() -> None:
            with self._news:
                if observer in self._observers:
                    self._observers.remove(observer)
            observer.close()

        return unsubscribe

    def stop_sending(self) -> None:
        """Stop the robot and refuse further commands of people: the first step of an end.

        Returns at once, also while a disk hangs.
        """
        self._is_ending = True
        if not self._is_closed:
            self._run((StopSending(),))

    def close(self) -> None:
        """Stop the robot and the worker, record that, and end; a second call does nothing."""
        with self._news:
            if self._is_closed:
                return
            self._is_ending = self._is_closed = True
        if self._effects is not None:
            self._effects.close()
        with self._news:
            observers, self._observers = self._observers, []
        for observer in observers:
            observer.close()
        self._journal.close()

    def _publish(self, state: State) -> None:
        self._ages.note(state)
        with self._news:
            self._state = state
            self._head = self._journal.count, self._journal.head
            for observer in self._observers:
                observer.put(state)
            self._news.notify_all()

    def _run(self, effects: tuple[Effect, ...]) -> None:
        # While the constructor records interrupted work as ended, there are no effects yet.
        if self._effects is not None:
            for effect in effects:
                self._effects.run(effect)

    def _end_what_was_interrupted(self) -> None:
        if self._state.job is not None:
            ended = WorkbenchError(JobText.INTERRUPTED())
            self.do(JobEnded(self._state.job.number, ended), WORKER)
        if self._state.phase is Phase.SENDING:
            fault = LinkText.INTERRUPTED()
            self.do(LinkEnded(fault), ROBOT_LINK)
        # A session that has only begun has nothing that could end.
        if self._journal.count > 1:
            self.do(Opened(), SESSION_START)

"""Long computations in one warm worker process, so that no page waits for them.

The worker imports the heavy layers while it is idle and runs one job at a time.  It may die at any
moment: killed after a cancellation that it ignores, by the system, or with this process.  Then a
new worker replaces it.
"""

import logging
import multiprocessing
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext
from typing import Any, assert_never

from workbench.app.runtime.worker import (
    Failure,
    Flag,
    GettingReady,
    Message,
    Progress,
    Question,
    Ready,
    Request,
    Success,
    Unable,
    in_parts,
    pack_cell,
    receive,
    run_worker,
    send,
)
from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, WorkbenchError
from workbench.model.messages.message import Message as MessageText
from workbench.model.messages.states import task_message
from workbench.model.messages.work import JobText

log = logging.getLogger(__name__)

WORK = "workbench.app.runtime.work"
"""The module whose `JOBS` the worker runs."""

GRACE = 0.3
"""[s] Time for a cancelled job to end by itself."""

PACE = 0.08
"""[s] Shortest interval between the starts of two questions, whoever asks them."""

LONGEST_QUESTION = 10.0
"""[s] A question that takes longer ends the worker, so that it does not delay the jobs."""

ATTEMPTS = 3
"""Number of workers in a row that may die at their start; then only a job starts another."""

Ended = Callable[[int, Any], None]
"""Callback with the number of a job and its result, or the `WorkbenchError` that ended it."""

Progressed = Callable[[int, float, MessageText | str], None]
"""Callback with the number of a job, the share done (0..1), and the present activity."""

Prepared = Callable[[GettingReady | None], None]
"""Callback with the progress of the worker's start; None once it accepts jobs."""


class Jobs:
    """Runs jobs one after the other in a warm process, and questions between them.

    Questions are about a thing that a person drags, which is impossible during a job.  So the same
    process answers them, with everything loaded and compiled once.  A job has precedence and waits
    for one question at most.

    Lifetime: the process starts at once and is replaced when it dies.  `close` ends it, and any end
    of this process does.

    Concurrency: any thread may call `start`, `ask`, `cancel` and `close`; the first three return at
    once.  One thread of this object calls `ended`, `progressed` and `prepared`, one call after the
    other; they may call `start` and `cancel`.
    """

    def __init__(
        self,
        cell: Cell,
        ended: Ended,
        progressed: Progressed,
        *,
        prepared: Prepared = lambda what: None,
        module: str = WORK,
    ) -> None:
        """Start the worker.

        Args:
            cell: the cell of all jobs.
            ended: called once for every job, except after `close`.
            progressed: called with the progress of a job.
            prepared: called while the worker gets ready; jobs wait for it.
            module: its `JOBS` maps names to job functions.
        """
        self._ended = ended
        self._progressed = progressed
        self._prepared = prepared
        self._cell = pack_cell(cell)
        self._make_worker = lambda: _Worker(module)
        self._lock = threading.Lock()
        self._waiting: deque[Request] = deque()
        self._questions: dict[int, Question] = {}
        self._to_cancel: list[int] = []
        self._closing = False
        self._woken = False
        self._bell, self._rope = multiprocessing.Pipe(duplex=False)
        # Only the thread uses the following fields.
        self._worker: _Worker | None = None
        self._running: Request | None = None
        self._asked: Question | None = None
        self._asked_count = 0
        self._next_question = 0.0
        self._kill_at: float | None = None
        self._failed_starts = 0
        self._unable: WorkbenchError | None = None
        self._thread = threading.Thread(target=self._run, name="jobs", daemon=True)
        self._thread.start()

    def start(self, number: int, name: str, arguments: Mapping[str, Any]) -> None:
        """Run a job after all earlier jobs."""
        with self._lock:
            self._waiting.append(Request(number, name, arguments, self._cell))
            self._wake()

    def ask(self, question: Question) -> None:
        """Answer a question between jobs; it replaces a waiting question of the same asker."""
        with self._lock:
            # It also takes the place in the queue: frequent questions get no more turns.
            self._questions[question.asker] = question
            self._wake()

    def use(self, cell: Cell) -> None:
        """Use another cell for all jobs from now on."""
        with self._lock:
            self._cell = pack_cell(cell)

    def cancel(self, number: int) -> None:
        """End a job: it may end by itself within `GRACE`; otherwise the worker is killed."""
        with self._lock:
            self._to_cancel.append(number)
            self._wake()

    def close(self) -> None:
        """End the worker and its job, and wait for its end; no callback follows."""
        with self._lock:
            self._closing = True
            self._wake()
        self._thread.join()

    def _wake(self) -> None:
        # One ring at a time: the pipe never fills, so no caller waits.
        if not self._woken:
            self._woken = True
            self._rope.send_bytes(b"!")

    def _run(self) -> None:
        self._attempt(self._replace_worker)
        while not self._closing:
            self._attempt(self._take_turn)
        if self._worker is not None:
            self._worker.kill()

    def _attempt(self, step: Callable[[], None]) -> None:
        try:
            step()
        except Exception as error:
            # For instance no memory to pack a job: the jobs after it still have to run.
            log.exception("the thread of tasks has failed")
            self._begin_anew(error)

    def _take_turn(self) -> None:
        self._follow_cancels()
        self._begin_next()
        self._wait_and_listen()
        if self._kill_at is not None and time.monotonic() >= self._kill_at:
            self._bury()

    def _begin_anew(self, error: Exception) -> None:
        """End the running job, or else all waiting ones; the next job gets a new worker."""
        problem = WorkbenchError(internal_error(error))
        worker, self._worker = self._worker, None
        if self._running is not None:
            self._running_ended(problem)
        else:
            self._refuse_waiting(problem)
        with suppress(Exception):
            if worker is not None:
                worker.kill()

    def _replace_worker(self) -> None:
        self._unable = None
        try:
            self._worker = self._make_worker()
        except OSError as error:  # no memory or no process left
            self._worker = None
            self._refuse_waiting(WorkbenchError(JobText.NO_START(error=str(error))))

    def _wait_and_listen(self) -> None:
        sources = [self._bell] if self._worker is None else [self._bell, self._worker.connection]
        ready = wait(sources, self._patience())
        if self._bell in ready:
            with self._lock:
                self._bell.recv_bytes()
                self._woken = False
        if self._worker is not None and self._worker.connection in ready:
            self._listen(self._worker)

    def _patience(self) -> float | None:
        """Time [s] until the thread has something to do by itself; None: no limit."""
        now = time.monotonic()
        if self._kill_at is not None:
            return max(0.0, self._kill_at - now)
        can_ask = self._worker is not None and self._worker.is_ready and self._running is None
        return max(0.0, self._next_question - now) if can_ask and self._questions else None

    def _follow_cancels(self) -> None:
        with self._lock:
            numbers, self._to_cancel = self._to_cancel, []
            dropped = [request for request in self._waiting if request.number in numbers]
            for request in dropped:
                self._waiting.remove(request)
        for request in dropped:
            self._notify_end(request, _make_cancelled(request.name))
        if self._running is not None and self._running.number in numbers and self._worker:
            self._worker.to_cancel.value = self._running.number
            self._kill_at = time.monotonic() + GRACE

    def _begin_next(self) -> None:
        if self._running is not None or not (self._waiting or self._questions):
            return
        if self._worker is None and self._waiting:
            self._replace_worker()
        elif self._worker is None:
            # A question does not start a worker; the next job does, and reports why it fails.
            self._drop_questions(WorkbenchError(JobText.NO_WORKER()))
        elif self._worker.is_ready:
            with self._lock:
                self._running = self._waiting.popleft() if self._waiting else self._next_asked()
            if self._running is not None:
                self._worker.send(self._running)

    def _next_asked(self) -> Request | None:
        """The question that has waited longest, if one may start now; call it under the lock."""
        now = time.monotonic()
        if now < self._next_question:
            return None
        self._asked = asked = self._questions.pop(next(iter(self._questions)))
        self._next_question, self._kill_at = now + PACE, now + LONGEST_QUESTION
        # A negative number is no job's, so no cancellation of a job ends the question.
        self._asked_count += 1
        return Request(-self._asked_count, asked.name, asked.arguments, self._cell)

    def _drop_questions(self, error: WorkbenchError) -> None:
        with self._lock:
            dropped, self._questions = self._questions, {}
        for question in dropped.values():
            self._notify(question.answered, error)

    def _listen(self, worker: "_Worker") -> None:
        try:
            message = worker.receive()
        except (EOFError, OSError):
            self._bury()
            return
        except Exception as error:
            # Unpacking runs code of the packed objects, which may raise anything.
            log.exception("an answer of the worker process cannot be read")
            problem = JobText.UNREADABLE(kind=type(error).__name__, error=str(error))
            self._running_ended(WorkbenchError(problem))
            return
        match message:
            case GettingReady():
                self._notify(self._prepared, message)
            case Ready():
                worker.is_ready = True
                self._failed_starts = 0
                self._notify(self._prepared, None)
            case Unable(error=error, trace=trace):
                # The worker ends now: see `_bury`.
                log.error("%s\n%s", error, trace)
                self._failed_starts, self._unable = ATTEMPTS, error
            case Progress(number=number, done=done, note=note):
                self._notify(self._progressed, number, done, note)
            case Success(result=result):
                self._running_ended(result)
            case Failure(error=error, trace=trace):
                if trace:
                    log.error("%s\n%s", error, trace)
                self._running_ended(error)
            case _:
                assert_never(message)

    def _bury(self) -> None:
        """End the worker, if it still runs, and replace it."""
        if self._worker is None:
            return
        was_cancelled = self._kill_at is not None
        how = self._worker.kill(patience=0.0 if was_cancelled else GRACE)
        if not self._worker.is_ready:
            self._failed_starts += 1
            self._notify(self._prepared, None)
        if self._running is not None:
            name = self._running.name
            self._running_ended(
                _make_cancelled(name)
                if was_cancelled
                else WorkbenchError(JobText.ENDED(how=how, task=task_message(name)))
            )
        if self._failed_starts < ATTEMPTS:
            self._replace_worker()
        else:
            self._worker = None
            self._failed_starts = ATTEMPTS - 1
            ends = WorkbenchError(JobText.ENDS_AT_START(how=how))
            self._refuse_waiting(self._unable or ends)

    def _running_ended(self, result: Any) -> None:
        if self._running is not None:
            ended, self._running, self._kill_at = self._running, None, None
            self._notify_end(ended, result)

    def _refuse_waiting(self, error: WorkbenchError) -> None:
        with self._lock:
            refused, self._waiting = self._waiting, deque()
        for request in refused:
            self._notify_end(request, error)
        self._drop_questions(error)

    def _notify_end(self, request: Request, result: Any) -> None:
        if request.number > 0:
            self._notify(self._ended, request.number, result)
        elif self._asked is not None:
            asked, self._asked = self._asked, None
            self._notify(asked.answered, result)

    def _notify(self, listener: Callable[..., None], *what: Any) -> None:
        if self._closing:
            return
        try:
            listener(*what)
        except Exception:
            log.exception("a listener to jobs failed")


def internal_error(error: Exception) -> MessageText:
    """The message about an unexpected error; the log has its trace."""
    return JobText.INTERNAL(kind=type(error).__name__, error=str(error))


def _make_cancelled(task: str) -> JobCancelled:
    return JobCancelled(JobText.CANCELLED(task=task_message(task)))


class _Worker:
    """One worker process as its owner sees it; used from one thread."""

    def __init__(self, module: str) -> None:
        context: SpawnContext = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.to_cancel: Flag = context.RawValue("q", 0)
        self.is_ready = False
        self._process = context.Process(
            target=run_worker,
            args=(theirs, module, self.to_cancel),
            name="workbench worker",
            daemon=True,
        )
        self._process.start()
        # If this process held their end, too, it would not notice the end of the worker.
        theirs.close()

    def send(self, request: Request) -> None:
        try:
            send(self.connection, in_parts(request))
        except OSError:
            log.warning("the worker process ended before it could be given a task")

    def receive(self) -> Message:
        return receive(self.connection)

    def kill(self, *, patience: float = 0.0) -> str:
        """End the process, unless it ends by itself within `patience` [s], and say how it ended."""
        self._process.join(patience)
        self._process.kill()
        self._process.join()
        self.connection.close()
        code = self._process.exitcode or 0
        if code >= 0:
            return f"exit code {code}"
        # Most of the signals for real time have no name.
        names = {int(known_signal): known_signal.name for known_signal in signal.Signals}
        return names.get(-code, f"signal {-code}")

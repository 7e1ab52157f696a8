"""The worker process: it runs the jobs, and reports their progress and results.

A job function takes the cell, its arguments, `report` and `cancelled`.  `report(done, note)`
reports the share done (0..1) and the current activity, with any frequency.  `cancelled()` is True
after a cancellation; the function then raises `JobCancelled`.
"""

import contextlib
import importlib
import os
import pickle
import signal
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from typing import Any, Protocol

from workbench.model.cell import Cell
from workbench.model.errors import WorkbenchError
from workbench.model.messages.message import Message as MessageText
from workbench.model.messages.work import JobText
from workbench.plugins.progress import Cancelled, Report

JobFunction = Callable[[Cell, Mapping[str, Any], Report, Cancelled], Any]

REPORT_EVERY = 0.05
"""Shortest interval [s] between progress reports with the same note."""


class Flag(Protocol):
    """A number in shared memory without a lock: a killed process could leave a lock locked."""

    value: int


@dataclass(frozen=True, slots=True, eq=False)
class Request:
    """Request for a job on a packed cell."""

    number: int
    name: str
    arguments: Mapping[str, Any]
    cell: bytes


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """A job that is computed between the others and not recorded, or never begins.

    Attributes:
        asker: identifies who asks; the asker's next question replaces this one if it still waits.
        name, arguments: those of a job.
        answered: receives the result, or the `WorkbenchError` that ended the computation, in a
            thread of the owner; it is never called for a replaced question.
    """

    asker: int
    name: str
    arguments: Mapping[str, Any]
    answered: Callable[[Any], None]


@dataclass(frozen=True, slots=True, eq=False)
class GettingReady:
    """Progress of the work before the first job, when everything is imported.

    `done` (0..1) is the share done, `note` the current activity, for people.
    """

    done: float
    note: MessageText | str


@dataclass(frozen=True, slots=True, eq=False)
class Ready:
    """The worker accepts requests."""


@dataclass(frozen=True, slots=True, eq=False)
class Unable:
    """The worker cannot get ready and ends."""

    error: WorkbenchError
    trace: str


@dataclass(frozen=True, slots=True, eq=False)
class Progress:
    """Progress of a job."""

    number: int
    done: float
    note: MessageText | str


@dataclass(frozen=True, slots=True, eq=False)
class Success:
    """A job's result."""

    number: int
    result: Any


@dataclass(frozen=True, slots=True, eq=False)
class Failure:
    """The error that ended a job; `trace` is for the log, and empty for expected errors."""

    number: int
    error: WorkbenchError
    trace: str = ""


Message = GettingReady | Ready | Unable | Progress | Success | Failure


Parts = tuple[bytes | memoryview, ...]
"""A packed message for the other process, followed by the memory of its large arrays.

Python runs no other thread while it copies bytes, and a scan has a hundred million of them.
"""

LARGE = 2**16
"""[bytes] Larger arrays are not copied."""


def pack_cell(cell: Cell) -> bytes:
    """A packed cell for the other process.

    Pickle's protocol 5 keeps read-only arrays read-only; the older default does not.
    """
    return pickle.dumps(cell, protocol=5)


def in_parts(message: Message | Request) -> Parts:
    """A packed message for the other process; read-only arrays stay read-only."""
    large: list[memoryview] = []

    def stays_inside(buffer: pickle.PickleBuffer) -> bool:
        block = buffer.raw()
        # A writable array stays inside, so that it comes back writable.
        if not block.readonly or block.nbytes < LARGE:
            return True
        large.append(block)
        return False

    head = pickle.dumps(message, protocol=5, buffer_callback=stays_inside)
    return (len(large).to_bytes(4, "big"), head, *large)


def send(connection: Connection, parts: Parts) -> None:
    """Send a message.

    Raises:
        OSError: the other process has ended.
    """
    for part in parts:
        connection.send_bytes(part)


def receive(connection: Connection) -> Any:
    """The next message.

    Raises:
        EOFError, OSError: the other process has ended.
        Exception: whatever unpacking raises; the next message can still be received.
    """
    count = int.from_bytes(connection.recv_bytes(), "big")
    head, *large = (connection.recv_bytes() for _ in range(count + 1))
    return pickle.loads(head, buffers=large)


def run_worker(connection: Connection, module: str, to_cancel: Flag) -> None:
    """The main function of the worker process: get ready, then answer requests.

    Args:
        connection: to the parent process; the worker ends when it is closed.
        module: its `JOBS` maps names to job functions; its import loads the libraries.  `GET_READY`
            of it, if there is one, is called with `report` before the first job.
        to_cancel: number of the cancelled job.
    """
    # Ctrl-C in a terminal reaches both processes; the parent decides what happens.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, name="end with parent", daemon=True).start()
    try:
        # The parent ends a worker by closing the connection.
        with contextlib.suppress(EOFError, OSError):
            _serve(connection, module, to_cancel)
    finally:
        # At once, without the destructors of C++ libraries.
        os._exit(0)


def _serve(connection: Connection, module: str, to_cancel: Flag) -> None:
    try:
        work = importlib.import_module(module)
        jobs: Mapping[str, JobFunction] = work.JOBS
        get_ready: Callable[[Report], object] | None = getattr(work, "GET_READY", None)
        if get_ready is not None:
            get_ready(lambda done, note: send(connection, in_parts(GettingReady(done, note))))
    except Exception as error:
        problem = WorkbenchError(JobText.NOT_READY(error=_describe(error)))
        send(connection, in_parts(Unable(problem, traceback.format_exc())))
        return
    send(connection, in_parts(Ready()))
    # Caches, such as that of the shapes, belong to this very object.
    cell, unpacked = b"", None
    while True:
        request: Request = receive(connection)
        if unpacked is None or request.cell != cell:
            cell, unpacked = request.cell, pickle.loads(request.cell)
        send(connection, _answer(request, unpacked, jobs, connection, to_cancel))


def _answer(
    request: Request,
    cell: Cell,
    jobs: Mapping[str, JobFunction],
    connection: Connection,
    to_cancel: Flag,
) -> Parts:
    number = request.number
    try:
        if request.name not in jobs:
            raise WorkbenchError(JobText.UNKNOWN(name=repr(request.name), known=sorted(jobs)))
        report = _reporter(number, connection)
        result = jobs[request.name](
            cell, request.arguments, report, lambda: to_cancel.value == number
        )
        return in_parts(Success(number, result))
    except WorkbenchError as error:
        return in_parts(Failure(number, error))
    except Exception as error:
        problem = WorkbenchError(JobText.INTERNAL(kind=type(error).__name__, error=str(error)))
        return in_parts(Failure(number, problem, traceback.format_exc()))


def _reporter(number: int, connection: Connection) -> Report:
    last_note: MessageText | str = ""
    next_at = 0.0

    def report(done: float, note: MessageText | str) -> None:
        nonlocal last_note, next_at
        now = time.monotonic()
        if note != last_note or now >= next_at:
            last_note, next_at = note, now + REPORT_EVERY
            send(connection, in_parts(Progress(number, min(max(float(done), 0.0), 1.0), note)))

    return report


def _describe(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)

"""The worker's side of a job: what runs in the process of its own, and what it says.

A job function takes the cell, its arguments, `report` and `cancelled`.  `report(done, note)`
reports the share done (0..1) and what is being done; it may be called as often as one likes.
`cancelled()` is True once somebody has ended the job; the function then raises `JobCancelled`.
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
    """A number in shared memory without a lock, which a killed process could leave locked."""

    value: int


@dataclass(frozen=True, slots=True, eq=False)
class Request:
    """Run this job on a cell, which is packed."""

    number: int
    name: str
    arguments: Mapping[str, Any]
    cell: bytes


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """Something to be worked out between jobs, soon or not at all; nothing of it is on record.

    `asker` names who asks: what they ask next takes the place of what has not begun.  `name` and
    `arguments` are those of a job.  `answered` gets the result, or the `WorkbenchError` that
    ended it, by one thread of the owner; a question that a newer one has replaced never is.
    """

    asker: int
    name: str
    arguments: Mapping[str, Any]
    answered: Callable[[Any], None]


@dataclass(frozen=True, slots=True, eq=False)
class GettingReady:
    """Everything is imported, and something has to be done once before the first job begins.

    `done` (0..1) is the share done, `note` what is being done, for people.
    """

    done: float
    note: MessageText | str


@dataclass(frozen=True, slots=True, eq=False)
class Ready:
    """Requests are welcome."""


@dataclass(frozen=True, slots=True, eq=False)
class Unable:
    """The worker cannot be made ready and ends."""

    error: WorkbenchError
    trace: str


@dataclass(frozen=True, slots=True, eq=False)
class Progress:
    """How far a job is."""

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
    """What ended a job; `trace` is for the log, and empty for errors made on purpose."""

    number: int
    error: WorkbenchError
    trace: str = ""


Message = GettingReady | Ready | Unable | Progress | Success | Failure


Parts = tuple[bytes | memoryview, ...]
"""A message as it goes to the other process: itself, then its large arrays as they lie in memory.

While Python copies bytes no other thread runs, and a scan has a hundred million of them.
"""

LARGE = 2**16
"""[bytes] Arrays with more are not copied."""


def pack_cell(cell: Cell) -> bytes:
    """Bytes of a cell for the other process.

    Protocol 5 brings read-only arrays back as read-only ones; the older default does not.
    """
    return pickle.dumps(cell, protocol=5)


def in_parts(message: Message | Request) -> Parts:
    """A message for the other process, which brings read-only arrays back as read-only ones."""
    large: list[memoryview] = []

    def stays_inside(buffer: pickle.PickleBuffer) -> bool:
        block = buffer.raw()
        # What may be written to has to come back so.
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
        Exception: whatever unpacking raises; the message after it can be received.
    """
    count = int.from_bytes(connection.recv_bytes(), "big")
    head, *large = (connection.recv_bytes() for _ in range(count + 1))
    return pickle.loads(head, buffers=large)


def run_worker(connection: Connection, module: str, to_cancel: Flag) -> None:
    """The worker process: get everything ready, then answer requests until the other side ends.

    Args:
        connection: to the process that started this one.
        module: its `JOBS` maps names to job functions; importing it imports what they need.  Its
            `GET_READY`, if there is one, is called with `report` before the first job.
        to_cancel: number of the job that somebody has ended.
    """
    # Ctrl-C in a terminal reaches the whole group; the other process decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, name="end with parent", daemon=True).start()
    try:
        # The other side closes the connection: that is how a worker's life ends.
        with contextlib.suppress(EOFError, OSError):
            _serve(connection, module, to_cancel)
    finally:
        # Straight out: libraries with C++ destructors have nothing to say here any more.
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
    # Whatever is kept for a cell, such as its shapes, is kept for this very object.
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

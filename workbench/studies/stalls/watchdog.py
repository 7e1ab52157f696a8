"""A watchdog inside a process: it states what holds up its other threads, and for how long.

Python runs one thread at a time.  A call into C that keeps the interpreter to itself stops all the
others, the robot link among them; so does a callback of an event loop for all that the loop serves.
"""

import asyncio
import gc
import json
import sys
import threading
import time
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from types import FrameType
from typing import Any, Literal

from workbench.model.errors import FileError

LEAST_STALL = 0.05
"""[s] Of processor time: what holds the others up for less is no stall."""

POLL_EVERY = 0.01
"""[s] Between two looks."""

MOST_FRAMES = 16
"""Frames of a stack that are reported."""

RUN = "_run"
"""The method by which event loops of asyncio call each callback."""

Kind = Literal["interpreter", "event loop"]


@dataclass(frozen=True, slots=True)
class Stall:
    """One time that others had to wait.

    `seconds` is the processor time that the thread of this name took meanwhile, so a machine that
    is busy with other work makes no stall; `lasted` [s] is what a clock says, `at` when it ended
    [s since 1970].  `where` is the stack of that thread, the innermost frame first.
    """

    kind: Kind
    seconds: float
    lasted: float
    at: float
    thread: str
    where: tuple[str, ...]


class Watchdog:
    """Checks every `POLL_EVERY` whether its thread runs, and times each callback of event loops.

    Lifetime: from construction until `close`.

    Concurrency: its own thread reports stalls of the interpreter; the thread of an event loop
    reports those of the loop.
    """

    def __init__(self, report: Callable[[Stall], None], least: float = LEAST_STALL) -> None:
        """Begin to watch.

        Args:
            report: takes each stall; any thread calls it.
            least: [s] of processor time that make a stall.
        """
        self._told = report
        self._least = least
        self._closing = threading.Event()
        self._running: dict[int, tuple[object, float]] = {}
        self._seen: dict[int, tuple[object, tuple[str, ...]]] = {}
        self._collected = 0.0
        self._collecting = 0.0
        self._run_handle: Any = getattr(asyncio.Handle, RUN)
        setattr(asyncio.Handle, RUN, self._hook())
        gc.callbacks.append(self._note_collection)
        self._thread = threading.Thread(target=self._run, name="watchdog", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Watch no more, and leave everything as it was."""
        self._closing.set()
        self._thread.join()
        setattr(asyncio.Handle, RUN, self._run_handle)
        gc.callbacks.remove(self._note_collection)

    # -- the interpreter -------------------------------------------------------------------

    def _run(self) -> None:
        while not self._closing.is_set():
            before, began, delayed = _processor_times(), time.monotonic(), _delay()
            time.sleep(POLL_EVERY)
            waited = time.monotonic() - began - POLL_EVERY - (_delay() - delayed)
            if waited >= self._least:
                self._look_who(before, waited)
            self._sample_callbacks()
            self._collected = 0.0

    def _look_who(self, before: Mapping[int, float], waited: float) -> None:
        after = _processor_times()
        used = {
            thread_id: seconds - before.get(thread_id, 0.0) for thread_id, seconds in after.items()
        }
        used.pop(threading.get_native_id(), None)
        most = max(used, key=lambda thread_id: used[thread_id], default=None)
        if most is None or min(used[most], waited) < self._least:
            return
        (thread,) = [running for running in threading.enumerate() if running.native_id == most] or [
            None
        ]
        if thread is None:
            return
        where = stack_of(sys._current_frames().get(thread.ident or 0))  # pyright: ignore[reportPrivateUsage]
        if self._collected >= self._least / 2:
            where = (f"garbage collection, {self._collected * 1000:.0f} ms", *where)
        seconds = min(used[most], waited)
        self._told(Stall("interpreter", seconds, waited, time.time(), thread.name, where))

    def _note_collection(self, phase: str, about: Mapping[str, int]) -> None:
        del about
        if phase == "start":
            self._collecting = time.thread_time()
        else:
            self._collected += time.thread_time() - self._collecting

    # -- event loops -----------------------------------------------------------------------

    def _hook(self) -> Callable[[Any], None]:
        run, running, seen, least = self._run_handle, self._running, self._seen, self._least

        def run_and_look(handle: Any) -> None:
            thread = threading.get_ident()
            began, used = time.monotonic(), time.thread_time()
            running[thread] = (handle, began)
            try:
                run(handle)
            finally:
                used = time.thread_time() - used
                running.pop(thread, None)
                sampled, where = seen.pop(thread, (None, ()))
                if used >= least:
                    lasted = time.monotonic() - began
                    name = threading.current_thread().name
                    where = where if sampled is handle else (repr(handle)[:300],)
                    self._told(Stall("event loop", used, lasted, time.time(), name, where))

        return run_and_look

    def _sample_callbacks(self) -> None:
        now = time.monotonic()
        for thread, (handle, began) in tuple(self._running.items()):
            if now - began >= self._least / 2:
                frames = sys._current_frames()  # pyright: ignore[reportPrivateUsage]
                self._seen[thread] = (handle, stack_of(frames.get(thread)))


def stack_of(frame: FrameType | None) -> tuple[str, ...]:
    """The frames of a stack as `file:line function`, the innermost one first."""
    lines: list[str] = []
    while frame is not None and len(lines) < MOST_FRAMES:
        code = frame.f_code
        lines.append(f"{_short(code.co_filename)}:{frame.f_lineno} {code.co_name}")
        frame = frame.f_back
    return tuple(lines)


def _short(file: str) -> str:
    """A file without what lies above its package."""
    parts = Path(file).parts
    for root in ("site-packages", "workbench"):
        if root in parts:
            last = len(parts) - 1 - parts[::-1].index(root)
            return "/".join(parts[last if root == "workbench" else last + 1 :])
    return "/".join(parts[-2:])


def _processor_times() -> dict[int, float]:
    """Processor time [s] of each thread that runs Python, by the system's number of it."""
    found: dict[int, float] = {}
    for thread in threading.enumerate():
        number = thread.native_id
        if number is None:
            continue
        try:
            # The clock of a thread by its number, CPUCLOCK_SCHED: `linux/posix-timers_types.h`.
            found[number] = time.clock_gettime((~number << 3) | 6)
        except OSError:
            continue  # it has ended
    return found


def _delay() -> float:
    """How long [s] this thread was ready, and the machine had no processor for it."""
    try:
        _, waited, _ = Path("/proc/thread-self/schedstat").read_text().split()
    except (OSError, ValueError):
        return 0.0
    return int(waited) / 1e9


@contextmanager
def watch_stalls(path: Path | None) -> Generator[None]:
    """Write each stall of this process into a file as long as the block runs, JSON, one a line.

    Raises:
        FileError: the file cannot be written.
    """
    if path is None:
        yield
        return
    try:
        file = path.open("a", encoding="utf-8", buffering=1)
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be written") from None
    with file:
        dog = Watchdog(lambda stall: print(json.dumps(asdict(stall)), file=file))
        try:
            yield
        finally:
            dog.close()

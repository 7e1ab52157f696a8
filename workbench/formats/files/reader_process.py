"""Files from outside, read by a process of its own: it may crash, hang, or want all the memory.

Then that process ends, and nothing else.  Nor does the process that asks for it stand still: the
one with the page speaks with the robot as well, and large files keep Python to themselves.
"""

import ctypes
import importlib
import json
import logging
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from workbench.formats.files.whole_files import MB
from workbench.model.errors import FileError, InputError, JobCancelled, WorkbenchError
from workbench.model.messages.catalogue import message_of
from workbench.model.messages.files import FileProblem, FileText
from workbench.model.messages.message import Message
from workbench.plugins.progress import Cancelled, never

log = logging.getLogger(__name__)

LONGEST_READING = 120.0
"""[s] Of processor time that reading may take."""

WAITS = 5
"""Times as long as that by the clock, where other processes want the processor too."""

MOST_MEMORY = 6 * 1024 * MB
"""[bytes] Of addresses; what is really used is a fraction of it."""

AT_ONCE = 2
"""Largest number of such processes that run at a time."""

POLL_EVERY = 0.05
"""[s] Interval of the checks whether the result is still wanted."""

PR_SET_PDEATHSIG = 1
"""From `linux/prctl.h`."""

REQUEST_FILE, ANSWER_FILE = "asked.json", "told.json"

_places = threading.BoundedSemaphore(AT_ONCE)


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What comes back: `value` is what JSON can hold, and arrays (..., n), each of its own unit."""

    value: Any = None
    arrays: Mapping[str, np.ndarray] = field(default_factory=dict[str, np.ndarray])


Work = Callable[..., Answer]
"""A function that a module has by its name; it takes a file, then what JSON can hold.

It runs in a folder of its own, which is gone afterwards.
"""

ARRAY_NAME = re.compile(r"\w+", re.ASCII)
"""Of an array that comes back."""


def apart(
    path: Path,
    work: Work,
    *arguments: Any,
    longest: float = LONGEST_READING,
    most_memory: int = MOST_MEMORY,
    cancelled: Cancelled = never,
) -> Answer:
    """What a function says about a file, called in a process of its own.

    No code comes back, only JSON and plain arrays: a file that takes the process over gets no
    further.

    Args:
        path: of the file.
        work: the function, which is given the whole path.
        arguments: for it, after that.
        longest: [s] of processor time.
        most_memory: [bytes] of addresses.
        cancelled: True once nobody wants it any more.

    Raises:
        FileError: the function raises one, or takes too long or too much memory, or its process
            ends.
        InputError: the function raises one.
        JobCancelled: it was cancelled.
    """
    if not _place(cancelled):
        raise JobCancelled(_cancellation(path))
    try:
        with tempfile.TemporaryDirectory(prefix="workbench-") as name:
            folder = Path(name)
            asked = (str(path.resolve()), *arguments)
            (folder / REQUEST_FILE).write_text(json.dumps(asked), encoding="utf-8")
            code = _run(path, work, folder, longest, most_memory, cancelled)
            return _answer(path, folder, code, longest)
    finally:
        _places.release()


def _place(cancelled: Cancelled) -> bool:
    """Wait until one process more may run; False when it was cancelled before."""
    while not cancelled():
        if _places.acquire(timeout=POLL_EVERY):
            return True
    return False


def _run(
    path: Path,
    work: Work,
    folder: Path,
    longest: float,
    most_memory: int,
    cancelled: Cancelled,
) -> int:
    """The code that the process ends with."""
    # -P: a file that somebody has sent is no module of ours, whatever its name.
    command = [sys.executable, "-P", "-c", f"from {__name__} import main; main()"]
    limits = (str(longest), str(most_memory))
    command += [work.__module__, work.__qualname__, str(os.getpid()), *limits]
    # The same packages as here, wherever this process has them from.
    places = os.pathsep.join(os.path.abspath(place) for place in sys.path)
    process = subprocess.Popen(
        command,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": places, "OPENBLAS_NUM_THREADS": "1"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    until = time.monotonic() + WAITS * longest
    try:
        while True:
            try:
                return process.wait(POLL_EVERY)
            except subprocess.TimeoutExpired:
                if cancelled():
                    raise JobCancelled(_cancellation(path)) from None
                if time.monotonic() > until:
                    slow = FileProblem.TIME(seconds=WAITS * longest)
                    raise FileError(path, slow) from None
    finally:
        process.kill()
        process.wait()


def _answer(path: Path, folder: Path, code: int, longest: float) -> Answer:
    try:
        said = json.loads((folder / ANSWER_FILE).read_bytes())
        kind, content = said["kind"], said["told"]
    except (OSError, ValueError, LookupError, TypeError):
        if code == -signal.SIGXCPU:
            raise FileError(path, FileProblem.TIME(seconds=longest)) from None
        raise FileError(path, FileProblem.ENDED(code=code)) from None
    match kind:
        case "answer":
            names = [name for name in said["arrays"] if ARRAY_NAME.fullmatch(name)]
            return Answer(content, {name: _array(folder, name) for name in names})
        case "file":
            raise FileError(path, message_of(content))
        case "input":
            raise InputError(message_of(content))
        case _:
            log.error("a file could not be read:\n%s", content)
            raise FileError(path, FileProblem.INTERNAL())


def _cancellation(path: Path) -> Message:
    return FileText.PROBLEM(path=path.name, problem=FileProblem.CANCELLED())


def _array(folder: Path, name: str) -> np.ndarray:
    return np.load(folder / f"{name}.npy", allow_pickle=False)


def main() -> None:
    """What the process does: call the function, and write down what it says or raises."""
    module, name, parent, longest, most_memory = sys.argv[1:]
    _end_with(int(parent))
    seconds, memory = int(float(longest)), int(most_memory)
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    folder = Path.cwd()
    asked = json.loads((folder / REQUEST_FILE).read_bytes())
    try:
        work: Work = getattr(importlib.import_module(module), name)
        answer = work(Path(asked[0]), *asked[1:])
        for key, array in answer.arrays.items():
            np.save(folder / f"{key}.npy", array, allow_pickle=False)
        _write_answer(folder, "answer", answer.value, list(answer.arrays))
    except WorkbenchError as error:
        if isinstance(error, FileError) and error.path == asked[0]:
            _write_answer(folder, "file", error.problem.form)
        else:
            _write_answer(folder, "input", error.message.form)
    except MemoryError:
        _write_answer(folder, "file", FileProblem.MEMORY(most=f"{memory / MB:g}").form)
    except RecursionError:
        _write_answer(folder, "file", FileProblem.DEEP().form)
    except Exception:
        # A rim: the waiting process gets the error and logs it.
        _write_answer(folder, "bug", traceback.format_exc())


def _write_answer(folder: Path, kind: str, answer: Any, arrays: list[str] | None = None) -> None:
    said = {"kind": kind, "told": answer, "arrays": arrays or []}
    partial = folder / f"{ANSWER_FILE}.partial"
    partial.write_text(json.dumps(said), encoding="utf-8")
    partial.replace(folder / ANSWER_FILE)


def finish() -> None:
    """In such a process: go on to the end from now on, whatever becomes of who has asked."""
    resource.setrlimit(resource.RLIMIT_CPU, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, 0)


def _end_with(parent: int) -> None:
    """Let Linux end this process when the one that started it is killed, as a cancelled job is."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it was killed before
            sys.exit(1)

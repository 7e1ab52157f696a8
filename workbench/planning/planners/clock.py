"""The clocks of deadlines and of what is measured: both stand still while something is compiled.

numba compiles a function at its first use on a machine, or loads it from disk at the first use
in a process.  How long that takes says nothing of the work that waits for it.
"""

import threading
import time

from numba.core import event

_LOCK = "numba:compiler_lock"
"""What numba holds while it compiles or loads; a thread may also wait for another that does."""


def working_time() -> float:
    """A time [s] of this thread, as `time.monotonic`, less what went into compiling and loading."""
    return time.monotonic() - _spent.seconds


def processor_time() -> float:
    """As `working_time`, but the processor time of this thread; deadlines count it.

    Other load on the machine must not decide when a planning ends, and so what it finds.
    """
    return time.thread_time() - _spent.processor_seconds


class _Spent(threading.local):
    """What this thread has spent; `depth` counts compilations within one another."""

    seconds = 0.0
    processor_seconds = 0.0
    depth = 0
    began = (0.0, 0.0)


class _CompileListener(event.Listener):
    """Called by numba, in the thread that compiles."""

    def on_start(self, event: event.Event) -> None:
        if _spent.depth == 0:
            _spent.began = time.monotonic(), time.thread_time()
        _spent.depth += 1

    def on_end(self, event: event.Event) -> None:
        _spent.depth -= 1
        if _spent.depth == 0:
            began, used = _spent.began
            _spent.seconds += time.monotonic() - began
            _spent.processor_seconds += time.thread_time() - used


_spent = _Spent()
event.register(_LOCK, _CompileListener())

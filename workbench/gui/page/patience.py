"""Has the page wait for what the worker compiles just now, rather than compile it beside it."""

import threading

from numba.core import event

from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench

LOCK = "numba:compiler_lock"
"""What numba is about to take when something has to be compiled or loaded."""

POLL_EVERY = 0.1
"""[s] Between two looks at whether the worker is ready."""


class Patience(event.Listener):
    """A thread that needs something compiled waits until the worker is ready, then loads it.

    The drawing does not wait: what it would need is not offered meanwhile.

    Lifetime: until `close`; nobody waits any more after it.

    Concurrency: numba calls it in the thread that is about to compile.
    """

    def __init__(self, bench: Bench | History):
        """Wait from now on."""
        self._bench = bench
        self._closed = threading.Event()
        event.register(LOCK, self)

    def close(self) -> None:
        """Let everybody go on."""
        if not self._closed.is_set():
            self._closed.set()
            event.unregister(LOCK, self)

    def on_start(self, event: event.Event) -> None:
        """Wait."""
        if threading.current_thread().name == "renderer":
            return
        while self._bench.live.getting_ready is not None and not self._closed.wait(POLL_EVERY):
            pass

    def on_end(self, event: event.Event) -> None:
        """Something was compiled or loaded."""

"""Those who watch the bench: each gets the newest state in a thread of its own."""

import logging
import threading
from collections.abc import Callable

from workbench.app.core.state import State

log = logging.getLogger(__name__)

Observer = Callable[[State, State], None]
"""Callback with the state of its previous call and the newest state."""


class ObserverThread:
    """Calls one callback with the newest state, in a thread of its own.

    Lifetime: from construction until `close`; a call under way is not waited for.

    Concurrency: any thread may call anything.
    """

    def __init__(self, callback: Observer, state: State) -> None:
        """Wait for a state other than this one, which counts as reported."""
        self._callback = callback
        self._seen = self._newest = state
        self._changed = threading.Condition()
        self._closed = False
        threading.Thread(target=self._run, name="observer", daemon=True).start()

    def put(self, state: State) -> None:
        """Report a state; it replaces a state that still waits."""
        with self._changed:
            self._newest = state
            self._changed.notify()

    def close(self) -> None:
        """Tell nothing more."""
        with self._changed:
            self._closed = True
            self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or self._newest is not self._seen)
                if self._closed:
                    return
                newest = self._newest
            try:
                self._callback(self._seen, newest)
            except Exception:
                log.exception("an observer of the state failed")
            self._seen = newest

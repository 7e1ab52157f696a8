"""How sure it is where the chosen candidate's part comes to lie: worked out beside the drawing."""

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from workbench.app.core.state import State
from workbench.model.candidate import Candidate
from workbench.model.messages.message import Message
from workbench.planning.placing.assembling import base_errors
from workbench.planning.placing.budget import budget_of

log = logging.getLogger(__name__)


class Sureness:
    """Works out the error budget of one candidate after the other, and remembers what it says.

    Lifetime: until `close`.

    Concurrency: `of` from one thread; one more thread works, and calls `found` after each.
    """

    def __init__(self, found: Callable[[], None]):
        """Nothing worked out yet."""
        self._found = found
        self._candidates: tuple[Candidate, ...] | None = None
        self._known: dict[int, Message | None] = {}
        self._threads = ThreadPoolExecutor(1, thread_name_prefix="sureness")

    def close(self) -> None:
        """End the thread, after what it does just now."""
        self._threads.shutdown(cancel_futures=True)

    def of(self, state: State, number: int | None) -> Message | None:
        """For people; None when no candidate is chosen, and until it is worked out."""
        candidates, detections = state.candidates or (), state.detections or ()
        if number is None or number >= len(candidates):
            return None
        if candidates[number].detection >= len(detections):
            return None
        if self._candidates is not state.candidates:
            self._candidates, self._known = state.candidates, {}
        known = self._known
        if number not in known:
            known[number] = None
            self._threads.submit(self._work, state, candidates[number], known, number)
        return known[number]

    def _work(
        self, state: State, candidate: Candidate, known: dict[int, Message | None], number: int
    ) -> None:
        if known is not self._known:
            # Of candidates that nobody looks at any more.
            return
        try:
            detection = (state.detections or ())[candidate.detection]
            bases = base_errors(state.cell, state.placed, state.obstacles)
            known[number] = budget_of(state.cell, detection, candidate, bases).words
        except Exception:
            # A rim: a candidate of which nothing can be said leaves the page as it is.
            log.exception("how sure a candidate is could not be worked out")
        self._found()

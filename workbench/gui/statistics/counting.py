"""The statistics of the running session, counted beside the drawing."""

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from workbench.app.core.state import Phase, State
from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.app.statistics.statistics import Count, Statistics

log = logging.getLogger(__name__)

WORTH_COUNTING = frozenset({Phase.DONE, Phase.FAULT, Phase.LOCALIZED, Phase.PLANNED})
"""Phases in which something has come of a cycle, or of a planning."""


class EntryCounter:
    """Counts the entries of a session that are new since the last time.

    Lifetime: until `close`.

    Concurrency: `of` from one thread; one more thread counts, and calls `counted` after it.
    """

    def __init__(self, bench: Bench | History, counted: Callable[[], None]):
        """Nothing counted yet."""
        self._bench = bench
        self._counted = counted
        self._count = Count()
        self._value = Statistics()
        self._asked = 0
        self._threads = ThreadPoolExecutor(1, thread_name_prefix="statistics")

    def close(self) -> None:
        """End the thread, after what it does just now."""
        self._threads.shutdown(cancel_futures=True)

    def of(self, state: State) -> Statistics:
        """What was counted last; counts in the background when something has come since.

        A recorded session is counted whole, whichever moment of it is viewed.
        """
        is_settled = state.job is None and state.phase in WORTH_COUNTING
        if isinstance(self._bench, History):
            is_settled = not self._asked
        if is_settled and state.number > self._asked:
            self._asked = state.number
            self._threads.submit(self._go_on)
        return self._value

    def _go_on(self) -> None:
        try:
            self._count.add(self._bench.entries(self._count.last))
            self._value = self._count.value
        except Exception:
            # A rim: a journal that cannot be read leaves the page as it is.
            log.exception("the session could not be counted")
        self._counted()

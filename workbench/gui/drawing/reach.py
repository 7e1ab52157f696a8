"""The reach of an arm, worked out beside the drawing and remembered."""

import logging
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from workbench.gui.shared.look import NO_REACH, UNKNOWN_REACH
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.planning.kinematics.reach_map import reach_map

log = logging.getLogger(__name__)

Reached = tuple[Floats, Floats]
"""Places (n, 3) [m] and the share (n,) of the tool's turns; see `reach_map`."""


class Reaches:
    """Finds the reach of the arms of one cell after the other.

    Lifetime: until `close`.

    Concurrency: `of` from one thread; one more thread works it out, and calls `found` after each.
    """

    def __init__(self, found: Callable[[], None]):
        """Nothing known yet."""
        self._found = found
        self._cell: Cell | None = None
        self._known: dict[str, Reached] = {}
        self._closing = threading.Event()
        self._threads = ThreadPoolExecutor(1, thread_name_prefix="reach")

    def close(self) -> None:
        """End the thread soon."""
        self._closing.set()
        self._threads.shutdown(cancel_futures=True)

    def of(self, cell: Cell, arm: str) -> Reached:
        """An arm's places (n, 3) [m] and shares (n,); `NO_REACH` while they are worked out."""
        if not arm:
            return NO_REACH
        if self._cell is not cell:
            self._cell, self._known = cell, {}
        if arm not in self._known:
            self._known[arm] = NO_REACH
            self._threads.submit(self._find, cell, arm, self._known)
        return self._known[arm]

    def _find(self, cell: Cell, arm: str, known: dict[str, Reached]) -> None:
        def is_unwanted() -> bool:
            return self._closing.is_set() or known is not self._known

        try:
            known[arm] = reach_map(cell, cell.arm(arm), cancelled=is_unwanted)
        except Exception:
            # A rim: the page says that it cannot be found, and is otherwise as it was.
            known[arm] = UNKNOWN_REACH
            log.exception("the reach of an arm could not be found")
        self._found()

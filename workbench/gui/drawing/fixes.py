"""What would admit the refused candidate that is looked at: tried beside the drawing."""

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from workbench.app.core.state import State
from workbench.model.candidate import Candidate
from workbench.planning.picking.nearest_fix import nearest_fix

log = logging.getLogger(__name__)

LOOKING = "looking for the nearest fix …"
NOTHING = "no small change of the grasp admits it"


class Fixes:
    """Finds the nearest fix of one candidate after the other, and remembers it.

    Lifetime: until `close`.

    Concurrency: `of` from one thread; one more thread tries, and calls `found` after each.
    """

    def __init__(self, found: Callable[[], None]):
        """Nothing tried yet."""
        self._found = found
        self._candidates: tuple[Candidate, ...] | None = None
        self._known: dict[int, str] = {}
        self._threads = ThreadPoolExecutor(1, thread_name_prefix="nearest fix")

    def close(self) -> None:
        """End the thread, after what it does just now."""
        self._threads.shutdown(cancel_futures=True)

    def of(self, state: State, number: int | None) -> str:
        """In words, for the candidate with that index; empty when there is none to be fixed."""
        candidates, detections = state.candidates or (), state.detections
        if number is None or number >= len(candidates) or not detections:
            return ""
        if self._candidates is not state.candidates:
            self._candidates, self._known = state.candidates, {}
        candidate, known = candidates[number], self._known
        if candidate.verdict.is_ok or candidate.verdict.pair is None:
            return ""
        if number not in known:
            known[number] = LOOKING
            self._threads.submit(self._try, state, candidate, known, number)
        return known[number]

    def _try(self, state: State, candidate: Candidate, known: dict[int, str], number: int) -> None:
        if known is not self._known:
            # Of candidates that nobody looks at any more.
            return
        try:
            seed = state.plan.seed if state.plan is not None else 0
            fix = nearest_fix(
                state.cell,
                state.detections or (),
                (candidate,),
                seed=seed,
                obstacles=state.obstacles,
            )
            known[number] = NOTHING if fix is None else f"nearest fix: {fix.change}"
        except Exception:
            # A rim: a candidate that cannot be tried leaves the page as it is.
            log.exception("the nearest fix could not be looked for")
            known[number] = ""
        self._found()

"""What would admit a refused candidate, or the best one of all: tried beside the drawing."""

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from workbench.app.core.state import State
from workbench.gui.shared.look import NO_HELP, Help
from workbench.model.candidate import Candidate, Reason
from workbench.planning.picking.nearest_fix import fix_words, nearest_fix

log = logging.getLogger(__name__)

LOOKING = Help("looking for the nearest fix …")


class FixFinder:
    """Finds the nearest fix of one candidate after the other, and remembers it.

    Lifetime: until `close`.

    Concurrency: `of` from one thread; one more thread tries, and calls `found` after each.
    """

    def __init__(self, found: Callable[[], None]):
        """Nothing tried yet."""
        self._found = found
        self._candidates: tuple[Candidate, ...] | None = None
        self._known: dict[int | None, Help] = {}
        self._threads = ThreadPoolExecutor(1, thread_name_prefix="nearest fix")

    def close(self) -> None:
        """End the thread, after what it does just now."""
        self._threads.shutdown(cancel_futures=True)

    def of(self, state: State, number: int | None) -> Help:
        """For the candidate with that index; empty when there is none to be fixed."""
        candidates = state.candidates or ()
        if number is None or number >= len(candidates) or not _may_help(candidates[number]):
            return NO_HELP
        return self._of(state, number, (candidates[number],))

    def without_plan(self, state: State) -> Help:
        """What would admit one of all candidates; empty while there is a plan, or none.

        As `workbench explain` says it.
        """
        candidates = state.candidates or ()
        if state.plan is not None or not any(map(_may_help, candidates)):
            return NO_HELP
        return self._of(state, None, candidates)

    def _of(self, state: State, number: int | None, candidates: tuple[Candidate, ...]) -> Help:
        if not state.detections:
            return NO_HELP
        if self._candidates is not state.candidates:
            self._candidates, self._known = state.candidates, {}
        known = self._known
        if number not in known:
            known[number] = LOOKING
            self._threads.submit(self._try, state, candidates, known, number)
        return known[number]

    def _try(
        self,
        state: State,
        candidates: tuple[Candidate, ...],
        known: dict[int | None, Help],
        number: int | None,
    ) -> None:
        if known is not self._known:
            # Of candidates that nobody looks at any more.
            return
        try:
            seed = state.plan.seed if state.plan is not None else 0
            fix = nearest_fix(
                state.cell,
                state.detections or (),
                candidates,
                seed=seed,
                obstacles=state.obstacles,
            )
            known[number] = Help(fix_words(fix), fix)
        except Exception:
            # A rim: a candidate that cannot be tried leaves the page as it is.
            log.exception("the nearest fix could not be looked for")
            known[number] = NO_HELP
        self._found()


def _may_help(candidate: Candidate) -> bool:
    """Whether a small change of the grasp, or of the bin's place, might admit it."""
    verdict = candidate.verdict
    is_far = verdict.reason is Reason.OUT_OF_REACH
    return not verdict.is_ok and (verdict.pair is not None or is_far)

"""How long words for a plan have stood, by a clock that nobody can set."""

import math
from collections.abc import Callable

from workbench.app.core.state import State
from workbench.model.release import Word


class WordAges:
    """Remembers when each word was given, beside the time of day that is on record with it.

    The time of day can be set back, which would keep an approval alive; this count cannot.  It
    is kept for one start of a bench, as words are.

    Concurrency: none of its own; the bench asks under its lock.
    """

    def __init__(self, steady: Callable[[], float]) -> None:
        """Begin without words.

        Args:
            steady: seconds that only ever go on.
        """
        self._steady = steady
        self._given: dict[Word, float] = {}

    def note(self, state: State) -> None:
        """Take up the words that are new in a state, and forget those that are gone."""
        now = self._steady()
        self._given = {word: self._given.get(word, now) for word in state.words}

    def lapsed(self, state: State) -> str:
        """Why the words of a state no longer let its plan out; empty while they do."""
        valid, now = state.cell.policy.approval_minutes * 60.0, self._steady()
        for word in state.words:
            if now - self._given.get(word, -math.inf) >= valid:
                return (
                    f"the approval by {word.actor} has run out after {valid / 60:.0f} minutes, "
                    "although the clock says otherwise: it was set back; approve again"
                )
        return ""

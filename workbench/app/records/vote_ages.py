"""How long votes for a plan have stood, by a clock that nobody can set."""

import math
from collections.abc import Callable

from workbench.app.core.state import State
from workbench.model.release import Vote


class VoteAges:
    """Remembers when each vote was given, beside the time of day that is on record with it.

    The time of day can be set back, which would keep an approval alive; this count cannot.  It
    is kept for one start of a bench, as votes are.

    Concurrency: none of its own; the bench asks under its lock.
    """

    def __init__(self, steady: Callable[[], float]) -> None:
        """Begin without votes.

        Args:
            steady: seconds that only ever go on.
        """
        self._steady = steady
        self._given: dict[Vote, float] = {}

    def note(self, state: State) -> None:
        """Take up the votes that are new in a state, and forget those that are gone."""
        now = self._steady()
        self._given = {vote: self._given.get(vote, now) for vote in state.votes}

    def find_lapse(self, state: State) -> str:
        """Why the votes of a state no longer let its plan out; empty while they do."""
        valid, now = state.cell.policy.approval_minutes * 60.0, self._steady()
        for vote in state.votes:
            if now - self._given.get(vote, -math.inf) >= valid:
                return (
                    f"the approval by {vote.actor} has run out after {valid / 60:.0f} minutes, "
                    "although the clock says otherwise: it was set back; approve again"
                )
        return ""

"""How long votes for a plan have stood, by a clock that nobody can set."""

import math
from collections.abc import Callable

from workbench.app.core.state import State
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
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

    def find_lapse(self, state: State, at: float) -> Message | None:
        """Why a vote has run out that is valid by the time of day; None when there is none.

        Args:
            state: with the votes.
            at: the time of day [s since the epoch].
        """
        valid, now = state.cell.policy.approval_minutes * 60.0, self._steady()
        for vote in state.votes:
            # By the time of day, too, it has run out: the rules say so, and no clock was set back.
            is_old = at >= vote.at + valid
            if not is_old and now - self._given.get(vote, -math.inf) >= valid:
                return Refusal.CLOCK_SET_BACK(person=vote.actor, minutes=f"{valid / 60:.0f}")
        return None

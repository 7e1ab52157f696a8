"""The budget of a filling in counted work: it ends the same on every machine.

A point is 0.8 to 1.3 ms of processor time on two shared cores of an AMD EPYC.
"""

from workbench.model.errors import JobCancelled
from workbench.model.messages.work import CancelText, ProgressText
from workbench.plugins.progress import Cancelled, Report, silent
from workbench.plugins.progress import never as nobody

WORK = 48_000.0
"""Points of a filling."""

WAY, PIECE = 0.0045, 0.00004
"""A way of a hand that is tried at a part, and as much more for each piece of that part."""

FIT = 0.3
"""What a family costs besides its ways."""

GRIP, TRIANGLE = 3.4, 0.0008
"""A grip that is checked on the part alone, and as much more for each triangle of its mesh."""

REACH_WORK, CHECK_WORK = 2.0, 0.2
"""An arm that is tried at a part, and each check of collisions in that."""

FALL = 1.2
"""A pair of parts that fall or settle together, each part with itself included."""

WORLD = 0.6
"""A piece of a part in a world of collisions."""


class Work:
    """Budget and progress of a filling.

    `done` and `most` are in points, see `WORK`; `note` is the latest progress message.

    Lifetime: of one filling.
    """

    def __init__(
        self, most: float = WORK, report: Report = silent, cancelled: Cancelled = nobody
    ) -> None:
        """A budget.

        Args:
            most: points, see `WORK`.
            report: takes the share done and what is being done.
            cancelled: asked now and then; True ends it.
        """
        self.most, self.done, self.note = most, 0.0, ProgressText.GRIPS()
        self._report, self._cancelled = report, cancelled

    def add(self, points: float) -> None:
        """Count some work."""
        self.done += points

    def is_over(self, share: float = 1.0) -> bool:
        """Whether a share of the budget is spent.

        Raises:
            JobCancelled: it was cancelled.
        """
        if self._cancelled():
            raise JobCancelled(CancelText.FILLING())
        self._report(min(self.done / self.most, 1.0), self.note)
        return self.done > share * self.most

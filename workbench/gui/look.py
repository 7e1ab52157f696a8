"""What is looked at: the part of the picture that no auditor asks for."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from workbench.app.live import Live
from workbench.app.state import State
from workbench.gui.playback import Run


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Which moment of the plan and which candidate everybody sees.

    `time` [s] on the plan's clock; `candidate` is an index among the state's candidates;
    `by` is the browser that moved the time last, None when nobody did (it plays).
    """

    time: float = 0.0
    is_playing: bool = False
    candidate: int | None = None
    by: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Everything that the page shows.

    `runs` is the timeline of the state's plan, empty without one; `at` [s since the epoch] is
    when it looked like this.
    """

    state: State
    live: Live
    look: Look
    runs: tuple[Run, ...]
    at: float

    @property
    def plan_seconds(self) -> float:
        """When the plan ends on its own clock."""
        return max((run.end for run in self.runs), default=0.0)


class SharedLook:
    """The look that all browsers share.

    Concurrency: any thread; `changed` is called after each change, outside the lock.
    """

    def __init__(self, changed: Callable[[], None]):
        """The start of the plan, no candidate."""
        self._now = Look()
        self._lock = threading.Lock()
        self._changed = changed

    @property
    def now(self) -> Look:
        """The newest look."""
        return self._now

    def change(self, **fields: Any) -> None:
        """Replace fields of the look."""
        with self._lock:
            self._now = replace(self._now, **fields)
        self._changed()

"""What one browser alone looks at: a robot moved by hand, a pose over a scan, a distance."""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from workbench.model.geometry import Floats
from workbench.model.plan import Plan
from workbench.proof.spot import Spot


@dataclass(frozen=True, slots=True, eq=False)
class Visited:
    """Where a plan comes nearest to something: at `time` [s] on its clock, with what to say."""

    plan: Plan
    time: float
    spot: Spot
    says: str


@dataclass(frozen=True, slots=True, eq=False)
class Own:
    """What somebody does in their own view; nobody else sees anything of it.

    `jog` holds the arms that are moved by hand, arm -> configuration (n,) [rad]; `sighting` is the
    pose of a calibration that is laid over the robot, `is_calibrated` says with which pose of the
    scanner; `measured` are the points (3,) [m] that were clicked on, up to two; `visited` is the
    place of the plan that is looked at.
    """

    jog: Mapping[str, Floats] | None = None
    sighting: int | None = None
    is_calibrated: bool = True
    measured: tuple[Floats, ...] = ()
    visited: Visited | None = None

    @property
    def hides_robot(self) -> bool:
        """Whether the robot stands elsewhere here than for everybody else."""
        return self.jog is not None or self.sighting is not None


NOTHING_OWN = Own()


class OwnLook:
    """The own look of one browser.

    Lifetime: that of the browser's controls; what was looked at ends with them.

    Concurrency: any thread; `changed` is called after each change, outside the lock.
    """

    def __init__(self, changed: Callable[[], None]):
        """What everybody sees, and nothing besides."""
        self._now = NOTHING_OWN
        self._lock = threading.Lock()
        self._changed = changed

    @property
    def now(self) -> Own:
        """The newest look."""
        return self._now

    def change(self, **fields: Any) -> None:
        """Replace fields of the look."""
        with self._lock:
            self._now = replace(self._now, **fields)
        self._changed()

    def end(self) -> None:
        """See the robot again where everybody sees it."""
        if self._now.hides_robot:
            self.change(jog=None, sighting=None)

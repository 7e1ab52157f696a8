"""What is looked at: the part of the picture that no auditor asks for."""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import pinocchio as pin

from workbench.app.live import Live
from workbench.app.state import State
from workbench.gui.playback import Run
from workbench.model.geometry import Floats, Shape
from workbench.planning.world import Contact


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Which moment of the plan and which candidate everybody sees.

    `time` [s] on the plan's clock; `candidate` is an index among the state's candidates, `pose`
    one among the poses of its way;
    `by` is the browser that moved the time last, None when nobody did (it plays).
    `jog` holds the arms that are moved by hand, arm -> configuration (n,) [rad]; `shapes` and
    `frames` say whether collision shapes and frames are shown, `reach` of which arm the reach is;
    `measured` are the points (3,) [m] that somebody has clicked on, up to two.
    """

    time: float = 0.0
    is_playing: bool = False
    candidate: int | None = None
    pose: int = 0
    by: int | None = None
    jog: Mapping[str, Floats] | None = None
    shapes: bool = False
    frames: bool = False
    reach: str = ""
    measured: tuple[Floats, ...] = ()


Placed = tuple[Shape, pin.SE3]


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """One arm standing somewhere on a candidate's way.

    `q` (n,) [rad]; `opening` [m] of its fingers; `note` says whether it is clear there; `meets`
    are the two bodies that come too close, in the world, empty when none do.
    """

    label: str
    q: Floats
    opening: float
    note: str
    meets: tuple[Placed, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Jogged:
    """The robot moved by hand.

    `q`: arm -> configuration (n,) [rad]; `contacts` are the pairs nearer than their margins;
    `clearance` [m] is the least of all, between the bodies of `pair`, if it is small; `meets` are
    the bodies of the contacts in the world.
    """

    q: Mapping[str, Floats]
    contacts: tuple[Contact, ...]
    clearance: float
    pair: tuple[str, str] | None
    meets: tuple[Placed, ...]


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Everything that the page shows.

    `runs` is the timeline of the state's plan, empty without one; `poses` those of the chosen
    candidate, and `fix` what would admit it; `jogged` is set while somebody moves the robot by
    hand; `reached` holds places (n, 3) [m] and shares (n,) of the reach that is shown; `at`
    [s since the epoch] is when it looked like this.
    """

    state: State
    live: Live
    look: Look
    runs: tuple[Run, ...]
    at: float
    poses: tuple[Pose, ...] = ()
    fix: str = ""
    jogged: Jogged | None = None
    reached: tuple[Floats, Floats] | None = None

    @property
    def pose(self) -> Pose | None:
        """The pose of the chosen candidate that is looked at."""
        return self.poses[min(self.look.pose, len(self.poses) - 1)] if self.poses else None

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

r"""How a controller moves its robots: a queue of ways for each, corners, stops, and ways in step.

What is modelled, after ABB: RAPID overview (3HAC050947), "Positioning during program execution" and
"Synchronization with logical instructions", and MultiMove (3HAC050961).

- All axes move linearly in time along a joint way, and reach its end together.
- At a fly-by point the program goes on a moment (`PREFETCH`) before the zone begins.  If the next
  way is not there when the zone begins, the point becomes a stop point (event 50024).
- In a zone the robot follows a parabola that touches both ways: it stays in the corner's triangle.
  A zone reaches to the middle of the shorter way at most.
- In synchronised mode ways with the same \\ID begin and end together.
- StopMove keeps the robot on its way; ClearPath drops what is left of it.
"""

import logging
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.devices.rapid.kinematics import Axes
from workbench.model.geometry import Floats

log = logging.getLogger(__name__)

TIME_STEP = 0.004
"""[s] Of the robot's time."""

PREFETCH = 0.1
"""[s] How long before a zone begins the program goes on."""

NO_LOAD = (0.001, [0.0, 0.0, 0.001], [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0)
"""`load0`: what counts until something else is said."""

CORNER_PATH = "50024 Corner path failure: a corner path is executed as a stop point"


@dataclass(eq=False)
class JointWay:
    r"""From where the robot is to a point: `path` (m, n) [deg] in equal times, `seconds` in all.

    `share` [0, 0.5] of it lies in the zone at its end; 0 is a stop point.  `number` is its \\ID.
    """

    path: Floats
    seconds: float
    share: float = 0.0
    number: int | None = None
    ends: float = 0.0
    is_over: bool = False
    is_paired: bool = False

    def at(self, seconds: float) -> Floats:
        """Axes (n,) [deg] so long after it began."""
        where = np.clip(seconds / self.seconds, 0.0, 1.0) * (len(self.path) - 1)
        k = min(int(where), len(self.path) - 2)
        return self.path[k] + (where - k) * (self.path[k + 1] - self.path[k])


class Mechanism:
    """One robot: where it is, and the ways before it.

    Lifetime: as long as the controller.  Concurrency: one thread at a time.
    """

    def __init__(self, name: str, axes: Axes) -> None:
        """It stands at home."""
        self.name, self.axes = name, axes
        self.here: Floats = np.array(axes.home)
        self.is_in_step = False
        # Led from outside: it may move at any time without a way.
        self.is_guided = False
        # What the controller reckons with, as RAPID has it.
        self.tool_load: list[Any] = list(NO_LOAD)
        self.payload: list[Any] = list(NO_LOAD)
        self._ways: deque[JointWay] = deque()
        self._time = 0.0
        self.stops: set[str] = set()

    @property
    def is_standing(self) -> bool:
        """Whether nothing is left to go, or a stop holds it."""
        return bool(self.stops) or not (self._ways or self.is_guided)

    @property
    def end(self) -> Floats:
        """Where the last way ends, (n,) [deg]."""
        return self._ways[-1].path[-1] if self._ways else self.here

    def add(self, way: JointWay) -> None:
        """Append a way."""
        if self._ways and not self.is_in_step:
            self.join(self._ways[-1], self.zone(self._ways[-1], way))
        self._ways.append(way)

    def clear(self) -> None:
        """ClearPath: nothing is left to go."""
        self._ways.clear()
        self._time = 0.0

    def lets_on(self, way: JointWay) -> bool:
        """Whether the program may go on after the instruction that gave a way."""
        if way.is_over or way not in self._ways:
            return True
        if way.share == 0.0 or self._ways[0] is not way:
            return False
        left = way.seconds * (1.0 - way.share) - self._time
        return left <= PREFETCH and not self.stops

    def zone(self, before: JointWay, after: JointWay) -> float:
        """How long [s] the zone between two ways takes on each, so that speed does not jump."""
        zone = min(before.share * before.seconds, after.seconds / 2)
        # Too late: it is on its way into the point.
        is_past = before is self.head and self._time > before.seconds - zone
        return 0.0 if is_past else zone

    def join(self, before: JointWay, zone: float) -> None:
        """Round the corner after a way, or stop in it where the zone is too short."""
        if before.share and zone < TIME_STEP:
            log.warning("%s: %s", self.name, CORNER_PATH)
        before.ends = zone if zone >= TIME_STEP else 0.0
        before.share = before.ends / before.seconds

    def _is_late(self, way: JointWay) -> bool:
        """Whether a zone begins before the way after it is known."""
        is_known = len(self._ways) > 1 and (not self.is_in_step or self._ways[1].is_paired)
        return bool(way.share) and not is_known and self._time >= way.seconds * (1.0 - way.share)

    def advance(self, seconds: float) -> None:
        """Go on for that long; nothing happens while a stop holds it."""
        if self.stops:
            return
        while self._ways and seconds > 1e-12:
            way = self._ways[0]
            if self.is_in_step and not way.is_paired:
                return
            if self._is_late(way):
                log.warning("%s: %s", self.name, CORNER_PATH)
                way.share = 0.0
            last = way.seconds + way.ends if way.ends else way.seconds
            go = min(seconds, last - self._time)
            self._time += go
            seconds -= go
            self.here = self._where(way)
            if self._time >= last - 1e-12:
                way.is_over = True
                self._ways.popleft()
                # The zone has used up the beginning of the next way.
                self._time = way.ends

    def _where(self, way: JointWay) -> Floats:
        zone = way.ends
        into = self._time - (way.seconds - zone)
        if not zone or into <= 0:
            return way.at(self._time)
        u, after = into / (2 * zone), self._ways[1]
        corner, start, end = way.path[-1], way.at(way.seconds - zone), after.at(zone)
        return (1 - u) ** 2 * start + 2 * u * (1 - u) * corner + u**2 * end

    @property
    def head(self) -> JointWay | None:
        """The way that it is on, or that comes next."""
        return self._ways[0] if self._ways else None

    @property
    def waiting(self) -> Sequence[JointWay]:
        """All ways before it."""
        return self._ways


def pair(mechanisms: Sequence[Mechanism]) -> str:
    r"""Let ways with the same \\ID begin together; a word when they cannot.

    The slower one gives the time, the smaller zone the corner.
    """
    together = [mechanism for mechanism in mechanisms if mechanism.is_in_step]
    if not together:
        return ""
    before: tuple[JointWay, ...] = ()
    for column in zip(*(mechanism.waiting for mechanism in together), strict=False):
        if len({way.number for way in column}) != 1:
            return "the \\ID of synchronised movements differ"
        if not all(way.is_paired for way in column):
            seconds = max(way.seconds for way in column)
            share = min(way.share for way in column)
            for way in column:
                way.seconds, way.share, way.is_paired = seconds, share, True
            if before:
                corners = list(zip(together, before, column, strict=False))
                zone = min(mechanism.zone(first, then) for mechanism, first, then in corners)
                for mechanism, first, _ in corners:
                    mechanism.join(first, zone)
        before = column
    return ""

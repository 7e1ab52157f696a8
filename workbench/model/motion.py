"""What planning and proof need to know of how a controller moves, and how fast a plan makes it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from workbench.model.digest import LATER
from workbench.model.errors import InputError
from workbench.model.geometry import Floats

Corners = Literal["stop", "blend", "streamed"]

PartLeg = Literal["reach", "approach", "extract", "return", "place", "home"]
ToolLeg = Literal["stow", "retract", "cross", "dock", "undock"]
DropLeg = Literal["lift", "carry"]
LegName = Literal[PartLeg, ToolLeg, DropLeg, "view", "stir"]
"""The names of all legs."""

LEG_NAMES: tuple[LegName, ...] = ("reach", "approach", "extract", "return", "place", "home")
"""The legs of an arm that takes a part."""

VIEW_LEGS: tuple[LegName, ...] = ("view",)
"""The legs of an arm that takes its scanner to the view."""

STIR_LEGS: tuple[LegName, ...] = ("reach", "stir", "home")
"""The legs of an arm that stirs the parts in the bin with its hand."""

DROP_LEGS: tuple[LegName, ...] = ("lift", "carry", "home")
"""The legs of an arm that drops back what it holds; where it stands clear of all, without `lift`.

`lift` leads straight up out of the bin, `carry` to where the hand opens.
"""

TOOL_LEGS: tuple[LegName, ...] = ("reach", "stow", "retract", "cross", "dock", "undock", "home")
"""The legs of an arm that changes its tool: with the old one up to `stow`, then bare up to `dock`.

`stow` and `dock` lead straight to the pose of a slot, `retract` and `undock` straight away from it.
"""

SLOT_LEGS: frozenset[LegName] = frozenset({"stow", "retract", "dock", "undock"})
"""Legs straight into the slot of a tool, or out of it."""

WHOLE_STEP_WITHIN = 1e-6
"""[smallest step] A limit this close to a whole step is that step."""


@dataclass(frozen=True, slots=True)
class MotionModel:
    """How a controller executes waypoints, and what it can say of it.

    Angles travel in `unit` with this many `decimals`, or as they are where `decimals` is None.
    `corners` at waypoints: it comes to rest there (`stop`), it rounds them by at most the cell's
    zone (`blend`); or it is sent a configuration every `period` [s] along the rounded way
    (`streamed`).  `arms_at_once` is how many arms it moves at the same time.  `reports_progress`:
    the link itself acknowledges what is sent, a stop and the end, and says what became of each
    part; otherwise all that is known comes from the states that the controller reports beside it.

    `takes_share`: it can move slower than was planned, along the same way; at most
    `longest` [s] from one waypoint to the next.  `takes_steps`: it can wait for a word before each
    step (`plugins.robot_link.SteppedLink`).  `takes_loads`: it gets the plan's loads.  `maps_axes`:
    it speaks in the numbers that a controller with an `AxisMapping` shows.  `takes_outputs`: it
    switches the digital output of the TCP that takes the part.  `takes_openings`: it moves fingers
    to a leg's opening; else they are wide open, or closed around a part.  `sends_poses`: the
    robot's program gets poses of the hand alone and moves by itself: of that motion nothing is
    proven.  `takes_tools`: it couples and uncouples tools.  `keeps_hand`: it begins a
    plan with something in the hand, and neither opens nor closes the hand before.
    """

    link: str
    corners: Corners = "stop"
    unit: Literal["deg", "rad"] = "rad"
    decimals: int | None = None
    period: float = 0.0
    arms_at_once: int = 1
    reports_progress: bool = False
    takes_share: bool = field(default=False, metadata=LATER)
    takes_steps: bool = field(default=False, metadata=LATER)
    takes_loads: bool = field(default=False, metadata=LATER)
    longest: float = field(default=math.inf, metadata=LATER)
    maps_axes: bool = field(default=False, metadata=LATER)
    sends_poses: bool = field(default=False, metadata=LATER)
    takes_outputs: bool = field(default=False, metadata=LATER)
    takes_openings: bool = field(default=False, metadata=LATER)
    takes_tools: bool = field(default=False, metadata=LATER)
    keeps_hand: bool = field(default=False, metadata=LATER)

    def __post_init__(self) -> None:
        if self.corners == "streamed" and not self.period > 0:
            raise InputError(f"robot link {self.link}: a streamed motion needs a period above 0 s")
        if self.arms_at_once < 1:
            raise InputError(f"robot link {self.link}: at least one arm has to be moved at once")

    @property
    def quantum(self) -> float:
        """[rad] The smallest step in which a joint can be sent; 0 where there is none."""
        if self.decimals is None:
            return 0.0
        step = 10.0**-self.decimals
        return float(np.deg2rad(step)) if self.unit == "deg" else step

    def rounded(self, q: Floats) -> Floats:
        """The nearest configurations (..., n) [rad] that can be sent."""
        if self.decimals is None:
            return np.array(q, dtype=np.float64)
        if self.unit == "rad":
            return np.round(q, self.decimals)
        return np.deg2rad(np.round(np.rad2deg(q), self.decimals))

    def is_sendable(self, q: Floats) -> bool:
        """Whether configurations (..., n) [rad] are whole steps."""
        if self.decimals is None:
            return True
        steps = self._steps(q)
        return bool(np.abs(steps - np.round(steps)).max(initial=0.0) <= WHOLE_STEP_WITHIN)

    def limits(self, lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
        """Joint limits (n,) [rad] moved inwards to what can be sent.

        Without this, a joint at its limit could be rounded to beyond it.  A joint with no room
        for two steps keeps its limits.
        """
        if self.decimals is None:
            return lower, upper
        low = self._angles(np.ceil(self._steps(lower) - WHOLE_STEP_WITHIN))
        high = self._angles(np.floor(self._steps(upper) + WHOLE_STEP_WITHIN))
        has_range = low < high
        return np.where(has_range, low, lower), np.where(has_range, high, upper)

    def _steps(self, q: Floats) -> Floats:
        per_unit = 10 ** (self.decimals or 0)
        return (np.rad2deg(q) if self.unit == "deg" else np.asarray(q)) * per_unit

    def _angles(self, steps: Floats) -> Floats:
        angles = steps / 10 ** (self.decimals or 0)
        return np.deg2rad(angles) if self.unit == "deg" else angles


@dataclass(frozen=True, slots=True)
class SpeedBound:
    """How fast [m/s] the TCP and any point of arm, tool and part are on a leg, at most.

    `mass` [kg]: what moves (`derived.speed_limits`), None where the cell does not state it.
    """

    arm: str
    leg: str
    tcp: float
    point: float
    mass: float | None = field(default=None, metadata=LATER)

    @property
    def energy(self) -> float | None:
        """The most kinetic energy [J] that could go into a contact."""
        return None if self.mass is None else self.mass * self.point**2 / 2


def greatest_speed(speeds: Sequence[SpeedBound]) -> SpeedBound | None:
    """The greatest bounds of all legs, of the leg with the fastest point; None without any."""
    if not speeds:
        return None
    fast = max(speeds, key=lambda bound: bound.point)
    return replace(fast, tcp=max(bound.tcp for bound in speeds))


def ceil_speed(bound: float) -> float:
    """A speed [m/s] from above for people, up to whole millimetres a second."""
    return math.ceil(bound * 1e3 - 1e-6) / 1e3


def ceil_energy(bound: float) -> str:
    """An energy [J] from above for people, to hundredths."""
    return f"{math.ceil(bound * 100 - 1e-6) / 100:.2f}"


def floor_distance(bound: float) -> float:
    """A distance [m] from below for people, down to a tenth of a millimetre: no more than holds."""
    return math.floor(bound * 1e4 + 1e-6) / 1e4


def at_least(bound: float) -> str:
    """A distance [m] from below, for people; see `floor_distance`."""
    return f"at least {floor_distance(bound) * 1e3:.1f} mm"

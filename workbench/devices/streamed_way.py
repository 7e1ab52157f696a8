"""A leg as a curve with its time: where the reference is every few milliseconds, and how it stops.

The curve is the polyline with corners rounded by parabolas, as planning has timed it; between two
marks on it q'' is constant.  The squared speed `x` of the parameter is the largest from which the
rest can be done (backwards); then the largest that can be reached (forwards): what limits it are
speeds and accelerations of the joints.  A stop brakes along the same curve with what these allow.
Where a cell limits jerk, a leg is a `JerkLimitedWay`; a stop then still is as hard as accelerations
allow, since who stops wants no longer way.

All links that stream share this.

Source: Pham and Pham, "A new approach to time-optimal path parameterization based on reachability
analysis", IEEE T-RO 2018.
"""

from dataclasses import dataclass

import numpy as np

from workbench.devices.jerk_limited_way import JerkLimitedWay, jerk_limited_way
from workbench.model.cell import Arm, Cell
from workbench.model.derived.point_speeds import PointSpeeds, speeds_of
from workbench.model.geometry import Floats, frozen, put
from workbench.model.plan import Leg, Plan

STRAIGHT, CORNER = 16, 8
"""Pieces of the middle of a segment, and of each half of a rounded corner: those of planning."""

FASTEST = 1e6
"""[1/s2] Squared speed of the parameter where no joint moves: a segment in a millisecond."""

TINY = 1e-12

BRAKE_STEPS = 8
"""Within one period: limits change along a curve."""


@dataclass(frozen=True, slots=True, eq=False)
class StreamedWay:
    """The curve of one leg and when it is where.

    `path` (m, n) [rad]; corners are rounded by the share `zone` of a segment.  `s` (k,) are marks
    in the parameter, which is i at waypoint i; `t` (k,) [s] and `speed` (k,) [1/s] are there.
    """

    path: Floats
    zone: float
    acceleration: Floats
    s: Floats
    t: Floats
    speed: Floats

    def __post_init__(self) -> None:
        for name in ("path", "s", "t", "speed"):
            put(self, **{name: frozen(getattr(self, name))})

    @property
    def end(self) -> float:
        """The parameter at its end."""
        return float(self.s[-1])

    @property
    def seconds(self) -> float:
        """How long it takes."""
        return float(self.t[-1])

    def when(self, t: float) -> tuple[float, float]:
        """The parameter and its speed [1/s] at a time [s]."""
        if t >= self.t[-1]:
            return float(self.s[-1]), 0.0
        k = int(np.searchsorted(self.t, t, side="right")) - 1
        width, since = self.t[k + 1] - self.t[k], t - self.t[k]
        push = (self.speed[k + 1] - self.speed[k]) / width
        s = self.s[k] + self.speed[k] * since + push * since**2 / 2
        return float(s), float(self.speed[k] + push * since)

    def at(self, s: float) -> tuple[Floats, Floats, Floats]:
        """The configuration, q' and q'' (n,) at a parameter."""
        steps = np.diff(self.path, axis=0)
        i = min(int(s), len(steps) - 1)
        along, step = s - i, steps[i]
        still = np.zeros_like(step)
        q = self.path[i] + along * step
        if i > 0 and along < self.zone:
            turn, deep = (step - steps[i - 1]) / (2 * self.zone), self.zone - along
            return q + turn * deep**2 / 2, step - turn * deep, turn
        if i < len(steps) - 1 and along > 1 - self.zone:
            turn, deep = (steps[i + 1] - step) / (2 * self.zone), along - 1 + self.zone
            return q + turn * deep**2 / 2, step + turn * deep, turn
        return q, step, still


def timed_way(cell: Cell, plan: Plan, arm: Arm, leg: Leg) -> StreamedWay | JerkLimitedWay:
    """The curve of a leg of an arm, at the plan's times, within the limits of the cell."""
    velocity = cell.robot.limits(arm.joints)[2] * cell.policy.speed
    if arm.jerk is None:
        points = speeds_of(cell, plan, plan.arm(arm.name), leg)
        return way_of(leg, velocity, arm.acceleration, cell.policy.zone, points)
    return jerk_limited_way(leg, velocity, arm.acceleration, arm.jerk, cell.policy.zone)


def way_of(
    leg: Leg,
    velocity: Floats,
    acceleration: Floats,
    zone: float,
    points: PointSpeeds | None = None,
) -> StreamedWay:
    """The curve of a leg, at the plan's times: no faster than it was timed.

    Args:
        leg: of the plan.
        velocity: largest joint speeds (n,) [rad/s], already scaled.
        acceleration: largest joint accelerations (n,) [rad/s2].
        zone: corner rounding, share of the shorter neighbouring segment, below 0.5.
        points: what else limits the speed, where the cell does.
    """
    count, most = len(leg.q) - 1, acceleration
    marks, slopes, bends = _pieces(np.diff(leg.q, axis=0), zone)
    if points is not None:
        # One more joint, whose speed is at most 1, and which accelerates as it likes.
        steps = slopes.mean(axis=1) * np.diff(marks)[:, None]
        ends = leg.q[0] + np.cumsum(steps, axis=0)
        shares = [points.shares(ends - (1 - k) * steps, slopes[:, k]) for k in range(2)]
        slopes = np.concatenate([slopes, np.stack(shares, axis=1)[:, :, None]], axis=2)
        bends = np.concatenate([bends, np.zeros((len(bends), 1))], axis=1)
        velocity, most = np.append(velocity, 1.0), np.append(acceleration, np.inf)
    speed = np.sqrt(_squares(np.diff(marks), slopes, bends, velocity, most, zone=zone, count=count))
    sums = np.maximum(speed[1:] + speed[:-1], TINY)
    t = np.concatenate([[0.0], np.cumsum(2 * np.diff(marks) / sums)])
    slower = max(leg.seconds / t[-1], 1.0)
    return StreamedWay(leg.q, zone, np.array(acceleration), marks, t * slower, speed / slower)


def _pieces(steps: Floats, zone: float) -> tuple[Floats, Floats, Floats]:
    """Marks (k + 1,), q' at both ends of each piece (k, 2, n) and q'' in it (k, n)."""
    way = StreamedWay(
        np.concatenate([steps[:1] * 0, np.cumsum(steps, axis=0)]), zone, *[np.zeros(1)] * 4
    )
    inside = np.linspace(zone, 1 - zone, STRAIGHT + 1)
    corner = np.linspace(0, zone, CORNER + 1)[:-1] if zone > 0 else np.zeros(0)
    ticks = np.concatenate([corner, inside, 1 - corner[:0:-1]])
    ticks = ticks[ticks < 1 - TINY]
    marks = np.concatenate([*(ticks + i for i in range(len(steps))), [len(steps)]])
    width = np.diff(marks)
    middles = [way.at(s) for s in marks[:-1] + width / 2]
    middle, bends = (
        np.array([joint[1] for joint in middles]),
        np.array([joint[2] for joint in middles]),
    )
    half = bends * width[:, None] / 2
    return marks, np.stack([middle - half, middle + half], axis=1), bends


def _squares(
    width: Floats,
    slopes: Floats,
    bends: Floats,
    velocity: Floats,
    acceleration: Floats,
    *,
    zone: float,
    count: int,
) -> Floats:
    """The fastest squared speeds (k + 1,) at the marks.

    With x at a piece's beginning, joint j lets the acceleration u be in -A - B x .. A - B x, seen
    at either end of the piece; and x + 2 u w may not be negative, nor more than may follow.
    """
    pushes = slopes.copy()
    pushes[:, 1] += 2 * width[:, None] * bends
    pushes = pushes.reshape(len(width), -1)
    moves = np.abs(pushes) > TINY
    safe = np.where(moves, pushes, 1.0)
    reach = np.where(moves, np.tile(acceleration, 2) / np.abs(safe), np.inf)
    tilt = np.where(moves, np.tile(bends, 2) / safe, 0.0)
    steepest = np.maximum(np.abs(slopes).max(axis=1), TINY)
    most = np.minimum((velocity / steepest).min(axis=1) ** 2, FASTEST)
    bent = np.abs(np.tile(bends, 2))
    stuck = np.where(
        ~moves & (bent > TINY), np.tile(acceleration, 2) / np.maximum(bent, TINY), np.inf
    )
    ends = most.copy()
    most = np.minimum(most, stuck.min(axis=1))
    # Standing still at the end of the piece is one more lower bound: -x / 2 w.
    low_reach = np.concatenate([reach, np.zeros((len(width), 1))], axis=1)
    low_tilt = np.concatenate([tilt, 0.5 / width[:, None]], axis=1)
    steep = tilt[:, None, :] - low_tilt[:, :, None]
    room = low_reach[:, :, None] + reach[:, None, :]
    tight = (steep > TINY) & np.isfinite(room)
    bound = np.where(tight, room / np.where(tight, steep, 1.0), np.inf)
    most = np.minimum(most, bound.min(axis=(1, 2)))
    x = np.zeros(len(width) + 1)
    per = len(width) // count
    for k in range(len(width) - 1, 0, -1):
        follows, half = min(x[k + 1], ends[k]), 0.5 / width[k]
        steep_k = half - tilt[k]
        tops = np.where(
            steep_k > TINY, (follows * half + reach[k]) / np.maximum(steep_k, TINY), np.inf
        )
        x[k] = min(most[k], ends[k - 1], float(tops.min()), follows + FASTEST)
        if zone <= 0 and k % per == 0:
            x[k] = 0.0
    for k in range(len(width)):
        push = float((reach[k] - tilt[k] * x[k]).min())
        x[k + 1] = max(min(x[k + 1], x[k] + 2 * width[k] * push), 0.0)
    return x


class Ride:
    """A reference under way along a leg, one period after the other."""

    def __init__(self, way: StreamedWay | JerkLimitedWay, share: float, period: float) -> None:
        """Stand at the beginning; `share` of the planned speed, a reference each `period` [s]."""
        self._way, self._share, self._period = way, share, period
        self._t = 0.0
        self._s, self._speed = 0.0, 0.0
        self._brakes = False

    @property
    def is_over(self) -> bool:
        """Whether the reference has come to rest, at the end or where it was stopped."""
        return self._speed == 0.0 if self._brakes else self._t >= self._way.seconds

    @property
    def q(self) -> Floats:
        """The reference (n,) [rad]."""
        return self._way.at(self._s)[0]

    def brake(self) -> None:
        """Come to rest on the way, as soon as the limits allow."""
        self._brakes = True

    def go(self) -> Floats:
        """The reference (n,) [rad] one period later."""
        if not self._brakes:
            self._t += self._share * self._period
            self._s, speed = self._way.when(self._t)
            self._speed = speed * self._share
        else:
            for _ in range(BRAKE_STEPS):
                self._slow_down(self._period / BRAKE_STEPS)
        return self.q

    def _slow_down(self, seconds: float) -> None:
        after = max(self._speed + self._braking() * seconds, 0.0)
        self._s += (self._speed + after) / 2 * seconds
        self._speed = after
        if self._s >= self._way.end:
            self._s, self._speed = self._way.end, 0.0

    def _braking(self) -> float:
        """The acceleration of the parameter [1/s2], not above 0, that stops soonest."""
        _, slope, bend = self._way.at(self._s)
        moves = np.abs(slope) > TINY
        low = -self._way.acceleration[moves]
        low = low - np.sign(slope[moves]) * bend[moves] * self._speed**2
        return min(float((low / np.abs(slope[moves])).max(initial=-FASTEST)), 0.0)

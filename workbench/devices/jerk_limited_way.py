"""A leg of an arm with limits of jerk as a curve with its time: pieces of constant jerk.

Straight in joints, up to a speed and down again by S-curves, joined by blends in time: from the
velocity of one piece to that of the next by an S-curve, too, within the zones.  So planning has
timed it; the shares of full speed at which corners are passed are the largest from which the rest
can be done (backwards); and that can be reached (forwards).  All that is done to the velocities of
the joints are S-curves, and a piece of one has the same jerk all along.

Source: Biagiotti and Melchiorri, "Trajectory Planning for Automatic Machines and Robots", Springer
2008, chapter 3.4.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats, frozen, put
from workbench.model.plan import Leg

QUICKEST = 0.001
"""[s] From one waypoint to an equal one."""

UNLIMITED = 1e18

MOST_HALVINGS = 50


@dataclass(frozen=True, slots=True, eq=False)
class JerkLimitedWay:
    """The curve of one leg and when it is where.

    Its parameter is the time [s] at the quickest pace that limits allow; `pace` is how fast that
    passes.  `starts` (k,) [s] are where its pieces begin, with `states` (k, 4, n): configuration,
    velocity, acceleration and jerk [rad, s]; `end` [s] is where it is at `goal` (n,) [rad].
    """

    starts: Floats
    states: Floats
    end: float
    goal: Floats
    acceleration: Floats
    pace: float

    def __post_init__(self) -> None:
        for name in ("starts", "states", "goal"):
            put(self, **{name: frozen(getattr(self, name))})

    @property
    def seconds(self) -> float:
        """How long it takes."""
        return self.end / self.pace

    def when(self, t: float) -> tuple[float, float]:
        """The parameter [s] and its speed at a time [s]."""
        return (self.end, 0.0) if t >= self.seconds else (t * self.pace, self.pace)

    def at(self, s: float) -> tuple[Floats, Floats, Floats]:
        """The configuration, q' and q'' (n,) at a parameter [s]."""
        if s >= self.end:
            return self.goal, np.zeros_like(self.goal), np.zeros_like(self.goal)
        k = max(int(np.searchsorted(self.starts, s, side="right")) - 1, 0)
        return _after(self.states[k], s - float(self.starts[k]))


def jerk_limited_way(
    leg: Leg, velocity: Floats, acceleration: Floats, jerk: Floats, zone: float
) -> JerkLimitedWay:
    """The curve of a leg, at the plan's times: no faster than it was timed.

    Args:
        leg: of the plan.
        velocity: largest joint speeds (n,) [rad/s], already scaled.
        acceleration: largest joint accelerations (n,) [rad/s2].
        jerk: largest joint jerks (n,) [rad/s3].
        zone: corner rounding, share of the shorter neighbouring segment, below 0.5.
    """
    q, t = np.array(leg.q[0], dtype=float), 0.0
    v, a = np.zeros_like(q), np.zeros_like(q)
    starts, states = [], []
    for seconds, pushed in _pieces(np.diff(leg.q, axis=0), velocity, acceleration, jerk, zone):
        if seconds > 0.0:
            starts.append(t)
            states.append(np.array([q, v, a, pushed]))
            q, v, a = _after(states[-1], seconds)
            t += seconds
    pace = min(t / leg.seconds, 1.0)
    return JerkLimitedWay(
        np.array(starts), np.array(states), t, leg.q[-1], np.array(acceleration), pace
    )


def _after(state: Floats, t: float) -> tuple[Floats, Floats, Floats]:
    """Configuration, velocity and acceleration a time [s] after a state (4, n)."""
    q, v, a, j = state
    return q + t * (v + t * (a / 2 + t * j / 6)), v + t * (a + t * j / 2), a + t * j


@dataclass(frozen=True, slots=True)
class _Curve:
    """What limits S-curves by which something changes: their slope [1/s] and curvature [1/s2]."""

    slope: float = UNLIMITED
    bend: float = UNLIMITED

    def seconds(self, change: float) -> float:
        """How long one takes."""
        if change * self.bend >= self.slope**2:
            return change / self.slope + self.slope / self.bend
        return 2.0 * math.sqrt(change / self.bend)

    def pieces(self, change: float, velocity: Floats) -> Iterator[tuple[float, Floats]]:
        """Seconds and jerks (n,) of one by which `velocity` (n,) is added."""
        if change > 0.0:
            whole = self.seconds(change)
            bends = min(self.slope / self.bend, whole / 2)
            jerk = velocity / (bends * (whole - bends))
            yield from ((bends, jerk), (whole - 2 * bends, 0 * jerk), (bends, -jerk))


def _pieces(
    steps: Floats, velocity: Floats, acceleration: Floats, jerk: Floats, zone: float
) -> Iterator[tuple[float, Floats]]:
    """How long each piece takes [s] and the jerks (n,) in it, of all of a leg."""
    full = np.array([min(_most(step, velocity), 1.0 / QUICKEST) for step in steps])
    fast = steps * full[:, None]
    ways = [_Curve(_most(v, acceleration), _most(v, jerk)) for v in fast]
    turns = np.diff(fast, axis=0)
    corners = [_Curve(), *(_Curve(_most(w, acceleration), _most(w, jerk)) for w in turns), _Curve()]

    def straight(k: int, begin: float, end: float) -> float:
        blends = begin * corners[k].seconds(begin) + end * corners[k + 1].seconds(end)
        return 1.0 - float(full[k]) * blends / 2

    def distance_for(k: int, begin: float, end: float, peak: float) -> float:
        into = (begin + peak) * ways[k].seconds(abs(peak - begin))
        return float(full[k]) * (into + (end + peak) * ways[k].seconds(abs(peak - end))) / 2

    def fits(k: int, begin: float, end: float, peak: float) -> bool:
        return distance_for(k, begin, end, peak) <= straight(k, begin, end)

    shares = [0.0] * (len(steps) + 1)
    for k in range(1, len(steps) if zone > 0.0 else 0):
        quick = float(max(full[k - 1], full[k]))
        shares[k] = _largest(lambda x, k=k, v=quick: v * x * corners[k].seconds(x) <= 2 * zone)
    for k in reversed(range(1, len(steps))):
        after = shares[k + 1]
        if after < shares[k]:
            shares[k] = _largest(lambda x, k=k, y=after: fits(k, x, y, x), after, shares[k])
    for k in range(len(steps)):
        before = shares[k]
        if before < shares[k + 1]:
            shares[k + 1] = _largest(
                lambda x, k=k, y=before: fits(k, y, x, x), before, shares[k + 1]
            )
    for k, velocities in enumerate(fast):
        begin, end = shares[k], shares[k + 1]
        peak = _largest(lambda p, k=k, x=begin, y=end: fits(k, x, y, p), max(begin, end))
        yield from ways[k].pieces(peak - begin, velocities * (peak - begin))
        steady = max(straight(k, begin, end) - distance_for(k, begin, end, peak), 0.0)
        yield steady / (float(full[k]) * peak), 0 * velocities
        yield from ways[k].pieces(peak - end, -velocities * (peak - end))
        if k < len(turns):
            yield from corners[k + 1].pieces(end, turns[k] * end)


def _most(moves: Floats, limits: Floats) -> float:
    """The largest factor by which `moves` (n,) stay within their limits (n,)."""
    at = moves != 0.0
    return float((limits[at] / np.abs(moves[at])).min(initial=UNLIMITED))


def _largest(holds: Callable[[float], bool], low: float = 0.0, high: float = 1.0) -> float:
    """The largest number up to `high` for which something holds that holds at `low`."""
    if holds(high):
        return high
    for _ in range(MOST_HALVINGS):
        middle = (low + high) / 2.0
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low

"""How soon joints get somewhere, and of all ways to hold a tool those that are reached soonest.

An arm with a spare axis holds its tool at a place in a family of ways.  Along it the time to and
from other configurations changes by half: the joint that has furthest to go decides, so that the
way is quickest where several joints share it.
"""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.geometry import Floats
from workbench.planning.compiled import njit_in_place
from workbench.planning.kinematics.chain import (
    POSITION_TOLERANCE,
    ROTATION_TOLERANCE,
    Chain,
    chain_of,
    solve_from_starts,
)
from workbench.planning.kinematics.jerk_limited import UNLIMITED

DESCENT_STEPS = 10
"""Steps that a configuration is drawn by."""

BRIEFLY = 8
"""Iterations of the inverse kinematics after each step: it begins next to an answer."""

FIRST_STEP = 0.25
"""[rad] Of the joint that is moved most: longer while that brings something, shorter otherwise."""

LONGER, SHORTER = 1.3, 0.4

LEAST_GAIN = 1e-3
"""[s] By less than this nothing is won."""


@dataclass(frozen=True, slots=True, eq=False)
class Pace:
    """The largest speeds (n,) [rad/s] and accelerations (n,) [rad/s2] of an arm's joints.

    So are jerks (n,) [rad/s3], where acceleration may not jump.
    """

    velocity: Floats
    acceleration: Floats
    jerk: Floats | None = None

    def seconds(self, far: Floats) -> Floats:
        """What joints need at least for distances (..., n) [rad], from rest to rest (...) [s].

        No motion that begins and ends at rest is quicker, whatever its way.
        """
        far = np.abs(far)
        if self.jerk is not None:
            return self._by_s_curves(far, self.jerk).max(axis=-1)
        # Up to speed and down again, or never quite up to speed.
        ramps = self.velocity / self.acceleration
        times = np.where(
            far >= self.velocity * ramps,
            far / self.velocity + ramps,
            2.0 * np.sqrt(far / self.acceleration),
        )
        return times.max(axis=-1)

    def _by_s_curves(self, far: Floats, jerk: Floats) -> Floats:
        """What each joint needs for its distance (..., n) [s]."""
        jerk = np.minimum(jerk, UNLIMITED)  # of arms in step, one may have no limit
        # Of the speed that is reached where acceleration has its largest value only for a moment.
        sudden = self.acceleration**2 / jerk
        peak = np.where(
            far >= 2.0 * sudden * self.acceleration / jerk,
            (np.sqrt(sudden**2 + 4.0 * self.acceleration * far) - sudden) / 2.0,
            np.cbrt(far**2 * jerk / 4.0),
        )
        speed = np.maximum(np.minimum(peak, self.velocity), 1e-12)
        ramps = np.where(
            speed >= sudden,
            speed / self.acceleration + self.acceleration / jerk,
            2.0 * np.sqrt(speed / jerk),
        )
        return np.where(far > 0.0, far / speed + ramps, 0.0)


def pace_of(chain: Chain, share: float) -> Pace:
    """The pace of an arm that is allowed this share of its speeds."""
    return Pace(chain.velocity * share, chain.acceleration, chain.jerk)


def hand_acceleration(cell: Cell, arm: Arm) -> float:
    """The most [m/s2] by which one joint of an arm moves its hand at home from rest."""
    chain, home, step = chain_of(cell, arm), np.asarray(arm.home), 1e-5
    here = chain.pose(home).translation
    ways = [
        np.linalg.norm(chain.pose(home + step * direction).translation - here) / step
        for direction in np.eye(len(home))
    ]
    return float(np.max(np.array(ways) * np.asarray(arm.acceleration)))


def tool_acceleration(cell: Cell, tool: Tool) -> float | None:
    """The same of a tool: the largest of the arms that can carry it, None where none can."""
    return max(
        (
            hand_acceleration(cell, replace(arm, tool=tool))
            for arm in cell.arms
            if tool.name in (arm.tool.name, *(known_tool.name for known_tool in arm.tools))
        ),
        default=None,
    )


def seconds_to_all(q: Floats, stops: Floats, pace: Pace) -> Floats:
    """What it takes at least from each of `q` (k, n) [rad] to all of `stops` (s, n): (k,) [s]."""
    return pace.seconds(q[:, None] - stops).sum(axis=1)


def legs_seconds(ends: Floats, pace: Pace) -> float:
    """What legs from each of `ends` (m, n) [rad] to the next take at least [s], at rest between."""
    far = np.diff(ends, axis=0)
    return float(pace.seconds(far).sum())


def draw_towards(
    chain: Chain, T_world_tcp: pin.SE3, q: Floats, stops: Floats, pace: Pace
) -> Floats:
    """Move redundant configurations (k, n) [rad] to be nearer in time to `stops`.

    A gradient step reduces the travel time; inverse kinematics then restores the pose of the tool
    by the smallest change.  The result is used only if it is quicker.

    Args:
        chain: of the arm.
        T_world_tcp: pose of its tool at each of `q`.
        q: configurations (k, n) [rad]; without a redundant axis they stay the same.
        stops: (s, n) [rad] configurations before and after.
        pace: limits of the joints.
    """
    if q.shape[1] <= 6 or len(q) == 0:
        return q
    T = np.ascontiguousarray(T_world_tcp.rotation), np.ascontiguousarray(T_world_tcp.translation)
    # Copies can be written to: read-only arrays would be compiled for once more.
    best = np.array(q, order="C")
    _draw(best, np.array(stops, order="C"), pace.velocity, pace.acceleration, *T, chain.arrays)
    return best


@njit(cache=True)
def _draw(
    best: Floats,
    stops: Floats,
    velocity: Floats,
    acceleration: Floats,
    R_t: Floats,
    p_t: Floats,
    chain: tuple[Floats, Floats, Floats, Floats, Floats, Floats],
) -> None:
    """Move configurations `best` (k, n) [rad]; see `draw_towards`."""
    count, n = best.shape
    slopes, starts = np.empty((count, n)), np.empty((count, n))
    steps, least = np.full(count, FIRST_STEP), np.empty(count)
    for k in range(count):
        least[k] = _seconds(best[k], stops, velocity, acceleration)
    for _ in range(DESCENT_STEPS):
        for k in range(count):
            _slope(best[k], stops, velocity, slopes[k])
            for i in range(n):
                starts[k, i] = best[k, i] - steps[k] * slopes[k, i]
        answers, residuals = solve_from_starts(*chain, R_t, p_t, starts, BRIEFLY)
        for k in range(count):
            seconds = _seconds(answers[k], stops, velocity, acceleration)
            is_there = residuals[k, 0] < POSITION_TOLERANCE and residuals[k, 1] < ROTATION_TOLERANCE
            if is_there and seconds < least[k] - LEAST_GAIN:
                for i in range(n):
                    best[k, i] = answers[k, i]
                least[k] = seconds
                steps[k] *= LONGER
            else:
                steps[k] *= SHORTER


@njit_in_place
def _seconds(q: Floats, stops: Floats, velocity: Floats, acceleration: Floats) -> float:
    """As `seconds_to_all`, of one configuration (n,)."""
    total = 0.0
    for s in range(len(stops)):
        longest = 0.0
        for i in range(len(q)):
            far, ramp = abs(q[i] - stops[s, i]), velocity[i] / acceleration[i]
            if far >= velocity[i] * ramp:
                longest = max(longest, far / velocity[i] + ramp)
            else:
                longest = max(longest, 2.0 * np.sqrt(far / acceleration[i]))
        total += longest
    return total


@njit_in_place
def _slope(q: Floats, stops: Floats, velocity: Floats, slope: Floats) -> None:
    """Write (n,) by what share joints have to be turned for the time to grow most."""
    for i in range(len(q)):
        slope[i] = 0.0
    for s in range(len(stops)):
        furthest = 1e-9
        for i in range(len(q)):
            furthest = max(furthest, abs((q[i] - stops[s, i]) / velocity[i]))
        for i in range(len(q)):
            # Each joint moves as its time, as a share of the longest, to the sixth power: as
            # products, since powers differ in the last digit by processor.
            away = (q[i] - stops[s, i]) / velocity[i]
            share = (away / furthest) * (away / furthest)
            slope[i] += np.sign(away) * (share * share * share) / velocity[i]
    most = 1e-9
    for i in range(len(q)):
        most = max(most, abs(slope[i]))
    for i in range(len(q)):
        slope[i] /= most

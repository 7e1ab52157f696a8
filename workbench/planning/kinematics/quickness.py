"""How soon joints get somewhere, and of all ways to hold a tool those that are reached soonest.

An arm with a spare axis holds its tool at a place in a family of ways.  Along it the time to and
from other configurations changes by half: the joint that has furthest to go decides, so that the
way is quickest where several joints share it.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.planning.kinematics.chain import Chain, is_solution

ROUNDS = 10
"""Steps that a configuration is drawn by."""

FIRST_STEP = 0.25
"""[rad] Of the joint that is moved most: longer while that brings something, shorter otherwise."""

LONGER, SHORTER = 1.3, 0.4

LEAST = 1e-3
"""[s] By less than this nothing is won."""


@dataclass(frozen=True, slots=True, eq=False)
class Pace:
    """The largest speeds (n,) [rad/s] and accelerations (n,) [rad/s2] of an arm's joints."""

    velocity: Floats
    acceleration: Floats

    def seconds(self, far: Floats) -> Floats:
        """What joints need at least for distances (..., n) [rad], from rest to rest (...) [s].

        No motion that begins and ends at rest is quicker, whatever its way.
        """
        far = np.abs(far)
        # Up to speed and down again, or never quite up to speed.
        ramps = self.velocity / self.acceleration
        times = np.where(
            far >= self.velocity * ramps,
            far / self.velocity + ramps,
            2.0 * np.sqrt(far / self.acceleration),
        )
        return times.max(axis=-1)


def pace_of(chain: Chain, share: float) -> Pace:
    """The pace of an arm that is allowed this share of its speeds."""
    return Pace(chain.velocity * share, chain.acceleration)


def between(q: Floats, stops: Floats, pace: Pace) -> Floats:
    """What it takes at least from each of `q` (k, n) [rad] to all of `stops` (s, n): (k,) [s]."""
    return pace.seconds(q[:, None] - stops).sum(axis=1)


def legs_seconds(ends: Floats, pace: Pace) -> float:
    """What legs from each of `ends` (m, n) [rad] to the next take at least [s], at rest between."""
    far = np.diff(ends, axis=0)
    return float(pace.seconds(far).sum())


def drawn(chain: Chain, T_world_tcp: pin.SE3, q: Floats, stops: Floats, pace: Pace) -> Floats:
    """Configurations (k, n) [rad] moved along their families, to be nearer in time to `stops`.

    Steps against the slope of the time are brought back to where the tool is as it was, which
    inverse kinematics does by the shortest way; what is not quicker then is not taken.

    Args:
        chain: of the arm.
        T_world_tcp: where its tool is at each of `q`.
        q: configurations (k, n) [rad]; of an arm without a spare axis nothing is moved.
        stops: (s, n) [rad] where the arm comes from or goes to.
        pace: of its joints.
    """
    if q.shape[1] <= 6 or len(q) == 0:
        return q
    best, steps = q.copy(), np.full(len(q), FIRST_STEP)
    least = between(best, stops, pace)
    for _ in range(ROUNDS):
        away = (best[:, None] - stops) / pace.velocity
        furthest = np.maximum(np.abs(away).max(axis=2, keepdims=True), 1e-9)
        # Each joint moves as its time, as a share of the longest, to the sixth power: as products,
        # since powers differ in the last digit by processor.
        share = (away / furthest) * (away / furthest)
        slope = np.sign(away) * (share * share * share) / pace.velocity
        slope = slope.sum(axis=1)
        slope /= np.maximum(np.abs(slope).max(axis=1, keepdims=True), 1e-9)
        answers, residuals = chain.solve(T_world_tcp, best - steps[:, None] * slope, iterations=8)
        times = between(answers, stops, pace)
        is_better = is_solution(residuals) & (times < least - LEAST)
        best[is_better], least[is_better] = answers[is_better], times[is_better]
        steps *= np.where(is_better, LONGER, SHORTER)
    return best

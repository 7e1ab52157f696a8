"""Whether a leg with limited jerk is possible with the times of a plan.

`s_curves` searches a motion of S-curves; `_keeps` and `_passes` check it independently.  In a piece
of constant jerk the acceleration of a joint is linear in time, its speed quadratic.  Both are
largest at the ends or where the acceleration is zero.  So the limits hold along the whole curve.
In a corner the velocity changes along one line, symmetric about the middle and steepest there.  So
the curve stays between the corner and the parabola that touches both lines where the change begins
and ends.
"""

from typing import NamedTuple

import numpy as np

from workbench.model.geometry import Floats
from workbench.proof.claims.timing.s_curves import (
    ROUNDING_SHARE,
    SOONEST,
    Allowed,
    allowed_by,
    change,
    mixed_shares,
    peaks_for,
    quickest_shares,
    seconds_at,
    way,
)


class Limits(NamedTuple):
    """Largest joint speeds, accelerations and jerks (n,) [rad, m, s]; a jerk may be infinite."""

    velocity: Floats
    acceleration: Floats
    jerk: Floats


def find_segment_over_jerk_limit(steps: Floats, times: Floats, limits: Limits, zone: float) -> int:
    """The segment at which the best attempt failed, or -1 if the planned times are feasible.

    A motion of another kind than is searched for may be missed.

    Args:
        steps: the ways (m, n) [rad, m].
        times: what each should take (m,) [s].
        limits: of the joints.
        zone: how much of a way a corner may take; 0 stops in each.
    """
    pace, farthest = 1.0, 0
    tried: list[tuple[Allowed, Floats]] = []
    for _ in range(2):
        # The quickest motion with limits as a slower clock has them is that of the same limits,
        # slower by that clock.
        velocity, acceleration, jerk = (limit * pace**k for k, limit in enumerate(limits, start=1))
        allowed = allowed_by(steps, velocity, acceleration, jerk, SOONEST / pace)
        shares = quickest_shares(allowed, zone)
        pace = min(seconds_at(allowed, shares) / float(times.sum()), 1.0)
        tried.append((allowed, shares))
        peaks, row = peaks_for(allowed, shares, times)
        if row < 0 and _is_motion(steps, times, limits, zone, allowed, shares=shares, peaks=peaks):
            return -1
        farthest = max(farthest, row)
    for allowed, shares in tried:
        mixed, row = mixed_shares(allowed, shares, times)
        peaks, row = peaks_for(allowed, mixed, times) if row < 0 else (shares, row)
        if row < 0 and _is_motion(steps, times, limits, zone, allowed, shares=mixed, peaks=peaks):
            return -1
        farthest = max(farthest, row)
    return farthest


def _changing(velocity: Floats, far: float, allowed: Floats) -> tuple[Floats, Floats]:
    """Seconds (3,) and jerks (3, n) of the pieces in which `velocity` (n,) is added."""
    seconds = change(far, allowed)
    bends = min(allowed[0] / allowed[1], seconds / 2.0)
    jerk = velocity / max(bends * (seconds - bends), 1e-300)
    return np.array([bends, seconds - 2.0 * bends, bends]), np.array([jerk, 0.0 * jerk, -jerk])


def _is_motion(
    steps: Floats,
    times: Floats,
    limits: Limits,
    zone: float,
    allowed: Allowed,
    *,
    shares: Floats,
    peaks: Floats,
) -> bool:
    """Whether shares (m + 1,) at corners and peaks (m,) between them are a motion as planned."""
    full, along, across = allowed
    fast = steps * full[:, None]
    seconds, jerks = [], []
    for k, velocity in enumerate(fast):
        begin, end, peak = shares[k], shares[k + 1], peaks[k]
        _, steady = way(full[k], along[k], across[k], across[k + 1], begin, end, peak)
        up = _changing((peak - begin) * velocity, abs(peak - begin), along[k])
        down = _changing((end - peak) * velocity, abs(peak - end), along[k])
        seconds += [up[0], [max(steady, 0.0) / (full[k] * peak)], down[0]]
        jerks += [up[1], np.zeros((1, len(velocity))), down[1]]
        if k + 1 < len(fast):
            # The corner is passed in the middle of the middle piece.
            (bends, turns, _), pushes = _changing(
                end * (fast[k + 1] - velocity), end, across[k + 1]
            )
            seconds += [[bends, turns / 2.0, turns / 2.0, bends]]
            jerks += [pushes[[0, 1, 1, 2]]]
    t, jerk = np.concatenate(seconds), np.concatenate(jerks)
    return _keeps(t, jerk, limits) and _passes(t, jerk, steps, times, zone)


def _states(t: Floats, jerk: Floats) -> tuple[Floats, Floats, Floats]:
    """Accelerations, velocities and places (p + 1, n) between pieces, from rest and from zero."""
    zero, dt = np.zeros((1, jerk.shape[1])), t[:, None]
    a = np.vstack([zero, np.cumsum(jerk * dt, axis=0)])
    v = np.vstack([zero, np.cumsum((a[:-1] + jerk * dt / 2) * dt, axis=0)])
    steps = (v[:-1] + (a[:-1] / 2 + jerk * dt / 6) * dt) * dt
    return a, v, np.vstack([zero, np.cumsum(steps, axis=0)])


def _keeps(t: Floats, jerk: Floats, limits: Limits) -> bool:
    """Whether pieces of jerks (p, n) that take `t` (p,) [s] keep to the limits all along."""
    a, v, _ = _states(t, jerk)
    # Where acceleration is zero within a piece, a joint is as fast as it gets there.
    turns = a[:-1] * a[1:] < 0.0
    between = v[:-1] - np.where(turns, a[:-1] ** 2 / (2.0 * np.where(turns, jerk, 1.0)), 0.0)
    pairs = ((jerk, limits.jerk), (a, limits.acceleration), (v, limits.velocity))
    is_kept = all((np.abs(found) <= most * (1.0 + ROUNDING_SHARE)).all() for found, most in pairs)
    return is_kept and bool((np.abs(between) <= limits.velocity * (1.0 + ROUNDING_SHARE)).all())


def _passes(t: Floats, jerk: Floats, steps: Floats, times: Floats, zone: float) -> bool:
    """Whether pieces, seven a way and four a corner, follow the ways and take as long as planned.

    On a way and in a corner jerks are multiples of one vector: where they begin and end says all.
    """
    a, v, q = _states(t, jerk)
    at, ends = np.concatenate([[0.0], np.cumsum(t)]), np.vstack([0 * steps[:1], steps]).cumsum(0)
    fine = ROUNDING_SHARE * (np.abs(steps).sum(axis=0).max() + ROUNDING_SHARE)
    corners = np.arange(1, len(steps)) * 11 - 4  # where blends begin
    if not (
        (t >= 0.0).all()
        and np.abs(at[np.append(corners + 2, -1)] - np.cumsum(times)).max()
        <= ROUNDING_SHARE * times.sum()
        and np.abs(q[-1] - ends[-1]).max() <= fine
        and max(np.abs(v[-1]).max() * times.sum(), np.abs(a[-1]).max() * times.sum() ** 2) <= fine
    ):
        return False
    sides = ((q[corners], steps[:-1], -1.0), (q[corners + 4], steps[1:], 1.0))
    for place, step, side in sides:
        off = side * (place - ends[1:-1])
        share = (off * step).sum(axis=1) / np.maximum((step * step).sum(axis=1), ROUNDING_SHARE**2)
        if (np.abs(off - share[:, None] * step) > fine).any():
            return False
        if ((share < -ROUNDING_SHARE) | (share > zone + ROUNDING_SHARE)).any():
            return False
    return True

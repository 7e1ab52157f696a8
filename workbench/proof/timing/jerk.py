"""Whether a leg can be as a plan says where jerk is limited: a motion is looked for, and checked.

Looked for is one of pieces with constant jerk: on each way up from the share of its full speed at
which the corner before is passed to a peak, steady, and on to the share of the corner after; in a
corner over from the velocity of the one way to that of the other.  What is found is believed in
nothing (`_keeps`, `_passes`): in a piece the acceleration of a joint is linear in time, its speed
quadratic, so that both are largest at its ends or where the one is zero: limits are asked along the
whole curve.  In a corner velocity changes along one line, by the same slope before the
middle as after it, steepest in the middle: so the curve stays between the corner and the parabola
that touches both ways where the change begins and ends.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Floats

SOONEST = 0.001
"""[s] From a waypoint to an equal one."""

FREE = 1e18
"""How fast a share may change where no joint that has a limit moves."""

NEAR = 1e-6
"""Share of a limit, of a zone and of a time that rounding may decide."""

HALVINGS = 50

SHARES = np.array([1.0, 0.97, 0.93, 0.85, 0.75, 0.64, 0.5, 0.36, 0.2, 0.1, 0.03, 0.0])
"""Of the fastest at a corner, which are tried where simpler ones find nothing."""


Allowed = tuple[Floats, Floats, Floats]
"""What ways allow, as `_allowed` says."""


class Limits(NamedTuple):
    """Largest joint speeds, accelerations and jerks (n,) [rad, m, s]; a jerk may be infinite."""

    velocity: Floats
    acceleration: Floats
    jerk: Floats


def jerky_at(steps: Floats, times: Floats, limits: Limits, zone: float) -> int:
    """The number of the first way that cannot take as long as it should; -1 for none.

    A motion of another kind than is looked for may be missed.

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
        velocity, acceleration, jerk = (one * pace**k for k, one in enumerate(limits, start=1))
        allowed = _allowed(steps, velocity, acceleration, jerk, SOONEST / pace)
        shares = _quickest(allowed, zone)
        pace = min(_seconds(allowed, shares) / float(times.sum()), 1.0)
        tried.append((allowed, shares))
        peaks, row = _peaks(allowed, shares, times)
        if row < 0 and _is_one(steps, times, limits, zone, allowed, shares, peaks):
            return -1
        farthest = max(farthest, row)
    for allowed, shares in tried:
        mixed, row = _mixed(allowed, shares, times)
        peaks, row = _peaks(allowed, mixed, times) if row < 0 else (shares, row)
        if row < 0 and _is_one(steps, times, limits, zone, allowed, mixed, peaks):
            return -1
        farthest = max(farthest, row)
    return farthest


@njit(cache=True)
def _allowed(
    steps: Floats, velocity: Floats, acceleration: Floats, jerk: Floats, soonest: float
) -> Allowed:  # pragma: no cover (compiled)
    """Full speeds (m,) [1/s] of ways, and how a share of these may change [1/s, 1/s2].

    That is along ways (m, 2), and in corners (m + 1, 2), where all of it comes to be that of the
    next way.
    """
    count = len(steps)
    full, along, across = np.empty(count), np.empty((count, 2)), np.full((count + 1, 2), FREE)
    for k in range(count):
        full[k] = min(_factor(steps[k], velocity), 1.0 / soonest)
        along[k, 0] = _factor(full[k] * steps[k], acceleration)
        along[k, 1] = _factor(full[k] * steps[k], jerk)
    for k in range(1, count):
        change = full[k] * steps[k] - full[k - 1] * steps[k - 1]
        across[k, 0], across[k, 1] = _factor(change, acceleration), _factor(change, jerk)
    return full, along, across


@njit(cache=True)
def _factor(moves: Floats, limits: Floats) -> float:  # pragma: no cover (compiled)
    """How often `moves` (n,) fit into their limits (n,)."""
    factor = FREE
    for j in range(len(moves)):
        if abs(moves[j]) > 0.0:
            factor = min(factor, limits[j] / abs(moves[j]))
    return factor


@njit(cache=True)
def _change(far: float, allowed: Floats) -> float:  # pragma: no cover (compiled)
    """What a share needs to change [s], from and to where it stays as it is."""
    slope, bend = allowed[0], allowed[1]
    if far > slope * slope / bend:
        return far / slope + slope / bend
    return 2.0 * np.sqrt(far / bend)


@njit(cache=True)
def _way(
    full: float, along: Floats, here: Floats, there: Floats, begin: float, end: float, peak: float
) -> tuple[float, float]:  # pragma: no cover (compiled)
    """How long [s] a way takes between the middles of its corners, and what is steady of it.

    The second is a share of the way, below 0 where there is not room for the changes.
    """
    into, out = _change(begin, here) / 2.0, _change(end, there) / 2.0
    up, down = _change(abs(peak - begin), along), _change(abs(peak - end), along)
    far = begin * into + end * out + (begin + peak) / 2.0 * up + (peak + end) / 2.0 * down
    steady = 1.0 - full * far
    if peak == 0.0:
        return np.inf, steady
    return into + out + up + down + max(steady, 0.0) / (full * peak), steady


@njit(cache=True)
def _quickest(allowed: Allowed, zone: float) -> Floats:  # pragma: no cover (compiled)
    """The largest shares (m + 1,) at corners, from rest to rest."""
    full, along, across = allowed
    count = len(full)
    shares = np.zeros(count + 1)
    if zone == 0.0:
        return shares
    for k in range(1, count):
        low, high, quick = 0.0, 1.0, max(full[k - 1], full[k])
        for number in range(HALVINGS):
            share = high if number == 0 else (low + high) / 2.0
            if quick * share * _change(share, across[k]) / 2.0 <= zone:
                low = share
            else:
                high = share
        shares[k] = low
    for k in range(count - 1, 0, -1):
        # From the corner before way k it has to come down to the share at that after it.
        shares[k] = _reached(full[k], along[k], across[k], across[k + 1], shares[k], shares[k + 1])
    for k in range(1, count):
        shares[k] = _reached(
            full[k - 1], along[k - 1], across[k], across[k - 1], shares[k], shares[k - 1]
        )
    return shares


@njit(cache=True)
def _reached(
    full: float, along: Floats, here: Floats, there: Floats, most: float, other: float
) -> float:  # pragma: no cover (compiled)
    """The largest share up to `most` at the one end of a way, with `other` at its other end."""
    if most <= other:
        return most
    low, high = other, most
    for number in range(HALVINGS):
        share = high if number == 0 else (low + high) / 2.0
        if _way(full, along, here, there, share, other, share)[1] >= 0.0:
            low = share
        else:
            high = share
    return low


@njit(cache=True)
def _peak(
    full: float, along: Floats, here: Floats, there: Floats, begin: float, end: float
) -> float:  # pragma: no cover (compiled)
    """The highest share in the middle of a way, 0 where there is not room for any."""
    low, high = max(begin, end), 1.0
    if _way(full, along, here, there, begin, end, low)[1] < -NEAR / 1000.0:
        return 0.0
    for number in range(HALVINGS):
        share = high if number == 0 else (low + high) / 2.0
        if _way(full, along, here, there, begin, end, share)[1] >= 0.0:
            low = share
        else:
            high = share
    return low


@njit(cache=True)
def _peak_for(
    full: float,
    along: Floats,
    here: Floats,
    there: Floats,
    begin: float,
    end: float,
    planned: float,
) -> float:  # pragma: no cover (compiled)
    """The share in the middle of a way with which it takes as long as planned [s]; 0 for none."""
    high = _peak(full, along, here, there, begin, end)
    if high == 0.0:
        return 0.0
    seconds, _ = _way(full, along, here, there, begin, end, high)
    if planned <= seconds:
        return high if planned >= seconds * (1.0 - NEAR) else 0.0
    low = 0.0
    for _ in range(HALVINGS):
        share = (low + high) / 2.0
        if _way(full, along, here, there, begin, end, share)[0] > planned:
            low = share
        else:
            high = share
    seconds, steady = _way(full, along, here, there, begin, end, high)
    is_found = steady >= -NEAR / 1000.0 and abs(seconds - planned) <= NEAR * planned
    return high if is_found else 0.0


@njit(cache=True)
def _peaks(
    allowed: Allowed, shares: Floats, times: Floats
) -> tuple[Floats, int]:  # pragma: no cover (compiled)
    """The shares (m,) in the middle of ways, and the first for which there is none, or -1."""
    full, along, across = allowed
    peaks = np.zeros(len(full))
    for k in range(len(full)):
        peaks[k] = _peak_for(
            full[k], along[k], across[k], across[k + 1], shares[k], shares[k + 1], times[k]
        )
        if peaks[k] == 0.0:
            return peaks, k
    return peaks, -1


@njit(cache=True)
def _seconds(allowed: Allowed, shares: Floats) -> float:  # pragma: no cover (compiled)
    """How long [s] a leg takes at the quickest with these shares (m + 1,) at corners."""
    full, along, across = allowed
    total = 0.0
    for k in range(len(full)):
        begin, end = shares[k], shares[k + 1]
        peak = _peak(full[k], along[k], across[k], across[k + 1], begin, end)
        total += _way(full[k], along[k], across[k], across[k + 1], begin, end, peak)[0]
    return total


@njit(cache=True)
def _mixed(
    allowed: Allowed, quickest: Floats, times: Floats
) -> tuple[Floats, int]:  # pragma: no cover (compiled)
    """Shares (m + 1,) among `SHARES` of the quickest with which each way takes as long as planned.

    And the first way that no such share gets over, or -1.
    """
    full, along, across = allowed
    count, tries = len(full), len(SHARES)
    came_from = np.full((count + 1, tries), -1)
    came_from[0, 0] = 0
    for k in range(count):
        for n in range(tries):
            for m in range(tries):
                if came_from[k, m] >= 0 and came_from[k + 1, n] < 0:
                    peak = _peak_for(
                        full[k], along[k], across[k], across[k + 1],
                        quickest[k] * SHARES[m], quickest[k + 1] * SHARES[n], times[k],
                    )  # fmt: skip
                    if peak > 0.0:
                        came_from[k + 1, n] = m
        if came_from[k + 1].max() < 0:
            return quickest, k
    shares, n = np.zeros(count + 1), int(np.argmax(came_from[count] >= 0))
    for k in range(count, 0, -1):
        shares[k] = quickest[k] * SHARES[n]
        n = came_from[k, n]
    return shares, -1


def _changing(velocity: Floats, far: float, allowed: Floats) -> tuple[Floats, Floats]:
    """Seconds (3,) and jerks (3, n) of the pieces in which `velocity` (n,) is added."""
    seconds = _change(far, allowed)
    bends = min(allowed[0] / allowed[1], seconds / 2.0)
    jerk = velocity / max(bends * (seconds - bends), 1e-300)
    return np.array([bends, seconds - 2.0 * bends, bends]), np.array([jerk, 0.0 * jerk, -jerk])


def _is_one(
    steps: Floats,
    times: Floats,
    limits: Limits,
    zone: float,
    allowed: Allowed,
    shares: Floats,
    peaks: Floats,
) -> bool:
    """Whether shares (m + 1,) at corners and peaks (m,) between them are a motion as planned."""
    full, along, across = allowed
    fast = steps * full[:, None]
    seconds, jerks = [], []
    for k, velocity in enumerate(fast):
        begin, end, peak = shares[k], shares[k + 1], peaks[k]
        _, steady = _way(full[k], along[k], across[k], across[k + 1], begin, end, peak)
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
    is_kept = all((np.abs(found) <= most * (1.0 + NEAR)).all() for found, most in pairs)
    return is_kept and bool((np.abs(between) <= limits.velocity * (1.0 + NEAR)).all())


def _passes(t: Floats, jerk: Floats, steps: Floats, times: Floats, zone: float) -> bool:
    """Whether pieces, seven a way and four a corner, follow the ways and take as long as planned.

    On a way and in a corner jerks are multiples of one vector: where they begin and end says all.
    """
    a, v, q = _states(t, jerk)
    at, ends = np.concatenate([[0.0], np.cumsum(t)]), np.vstack([0 * steps[:1], steps]).cumsum(0)
    fine = NEAR * (np.abs(steps).sum(axis=0).max() + NEAR)
    corners = np.arange(1, len(steps)) * 11 - 4  # where blends begin
    if not (
        (t >= 0.0).all()
        and np.abs(at[np.append(corners + 2, -1)] - np.cumsum(times)).max() <= NEAR * times.sum()
        and np.abs(q[-1] - ends[-1]).max() <= fine
        and max(np.abs(v[-1]).max() * times.sum(), np.abs(a[-1]).max() * times.sum() ** 2) <= fine
    ):
        return False
    sides = ((q[corners], steps[:-1], -1.0), (q[corners + 4], steps[1:], 1.0))
    for place, step, side in sides:
        off = side * (place - ends[1:-1])
        share = (off * step).sum(axis=1) / np.maximum((step * step).sum(axis=1), NEAR**2)
        if (np.abs(off - share[:, None] * step) > fine).any():
            return False
        if ((share < -NEAR) | (share > zone + NEAR)).any():
            return False
    return True

"""Compiled: a motion of S-curves along ways that passes each waypoint when it should.

On each way it goes up from the share of the way's full speed at which the corner before is passed
to a peak; steady, and on to the share of the corner after; in a corner over from the velocity of
the one way to that of the other.  Corners are passed as fast as can be, or at some shares of that.
Motions of other kinds are not searched for.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats

SOONEST = 0.001
"""[s] From a waypoint to an equal one."""

FREE = 1e18
"""How fast a share may change where no joint that has a limit moves."""

ROUNDING_SHARE = 1e-6
"""Share of a limit, of a zone and of a time that rounding may decide."""

MOST_HALVINGS = 50

SHARES_TRIED = np.array([1.0, 0.97, 0.93, 0.85, 0.75, 0.64, 0.5, 0.36, 0.2, 0.1, 0.03, 0.0])
"""Of the fastest at a corner, which are tried where simpler ones find nothing."""


Allowed = tuple[Floats, Floats, Floats]
"""What ways allow, as `allowed_by` says."""


@njit(cache=True)
def allowed_by(
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
def change(far: float, allowed: Floats) -> float:  # pragma: no cover (compiled)
    """Shortest duration [s] of a change of a share by `far`, starting and ending at rest.

    `allowed` (2,) [1/s, 1/s2] are its largest rate and second derivative.
    """
    slope, bend = allowed[0], allowed[1]
    if far > slope * slope / bend:
        return far / slope + slope / bend
    return 2.0 * np.sqrt(far / bend)


@njit(cache=True)
def way(
    full: float, along: Floats, here: Floats, there: Floats, begin: float, end: float, peak: float
) -> tuple[float, float]:  # pragma: no cover (compiled)
    """How long [s] a way takes between the middles of its corners, and what is steady of it.

    The second is a share of the way, below 0 where there is not room for the changes.

    Along the way and in both corners shares change by `along`, `here` and `there` (2,)
    [1/s, 1/s2].
    """
    into, out = change(begin, here) / 2.0, change(end, there) / 2.0
    up, down = change(abs(peak - begin), along), change(abs(peak - end), along)
    far = begin * into + end * out + (begin + peak) / 2.0 * up + (peak + end) / 2.0 * down
    steady = 1.0 - full * far
    if peak == 0.0:
        return np.inf, steady
    return into + out + up + down + max(steady, 0.0) / (full * peak), steady


@njit(cache=True)
def quickest_shares(allowed: Allowed, zone: float) -> Floats:  # pragma: no cover (compiled)
    """The largest shares (m + 1,), no unit, at corners, from rest to rest."""
    full, along, across = allowed
    count = len(full)
    shares = np.zeros(count + 1)
    if zone == 0.0:
        return shares
    for k in range(1, count):
        low, high, quick = 0.0, 1.0, max(full[k - 1], full[k])
        for number in range(MOST_HALVINGS):
            share = high if number == 0 else (low + high) / 2.0
            if quick * share * change(share, across[k]) / 2.0 <= zone:
                low = share
            else:
                high = share
        shares[k] = low
    for k in range(count - 1, 0, -1):
        # From the corner before way k it has to come down to the share at that after it.
        shares[k] = _reachable_share(
            full[k], along[k], across[k], across[k + 1], shares[k], shares[k + 1]
        )
    for k in range(1, count):
        shares[k] = _reachable_share(
            full[k - 1], along[k - 1], across[k], across[k - 1], shares[k], shares[k - 1]
        )
    return shares


@njit(cache=True)
def _reachable_share(
    full: float, along: Floats, here: Floats, there: Floats, most: float, other: float
) -> float:  # pragma: no cover (compiled)
    """The largest share up to `most` at the one end of a way, with `other` at its other end."""
    if most <= other:
        return most
    low, high = other, most
    for number in range(MOST_HALVINGS):
        share = high if number == 0 else (low + high) / 2.0
        if way(full, along, here, there, share, other, share)[1] >= 0.0:
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
    if way(full, along, here, there, begin, end, low)[1] < -ROUNDING_SHARE / 1000.0:
        return 0.0
    for number in range(MOST_HALVINGS):
        share = high if number == 0 else (low + high) / 2.0
        if way(full, along, here, there, begin, end, share)[1] >= 0.0:
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
    seconds, _ = way(full, along, here, there, begin, end, high)
    if planned <= seconds:
        return high if planned >= seconds * (1.0 - ROUNDING_SHARE) else 0.0
    low = 0.0
    for _ in range(MOST_HALVINGS):
        share = (low + high) / 2.0
        if way(full, along, here, there, begin, end, share)[0] > planned:
            low = share
        else:
            high = share
    seconds, steady = way(full, along, here, there, begin, end, high)
    is_found = (
        steady >= -ROUNDING_SHARE / 1000.0 and abs(seconds - planned) <= ROUNDING_SHARE * planned
    )
    return high if is_found else 0.0


@njit(cache=True)
def peaks_for(
    allowed: Allowed, shares: Floats, times: Floats
) -> tuple[Floats, int]:  # pragma: no cover (compiled)
    """The shares in the middle of ways that take `times` (m,) [s], and the first without, or -1."""
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
def seconds_at(allowed: Allowed, shares: Floats) -> float:  # pragma: no cover (compiled)
    """How long [s] a leg takes at the quickest with these shares (m + 1,) at corners."""
    full, along, across = allowed
    total = 0.0
    for k in range(len(full)):
        begin, end = shares[k], shares[k + 1]
        peak = _peak(full[k], along[k], across[k], across[k + 1], begin, end)
        total += way(full[k], along[k], across[k], across[k + 1], begin, end, peak)[0]
    return total


@njit(cache=True)
def mixed_shares(
    allowed: Allowed, quickest: Floats, times: Floats
) -> tuple[Floats, int]:  # pragma: no cover (compiled)
    """Shares (m + 1,) among `SHARES_TRIED` of the quickest with which ways take `times` (m,) [s].

    And the first way that no such share gets over, or -1.
    """
    full, along, across = allowed
    count, tries = len(full), len(SHARES_TRIED)
    came_from = np.full((count + 1, tries), -1)
    came_from[0, 0] = 0
    for k in range(count):
        for n in range(tries):
            for m in range(tries):
                if came_from[k, m] >= 0 and came_from[k + 1, n] < 0:
                    peak = _peak_for(
                        full[k], along[k], across[k], across[k + 1],
                        quickest[k] * SHARES_TRIED[m], quickest[k + 1] * SHARES_TRIED[n], times[k],
                    )  # fmt: skip
                    if peak > 0.0:
                        came_from[k + 1, n] = m
        if came_from[k + 1].max() < 0:
            return quickest, k
    shares, n = np.zeros(count + 1), int(np.argmax(came_from[count] >= 0))
    for k in range(count, 0, -1):
        shares[k] = quickest[k] * SHARES_TRIED[n]
        n = came_from[k, n]
    return shares, -1

"""Arms that carry a part upright: whether motions keep its tilt, and configurations that do.

A turn of a joint tilts what it carries by no more than itself.  So within a set of configurations
the tilt differs from that in its middle by no more than the sum of what all joints turn.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.derived.upright import tilting_axis
from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.scan import Detection
from workbench.planning.kinematics.chain import Chain, forward

NOT_HALVED_BELOW = 0.0005
"""[rad] Sets that may tilt a part by less than this are not halved: the proof allows more."""

HALVES = 64
"""Sets that wait for a check, at most: each is half as large as the one before."""

WITHIN = 0.8
"""Share of the limit to which a part that is tilted too far is turned back."""

MOST_TRIES = 12


@dataclass(frozen=True, slots=True, eq=False)
class UprightLimit:
    """An arm with a part in its hand: `axis` (3,) in the TCP's frame, tilted by `most` [rad]."""

    chain: Chain
    axis: Floats
    most: float

    def project(self, q: Floats) -> Floats | None:
        """A configuration near `q` (n,) [rad] at which the part is upright; None: none found.

        It is within the joint limits.
        """
        chain, q = self.chain, q.copy()
        n = len(q)
        R, p, z, o = np.empty((3, 3)), np.empty(3), np.empty((n, 3)), np.empty((n, 3))
        for _ in range(MOST_TRIES):
            forward(*chain.arrays[:4], q, R, p, z, o)
            x, y, up = R @ self.axis
            tilt = float(np.arctan2(np.hypot(x, y), up))
            if tilt <= self.most:
                return q
            # About a level axis, back to the vertical; joints that slide do not turn it.
            level = np.array([y, -x]) / max(float(np.hypot(x, y)), 1e-9)
            turns = z[:, :2].T * (chain.slides < 0.5)
            step = np.linalg.lstsq(turns, level * (tilt - WITHIN * self.most), rcond=1e-3)[0]
            q = np.clip(q + step, chain.lower, chain.upper)
        return None


@dataclass(frozen=True, slots=True, eq=False)
class Uprightness:
    """The limits of all arms that move at once, their joints one after the other."""

    limits: Sequence[UprightLimit | None]
    counts: Sequence[int]

    def find_tilted(self, curves: Floats) -> Floats | None:
        """A configuration (n,) at which a part is tilted too far, on curves (k, 3, n) [rad]."""
        first = 0
        for limit, count in zip(self.limits, self.counts, strict=True):
            mine = np.ascontiguousarray(curves[:, :, first : first + count])
            first += count
            if limit is None:
                continue
            k = _find_tilted(limit.chain.arrays[:4], np.array(limit.axis), limit.most, mine)
            if k >= 0:
                return np.array(curves[k, -1])
        return None

    def project(self, q: Floats) -> Floats | None:
        """A configuration near `q` (n,) [rad] at which every part is upright; None: none found."""
        first, parts = 0, list[Floats]()
        for limit, count in zip(self.limits, self.counts, strict=True):
            mine = q[first : first + count]
            first += count
            upright = mine if limit is None else limit.project(mine)
            if upright is None:
                return None
            parts.append(upright)
        return np.concatenate(parts)


def upright_limit(
    chain: Chain, part: Part, found: Detection, T_tcp_part: pin.SE3
) -> UprightLimit | None:
    """The limit of an arm that carries a part; None where the part may be turned as one likes."""
    if part.upright is None:
        return None
    axis, most = tilting_axis(part, found)
    return UprightLimit(chain, T_tcp_part.rotation @ axis, most)


@njit(cache=True)
def _find_tilted(
    arm: tuple[Floats, Floats, Floats, Floats], axis: Floats, most: float, sets: Floats
) -> int:  # pragma: no cover (compiled)
    """The first of some sets, the hulls of corners (k, m, n) [rad], that tilts too far; else -1.

    `arm` is what `forward` needs of a chain: `R`, `p`, `axes` and `slides`.
    """
    Rs, ps, axes, slides = arm
    count, corners, n = sets.shape
    R, p, z, o = np.empty((3, 3)), np.empty(3), np.empty((n, 3)), np.empty((n, 3))
    waiting, middle, hull = np.empty((HALVES, corners, n)), np.empty(n), np.empty((corners, n))
    for k in range(count):
        waiting[0] = sets[k]
        open_sets = 1
        while open_sets > 0:
            open_sets -= 1
            hull[:] = waiting[open_sets]
            turned = 0.0
            for c in range(n):
                total = 0.0
                for m in range(corners):
                    total += hull[m, c]
                middle[c] = total / corners
                far = 0.0
                for m in range(corners):
                    far = max(far, abs(hull[m, c] - middle[c]))
                if slides[c] < 0.5:
                    turned += far
            forward(Rs, ps, axes, slides, middle, R, p, z, o)
            x = R[0, 0] * axis[0] + R[0, 1] * axis[1] + R[0, 2] * axis[2]
            y = R[1, 0] * axis[0] + R[1, 1] * axis[1] + R[1, 2] * axis[2]
            up = R[2, 0] * axis[0] + R[2, 1] * axis[1] + R[2, 2] * axis[2]
            tilt = np.arctan2(np.sqrt(x * x + y * y), up)
            # What is no number is not upright.
            if not tilt <= most:
                return k
            if tilt + turned <= most or turned <= NOT_HALVED_BELOW:
                continue
            if open_sets + 2 > HALVES:
                return k
            first, second, longest = 0, 1, -1.0
            for a in range(corners):
                for b in range(a):
                    length = 0.0
                    for c in range(n):
                        length += abs(hull[a, c] - hull[b, c])
                    if length > longest:
                        longest, first, second = length, a, b
            for half in range(2):
                waiting[open_sets] = hull
                end = first if half == 0 else second
                for c in range(n):
                    waiting[open_sets, end, c] = (hull[first, c] + hull[second, c]) / 2.0
                open_sets += 1
    return -1

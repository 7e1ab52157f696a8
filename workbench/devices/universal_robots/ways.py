"""Moves that follow each other as one motion: at rest at both ends, rounded where a move blends.

Source of what a blend is: Universal Robots, "The URScript Programming Language", e-Series, `movej`:
the radius is a length [m] about the waypoint, and a move whose blend overlaps with that of the one
before or after is skipped.  What the controller does inside of the radius is not documented.  Here
it is a cubic in joint space, with the velocities that the moves have where it begins and ends.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.devices.universal_robots.urscript import Line
from workbench.model.geometry import Floats

Positions = Callable[[Floats], Floats]
"""Where the flange is (k, 3) [m] at axes (k, 6) [rad]."""

SAMPLES_A_MOVE = 200
"""Of each move, to see where it comes within a radius."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of a motion: this many seconds, and the axes (6,) [rad] at each of them."""

    seconds: float
    at: Callable[[float], Floats]


@dataclass(frozen=True, slots=True)
class Segment:
    """One move: the axes go by `step` (6,) [rad] from `start`.

    Between its blends that is the share from `begin` to `end`, at a speed of at most `speed` [1/s]
    that is changed by `push` [1/s2].  `r` [m] is the radius about its end.
    """

    start: Floats
    step: Floats
    speed: float
    push: float
    r: float = 0.0
    begin: float = 0.0
    end: float = 1.0

    @property
    def length(self) -> float:
        """The share between its blends."""
        return self.end - self.begin


class UrWay:
    """Moves from rest to rest, as the controller's twin carries them out.

    Args:
        start: where the axes are before (6,) [rad].
        lines: `movej`, of which all but the last have a blend radius.
        positions: of the flange; not asked where nothing is blended.
    """

    def __init__(self, start: Sequence[float], lines: Sequence[Line], positions: Positions) -> None:
        lines = without_overlaps(start, [*lines[:-1], replace(lines[-1], r=0.0)], positions)
        self._pieces = list(_pieces(_cut(_segments(start, lines), positions)))
        self._end = np.array(lines[-1].q)
        self.seconds: float = sum(piece.seconds for piece in self._pieces)

    def at(self, t: float) -> tuple[float, ...]:
        """The axes (6,) [rad] after `t` [s]."""
        for piece in self._pieces:
            if t < piece.seconds:
                return tuple(piece.at(max(t, 0.0)).tolist())
            t -= piece.seconds
        return tuple(self._end.tolist())


def without_overlaps(
    start: Sequence[float], lines: Sequence[Line], positions: Positions
) -> list[Line]:
    """The moves that the controller does not skip: their blends end before others begin."""
    if not any(line.r for line in lines):
        return list(lines)
    points = positions(np.array([start, *(line.q for line in lines)]))
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    r = np.array([0.0, *(line.r for line in lines)])
    skipped = {
        k
        for k in range(1, len(r) - 1)
        if r[k] and (r[k] + r[k - 1] > gaps[k - 1] or r[k] + r[k + 1] > gaps[k])
    }
    return [line for k, line in enumerate(lines, start=1) if k not in skipped]


def samples_of(start: Floats, step: Floats, positions: Positions) -> Floats:
    """Where the flange is along a move, `SAMPLES_A_MOVE` + 1 times, (k, 3) [m]."""
    shares = np.linspace(0.0, 1.0, SAMPLES_A_MOVE + 1)[:, None]
    return positions(start + shares * step)


def _segments(start: Sequence[float], lines: Sequence[Line]) -> list[Segment]:
    segments: list[Segment] = []
    q = np.array(start)
    for line in lines:
        step = np.array(line.q) - q
        if far := float(np.abs(step).max()):
            segments.append(Segment(q, step, line.v / far, line.a / far, line.r))
        q = np.array(line.q)
    return segments


def _cut(segments: list[Segment], positions: Positions) -> list[Segment]:
    """Without what their blends take."""
    cut = list(segments)
    for k in range(len(cut) - 1):
        segment, after = cut[k], cut[k + 1]
        shares = shares_within(segment, after, segment.r, positions) if segment.r else None
        # The flange may come near again after it has left: nothing is cut twice.
        if shares and segment.begin < 1.0 - shares[0]:
            cut[k] = replace(segment, end=1.0 - shares[0])
            cut[k + 1] = replace(after, begin=shares[1])
    return cut


def shares_within(
    segment: Segment, after: Segment, r: float, positions: Positions
) -> tuple[float, float] | None:
    """The shares of two moves that are within `r` [m] of the waypoint between them."""
    into = samples_of(segment.start, segment.step, positions)
    out = samples_of(after.start, after.step, positions)
    is_in = np.linalg.norm(into - into[-1], axis=1) < r
    is_out = np.linalg.norm(out - out[0], axis=1) < r
    first, last = int(is_in.argmax()), int(SAMPLES_A_MOVE - is_out[::-1].argmax())
    if not (0 < first < SAMPLES_A_MOVE and 0 < last < SAMPLES_A_MOVE):
        return None
    return 1.0 - first / SAMPLES_A_MOVE, last / SAMPLES_A_MOVE


def _pieces(segments: Sequence[Segment]) -> list[Piece]:
    """Straight ones and blends.

    Where a blend begins and ends both moves have the same share of their speed: the largest with
    which all that comes after, and came before, can be done.
    """
    count = len(segments)
    shares = [0.0] * (count + 1)
    blends = [segment.end < 1.0 for segment in segments[:-1]]
    for k in range(count - 1):
        shares[k + 1] = min(_reachable_share(segments[k], shares[k]), 1.0) if blends[k] else 0.0
    for k in reversed(range(count)):
        shares[k] = min(shares[k], _reachable_share(segments[k], shares[k + 1]))
    pieces: list[Piece] = []
    for k, segment in enumerate(segments):
        pieces.append(_straight(segment, shares[k] * segment.speed, shares[k + 1] * segment.speed))
        if k < count - 1 and blends[k]:
            pieces.append(_blend(segment, segments[k + 1], shares[k + 1]))
    return pieces


def _reachable_share(segment: Segment, share: float) -> float:
    """The share of its speed at the other end of a move, with this one at the first."""
    return math.sqrt(share**2 + 2 * segment.push * segment.length / segment.speed**2)


def _straight(segment: Segment, begins: float, ends: float) -> Piece:
    """From one speed [1/s] to another, no faster and no more suddenly than may be."""
    peak = min(segment.speed, math.sqrt(segment.push * segment.length + (begins**2 + ends**2) / 2))
    up, down = (peak - begins) / segment.push, (peak - ends) / segment.push
    ramps = (begins + peak) / 2 * up, (peak + ends) / 2 * down
    level = max(segment.length - sum(ramps), 0.0) / peak
    total = up + level + down

    def at(t: float) -> Floats:
        if t < up:
            share = begins * t + segment.push * t * t / 2
        elif t < up + level:
            share = ramps[0] + peak * (t - up)
        else:
            left = total - t
            share = segment.length - ends * left - segment.push * left * left / 2
        return segment.start + (segment.begin + share) * segment.step

    return Piece(total, at)


def _blend(segment: Segment, after: Segment, share: float) -> Piece:
    """A cubic with the velocities of both moves; it takes what both would have taken."""
    start, end = segment.start + segment.end * segment.step, after.start + after.begin * after.step
    begins, ends = share * segment.speed * segment.step, share * after.speed * after.step
    seconds = (1.0 - segment.end) / (share * segment.speed) + after.begin / (share * after.speed)
    bends = np.array([start, start + begins * seconds / 3, end - ends * seconds / 3, end])

    def at(t: float) -> Floats:
        s = t / seconds
        weights = np.array([(1 - s) ** 3, 3 * s * (1 - s) ** 2, 3 * s * s * (1 - s), s**3])
        return weights @ bends

    return Piece(seconds, at)

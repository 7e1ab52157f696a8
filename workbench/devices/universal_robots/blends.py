"""Blend radii and speeds of moves, such that what may be cut off is what was proven.

A radius is a length about a waypoint at the flange, where the program puts the TCP: the controller
may leave the linear motion where the flange comes within it, and is back on one where it has left
it.  Proven is, in joint space, what lies between a corner and the parabola from `zone` of the move
before to `zone` of the one after.  With a the share of one move and b that of the other, counted
from the corner, that is sqrt(a) + sqrt(b) <= sqrt(zone).  A triangle a + b <= w lies within it
where w <= zone / 2: sqrt(a) + sqrt(b) is at most sqrt(2 w) there.

So a radius is taken so small that every place at a share of more than zone / 2 from the corner is
outside of it; a way that stays in the triangle of where the blend begins, the corner, and where it
ends is proven then.  Speeds are such that a cubic with the velocities of both moves stays in it,
and one of fifth degree too: both sides take equally long, within `UNEVEN`.  Where such a radius
would be less than `LEAST_RADIUS`, or the arm were too suddenly turned, it stops as it does without.

That a blend stays in that triangle is our assumption, not the maker's word: the e-Series user
manual says that blends from joint moves to joint moves are the smoothest in joint space with regard
to velocities and times; they may leave the course where velocities differ much.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.devices.universal_robots.flange import Flange
from workbench.devices.universal_robots.urscript import Line
from workbench.devices.universal_robots.ways import (
    SAMPLES_A_MOVE,
    Segment,
    UrWay,
    samples_of,
    shares_within,
)
from workbench.model.geometry import Floats

LEAST_RADIUS = 0.001
"""[m] A smaller radius is none."""

LARGEST_SHARE = 0.49
"""Share of the distance between two waypoints that a radius may have: blends must not overlap."""

UNEVEN = 1.5
"""Largest ratio of the durations of the two sides of a blend.

The blend is a curve of fifth degree over T seconds, with zero acceleration at its ends.  By its
Bezier points it goes straight on for 2/5 T at the velocity of its end.  That stays before the
corner while T is at most 2.5 times the duration of that side.
"""

SHARPEST = 0.5
"""Share of the accelerations that a blend needs on average: a cubic needs more at its ends."""

SWEEPS = 4


@dataclass(frozen=True, slots=True)
class Corner:
    """A waypoint that can be blended: radius [m], and the shares of both moves within it."""

    r: float
    into: float
    out: float


def blend_lines(
    start: Sequence[float],
    lines: Sequence[Line],
    flange: Flange,
    acceleration: Floats,
    zone: float,
    most: float,
) -> tuple[Line, ...]:
    """Moves with blends, and with the speeds for them.

    Of the corners those are blended that make it quickest, counted from the mildest on.

    Args:
        start: where the axes are before (6,) [rad].
        lines: `movej` without blends, with the highest speeds and accelerations.
        flange: of the arm.
        acceleration: largest of each axis (6,) [rad/s2].
        zone: how much of the moves may be cut, by the proof.
        most: largest radius [m].
    """
    q = np.array([start, *(line.q for line in lines)])
    steps = np.diff(q, axis=0)
    corners = _corners(q, steps, flange, zone, most)
    fars = np.abs(steps).max(axis=1)
    speeds = np.array([line.v for line in lines]) / fars
    by_ease = sorted(corners, key=lambda k: -_ease(corners[k], steps, speeds, acceleration, k))
    best, least = tuple(lines), UrWay(start, lines, flange.at).seconds if not corners else math.inf
    for count in range(len(by_ease) + 1):
        chosen = {k: corners[k] for k in by_ease[:count]}
        slower = _match(chosen, steps, speeds, acceleration)
        tried = _write_lines(lines, slower * fars, chosen)
        seconds = seconds_of_all(start, tried, flange)
        if seconds < least and _keeps(chosen, steps, slower, acceleration):
            best, least = tried, seconds
    return best


def seconds_of_all(start: Sequence[float], lines: Sequence[Line], flange: Flange) -> float:
    """How long moves take: one way after the other, each up to where it stops."""
    seconds, first = 0.0, 0
    for k, line in enumerate(lines):
        if not line.r:
            seconds += UrWay(start, lines[first : k + 1], flange.at).seconds
            start, first = line.q, k + 1
    return seconds


def _corners(
    q: Floats, steps: Floats, flange: Flange, zone: float, most: float
) -> dict[int, Corner]:
    """Those that can be blended, by the number of the move before."""
    found: dict[int, Corner] = {}
    ways = [samples_of(a, step, flange.at) for a, step in zip(q[:-1], steps, strict=True)]
    # A place between two samples is no farther from the nearer one than this.
    slack = flange.lever * np.abs(steps).sum(axis=1) / (2 * SAMPLES_A_MOVE)
    outside = math.floor(SAMPLES_A_MOVE * zone / 2)
    for k in range(len(steps) - 1):
        before, after, corner = ways[k], ways[k + 1], ways[k][-1]
        into = (
            np.linalg.norm(before[: SAMPLES_A_MOVE + 1 - outside] - corner, axis=1).min() - slack[k]
        )
        out = np.linalg.norm(after[outside:] - corner, axis=1).min() - slack[k + 1]
        gaps = [float(np.linalg.norm(way[-1] - way[0])) for way in (before, after)]
        r = math.floor(min(most, into, out, *(LARGEST_SHARE * gap for gap in gaps)) * 1e4) / 1e4
        if r < LEAST_RADIUS:
            continue
        first, second = (Segment(q[n], steps[n], 1.0, 1.0) for n in (k, k + 1))
        if shares := shares_within(first, second, r, flange.at):
            found[k] = Corner(r, *shares)
    return found


def _needed_acceleration(
    corner: Corner, steps: Floats, speeds: Floats, acceleration: Floats, k: int
) -> float:
    """The acceleration of a blend on average, as a share of the largest."""
    change = np.abs(speeds[k + 1] * steps[k + 1] - speeds[k] * steps[k])
    seconds = corner.into / speeds[k] + corner.out / speeds[k + 1]
    return float((change / acceleration).max()) / seconds


def _ease(corner: Corner, steps: Floats, speeds: Floats, acceleration: Floats, k: int) -> float:
    """By how much both moves would have to be slower; 1 where not at all."""
    needed = _needed_acceleration(corner, steps, speeds, acceleration, k)
    return min(math.sqrt(SHARPEST / needed), 1.0) if needed else 1.0


def _match(
    chosen: dict[int, Corner], steps: Floats, speeds: Floats, acceleration: Floats
) -> Floats:
    """Speeds (k,) [shares/s], no higher than `speeds`, with which the chosen corners blend."""
    slower = np.array(speeds)
    for k, corner in chosen.items():
        ease = _ease(corner, steps, speeds, acceleration, k)
        slower[k : k + 2] = np.minimum(slower[k : k + 2], ease * speeds[k : k + 2])
    # Speeds that are lowered for one corner may be too low for the next one.
    for sweep in range(SWEEPS):
        for k in sorted(chosen, reverse=bool(sweep % 2)):
            into, out = chosen[k].into / slower[k], chosen[k].out / slower[k + 1]
            even = UNEVEN * (1 - 1e-6)
            if into > even * out:
                slower[k + 1] *= even * out / into
            elif out > even * into:
                slower[k] *= even * into / out
    return slower


def _keeps(chosen: dict[int, Corner], steps: Floats, speeds: Floats, acceleration: Floats) -> bool:
    """Whether all chosen corners can be blended at these speeds."""
    for k, corner in chosen.items():
        into, out = corner.into / speeds[k], corner.out / speeds[k + 1]
        if max(into, out) > UNEVEN * min(into, out):
            return False
        if _needed_acceleration(corner, steps, speeds, acceleration, k) > SHARPEST * (1 + 1e-6):
            return False
    return True


def _write_lines(
    lines: Sequence[Line], speeds: Floats, chosen: dict[int, Corner]
) -> tuple[Line, ...]:
    """The moves with these speeds of the leading axis (k,) [rad/s] and these blends."""
    radii = [chosen[k].r if k in chosen else 0.0 for k in range(len(lines))]
    return tuple(
        replace(line, v=float(v), r=r) for line, v, r in zip(lines, speeds, radii, strict=True)
    )

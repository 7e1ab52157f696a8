"""Speeds and accelerations along the whole curve: whether the times of a plan are possible.

If a controller stops at waypoints, each piece runs from rest to rest.  If it rounds corners, or is
streamed, the curve is the polyline with corners rounded by parabolas, as wide as the zone allows.
A leg holds if a motion along it, from rest to rest, passes every waypoint at the time of the plan.
No joint may exceed the cell's speed or acceleration by more than `LIMIT_TOLERANCE`.
If the cell limits jerk, no corner is a parabola, and the motion is one of `timing.jerk`.
"""

from collections.abc import Iterator

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import Guarantee, Leg, Plan, Violation, are_in_step
from workbench.proof.claims.timing.fastest import (
    ceilings,
    fastest,
    find_infeasible_segment,
    seconds,
)
from workbench.proof.claims.timing.jerk import Limits, find_segment_over_jerk_limit

LIMIT_TOLERANCE = 1.001
"""Speeds and accelerations may be this many times the cell's: sums of rounded values."""

CORNER, STRAIGHT = 8, 16
"""Pieces of each half of a corner, and of the straight between two: where they are fewer than a
planner's, what it found is missed."""


def pace_violations(cell: Cell, plan: Plan) -> Iterator[Violation]:
    """Where a plan asks for more speed or acceleration than there may be anywhere along a leg.

    Two arms in step are one motion of all their joints, as they have one clock.
    """
    for step in plan.sequence:
        both = [(cell.arm(arm), plan.arm(arm).leg(name)) for arm, name in step.runs]
        is_one = plan.guarantee is Guarantee.SYNCHRONISED and are_in_step([leg for _, leg in both])
        for some in [both] if is_one and cell.zone > 0.0 else [[arm_leg] for arm_leg in both]:
            yield from _violations(cell, some)


def _violations(cell: Cell, legs: list[tuple[Arm, Leg]]) -> Iterator[Violation]:
    """Of legs that have one clock."""
    arm, leg = legs[0]
    times = np.diff(leg.t)
    if np.any(times <= 0):
        return
    velocity = np.concatenate([cell.robot.limits(arm.joints)[2] for arm, _ in legs])
    limits = velocity * cell.policy.speed, np.concatenate([arm.acceleration for arm, _ in legs])
    steps = np.diff(np.hstack([leg.q for _, leg in legs]), axis=0)
    too_jerky = None
    if any(arm.jerk is not None for arm, _ in legs):
        jerks = [np.full(len(a.joints), np.inf) if a.jerk is None else a.jerk for a, _ in legs]
        row = _jerky_at(cell, steps, times, Limits(*limits, np.concatenate(jerks)))
        if row < 0:
            return
        too_jerky = ProofText.TOO_JERKY, row
    # Where it is too much speed or acceleration already, that is said.
    found = _of_any_jerk(cell, steps, times, limits) or too_jerky
    if found:
        text, row = found
        yield Violation(text(), arm.name, leg.name, row)


def _jerky_at(cell: Cell, steps: Floats, times: Floats, limits: Limits) -> int:
    """The first way (m, n) [rad] that no motion with these limits passes in its time; -1: none."""
    row = find_segment_over_jerk_limit(steps, times, limits, cell.zone)
    if row >= 0 and cell.controller.motion.corners == "blend":
        return find_segment_over_jerk_limit(steps, times, limits, 0.0)
    return row


def _of_any_jerk(
    cell: Cell, steps: Floats, times: Floats, limits: tuple[Floats, Floats]
) -> tuple[ProofText, int] | None:
    """What is wrong with ways (m, n) [rad] in times (m,) [s], and with which of them."""
    found = None
    if cell.zone > 0.0:
        found = _check_rounded(steps, times, *limits, cell.zone)
    if cell.zone == 0.0 or (found and cell.controller.motion.corners == "blend"):
        # A zone that cannot be done becomes a stop.
        stopped = from_rest_to_rest(steps, times, *limits)
        found = stopped and (found or stopped)
    return found


def from_rest_to_rest(
    steps: Floats, times: Floats, velocity: Floats, acceleration: Floats
) -> tuple[ProofText, int] | None:
    """What is wrong with ways (m, n) [rad] in times (m,) [s], a stop after each, and with which.

    All joints move in proportion: the way has the speed and the acceleration, in shares of it, that
    no joint forbids.
    """
    # What the whole way would take at full speed, and squared at full acceleration.
    speed = (np.abs(steps) / (velocity * LIMIT_TOLERANCE)).max(axis=1)
    push = (np.abs(steps) / (acceleration * LIMIT_TOLERANCE)).max(axis=1)
    # Up to speed and down again, or never quite up to speed.
    reaches = speed**2 > push
    least = np.where(reaches, speed + push / np.where(reaches, speed, 1.0), 2 * np.sqrt(push))
    soon = np.flatnonzero(times < least)
    if not len(soon):
        return None
    row = int(soon[0])
    return (ProofText.TOO_FAST if times[row] < speed[row] else ProofText.TOO_HARD), row


def _check_rounded(
    steps: Floats, times: Floats, velocity: Floats, acceleration: Floats, zone: float
) -> tuple[ProofText, int] | None:
    """What is wrong with ways (m, n) [rad] in times (m,) [s], corners rounded, and with which."""
    slopes, widths = marks_of(steps, zone)
    pieces = len(widths) // len(steps)
    most = ceilings(slopes, velocity * LIMIT_TOLERANCE)
    for row, planned in enumerate(times.tolist()):
        first, last = row * pieces, (row + 1) * pieces
        if planned < seconds(most[first : last + 1], widths[first:last]):
            return ProofText.TOO_FAST, row
    # Speeds of a motion within the limits, then of any that exceed them by no more than rounding.
    quick = fastest(slopes, widths, velocity, acceleration)
    row = find_infeasible_segment(
        slopes, widths, quick, most, acceleration * LIMIT_TOLERANCE, times
    )
    return None if row < 0 else (ProofText.TOO_HARD, row)


def marks_of(steps: Floats, zone: float, finer: int = 1) -> tuple[Floats, Floats]:
    """Slopes (k, n) [rad] of the rounded curve at marks, and the widths (k - 1,) between these.

    In a corner the slope goes from that of the one way to that of the other at an even rate; it is
    their mean at the waypoint.  Each piece may be cut into several `finer` pieces.
    """
    corner = np.linspace(0.0, zone, finer * CORNER + 1)
    straight = np.linspace(zone, 1.0 - zone, finer * STRAIGHT + 1) if zone < 0.5 else corner[-1:]
    at = np.concatenate([corner[:-1], straight, 1.0 - corner[-2::-1]])
    means = np.vstack([steps[:1], (steps[:-1] + steps[1:]) / 2, steps[-1:]])
    begins, ends = np.maximum(1.0 - at / zone, 0.0), np.maximum(1.0 - (1.0 - at) / zone, 0.0)
    slopes = (
        steps[:, None]
        + begins[None, :, None] * (means[:-1] - steps)[:, None]
        + ends[None, :, None] * (means[1:] - steps)[:, None]
    )
    # The last mark of a segment is the first of the next one.
    inner = slopes[:, :-1].reshape(-1, steps.shape[1])
    return np.vstack([inner, slopes[-1, -1:]]), np.tile(np.diff(at), len(steps))

"""The part of a leg that robot links share: what the hand does before it, and its times."""

from typing import Literal

import numpy as np

from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.motion import DROP_LEGS
from workbench.model.plan import Leg

HandAction = Literal["open", "grip", "keep"]


def hand_before(leg: Leg, before: Leg | None) -> HandAction:
    """What the hand of an arm does before a leg.

    Args:
        leg: the leg that follows.
        before: the arm's previous leg; None before the first one.
    """
    if leg.holding:
        # An arm that drops back a part holds it from the start.
        holds_already = leg.name in DROP_LEGS if before is None else before.holding
        return "keep" if holds_already else "grip"
    if before is None or before.holding or before.opening != leg.opening:
        return "open"
    return "keep"


def segment_seconds(cell: Cell, arm: str, leg: Leg, share: float) -> Floats:
    """Times (m,) [s] from each waypoint to the next, in whole milliseconds, at least as planned.

    Each joint stays within its allowed speed on the straight segment, too.  The plan has timed the
    rounded corner, which is shorter.

    Args:
        cell: the cell of the plan.
        arm: name of the arm that runs the leg.
        leg: the leg, m + 1 waypoints.
        share: share of the planned speed.
    """
    speeds = cell.robot.limits(cell.arm(arm).joints)[2] * cell.policy.speed
    least = (np.abs(np.diff(leg.q, axis=0)) / speeds).max(axis=1)
    seconds = np.maximum(np.diff(leg.t), least) / share
    return np.maximum(np.ceil(seconds * 1000 - 1e-6), 1) / 1000

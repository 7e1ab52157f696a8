"""What tests of the times of plans share."""

from dataclasses import replace

import numpy as np

from workbench.model.plan import Plan

LINKS = {"stop": "abb-socket", "blend": "abb-socket/2", "streamed": "abb-egm"}


def scaled(plan: Plan, share: float) -> Plan:
    """All times of a plan made longer."""
    arms = tuple(
        replace(one, legs=tuple(replace(leg, t=leg.t * share) for leg in one.legs))
        for one in plan.arms
    )
    return replace(plan, arms=arms)


def resampled(path: np.ndarray, count: int) -> np.ndarray:
    """A way (count, n) with the same ends, and as many waypoints as asked."""
    at = np.linspace(0, len(path) - 1, count)
    return np.stack([np.interp(at, np.arange(len(path)), column) for column in path.T], axis=1)

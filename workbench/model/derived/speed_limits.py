"""How fast a policy lets the TCP and points of arm, tool and part be.

`tcp_speed` is for the TCP and `point_speed` for any point.  `held_speed` is for any point while a
part is in the hand.  `manual_speed` keeps all of them at `MANUAL_SPEED`.

Nothing here is a claim of safety: what a person may be near to is decided by who builds the cell.
"""

import math

from workbench.model.cell import Policy

MANUAL_SPEED = 0.25
"""[m/s] Manual reduced speed of ISO 10218-1, here of every point and not of the TCP alone."""


def speed_limits(policy: Policy, holding: bool) -> tuple[float, float]:
    """How fast [m/s] the TCP and any point may be, with a part in the hand or without.

    Infinite where there is no limit.
    """
    manual = MANUAL_SPEED if policy.manual_speed else None
    of_points = (policy.point_speed, manual, policy.held_speed if holding else None)
    point = min((limit for limit in of_points if limit is not None), default=math.inf)
    return min(math.inf if policy.tcp_speed is None else policy.tcp_speed, point), point


def limits_speed(policy: Policy) -> bool:
    """Whether a policy limits the speed of the TCP or of points on any leg."""
    return min(speed_limits(policy, True)) < math.inf

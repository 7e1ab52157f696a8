"""How fast a policy lets the TCP and points of arm, tool and part be.

`tcp_speed` is for the TCP and `point_speed` for any point.  `held_speed` is for any point while a
part is in the hand.  `manual_speed` keeps all of them at `MANUAL_SPEED`.  `contact_energy` keeps
every point of an arm as slow as its mass asks.

Nothing here is a claim of safety: what a person may be near to is decided by who builds the cell.
"""

import math

from workbench.model.cell import Arm, Cell
from workbench.model.derived.contact_energy import energy_speed

MANUAL_SPEED = 0.25
"""[m/s] Manual reduced speed of ISO 10218-1, here of every point and not of the TCP alone."""


def speed_limits(cell: Cell, arm: Arm, holding: bool) -> tuple[float, float]:
    """How fast [m/s] the TCP and any point of an arm may be, with a part in its hand or without.

    Infinite where there is no limit.
    """
    policy = cell.policy
    manual = MANUAL_SPEED if policy.manual_speed else None
    of_points = (policy.point_speed, manual, policy.held_speed if holding else None)
    stated = (limit for limit in of_points if limit is not None)
    point = min(*stated, energy_speed(cell, arm, holding), math.inf)
    return min(math.inf if policy.tcp_speed is None else policy.tcp_speed, point), point


def limits_speed(cell: Cell) -> bool:
    """Whether a cell limits the speed of the TCP or of points on any leg."""
    return any(min(speed_limits(cell, arm, True)) < math.inf for arm in cell.arms)

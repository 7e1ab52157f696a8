"""How fast a policy lets the TCP and points of arm, tool and part be.

`tcp_speed` is for the TCP and `point_speed` for any point.  `held_speed` is for any point while a
part is in the hand, `stir_speed` while the hand stirs the parts in the bin.  `slot_speed` is that
straight into the slot of a tool and out of it.  `manual_speed` keeps
all of them at `MANUAL_SPEED`.  `contact_energy` keeps every point of an arm as slow as its mass
asks.  ISO/TS 15066:2016, annex A, has half of what moves of the arm, and all of tool and part, as
the mass that hits.  Whoever is hit counts as unable to give way, which is more than two free bodies
would exchange.

Nothing here is a claim of safety: what a person may be near to is decided by who builds the cell.
"""

import math

from workbench.model.cell import Arm, Cell
from workbench.model.motion import SLOT_LEGS, LegName

MANUAL_SPEED = 0.25
"""[m/s] Manual reduced speed of ISO 10218-1, here of every point and not of the TCP alone."""


def speed_limits(
    cell: Cell, arm: Arm, holding: bool, leg: LegName | None = None
) -> tuple[float, float]:
    """How fast [m/s] the TCP and any point of an arm may be.

    With a part in its hand or without, on a `leg`.  Infinite where there is no limit.
    """
    policy = cell.policy
    manual = MANUAL_SPEED if policy.manual_speed else None
    of_leg = policy.held_speed if holding else None
    if leg == "stir":
        of_leg = policy.stir_speed
    elif leg in SLOT_LEGS:
        of_leg = policy.slot_speed
    of_points = (policy.point_speed, manual, of_leg)
    stated = (limit for limit in of_points if limit is not None)
    point = min(*stated, energy_speed(cell, arm, holding), math.inf)
    return min(math.inf if policy.tcp_speed is None else policy.tcp_speed, point), point


def limits_speed(cell: Cell) -> bool:
    """Whether a cell limits the speed of the TCP or of points on any leg."""
    return any(min(speed_limits(cell, arm, True)) < math.inf for arm in cell.arms)


def effective_mass(cell: Cell, arm: Arm, holding: bool) -> float | None:
    """Half of the arm's moving mass, its tool, and the heaviest part while `holding` one [kg].

    None where arm or tool does not state its mass.
    """
    if arm.moving_mass is None or arm.tool.mass is None:
        return None
    held = max((part.mass for part in cell.parts), default=0.0) if holding else 0.0
    return arm.moving_mass / 2 + arm.tool.mass + held


def energy_speed(cell: Cell, arm: Arm, holding: bool) -> float:
    """The speed [m/s] at which the arm has the energy that the policy limits; infinite without."""
    mass, most = effective_mass(cell, arm, holding), cell.policy.contact_energy
    return math.inf if most is None or mass is None else math.sqrt(2.0 * most / mass)

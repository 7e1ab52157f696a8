"""Kinetic energy that a moving arm could hand to a person, as ISO/TS 15066 estimates it.

The effective mass is half of what moves of the arm, and all of tool and part: ISO/TS 15066:2016,
annex A.  Whoever is hit counts as one who cannot give way, which is more than two free bodies would
exchange.  Nothing here is a claim of safety: limits come from who assesses the cell's risks.
"""

import math

from workbench.model.cell import Arm, Cell


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

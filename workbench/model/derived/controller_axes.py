"""An arm's configuration as its controller counts it, and back: one helper for all who show it."""

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats


def to_controller(arm: Arm, q: Floats) -> Floats:
    """A configuration (n,) [rad, m], chain order, in the numbers that the controller shows."""
    axes = arm.to_axes(q)
    return axes if arm.mapping is None else arm.mapping.to_controller(axes)


def from_controller(arm: Arm, shown: Floats) -> Floats:
    """The configuration (n,) [rad, m], chain order, of numbers that the controller shows."""
    return arm.from_axes(shown if arm.mapping is None else arm.mapping.from_controller(shown))


def shown_axes(cell: Cell, arm: Arm, q: Floats) -> Floats:
    """What the controller shows (n,) [deg, mm] at a configuration (n,) [rad, m], chain order."""
    return to_controller(arm, q) / _units(cell, arm)


def from_shown(cell: Cell, arm: Arm, shown: Floats) -> Floats:
    """The configuration (n,) [rad, m], chain order, where the controller shows (n,) [deg, mm]."""
    return from_controller(arm, np.asarray(shown) * _units(cell, arm))


def shown_limits(cell: Cell, arm: Arm) -> tuple[Floats, Floats]:
    """The least and the most (n,) [deg, mm] that the controller shows within the joints' limits."""
    lower, upper, _ = cell.robot.limits(arm.joints)
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    centre = to_controller(arm, middle)
    # Each joint adds to every axis that counts it.
    each = [to_controller(arm, middle + row) - centre for row in np.diag(half)]
    reach = np.abs(each).sum(axis=0)
    units = _units(cell, arm)
    return (centre - reach) / units, (centre + reach) / units


def shown_units(cell: Cell, arm: Arm) -> tuple[str, ...]:
    """`deg` or `mm` of each of the controller's axes."""
    kinds = [cell.robot.joint(arm.joints[place]).kind for place in arm.axis_order]
    return tuple("mm" if kind == "prismatic" else "deg" for kind in kinds)


def units_said(cell: Cell, arm: Arm) -> str:
    """The units of an arm's axes, each once."""
    return ", ".join(dict.fromkeys(shown_units(cell, arm)))


def _units(cell: Cell, arm: Arm) -> Floats:
    """What one degree, or one mm, of each of the controller's axes is in rad or m."""
    return np.array([0.001 if u == "mm" else np.pi / 180 for u in shown_units(cell, arm)])

"""An arm's configuration as its controller counts it, and back."""

from workbench.model.cell import Arm
from workbench.model.geometry import Floats


def to_controller(arm: Arm, q: Floats) -> Floats:
    """A configuration (n,) [rad, m], chain order, in the numbers that the controller shows."""
    axes = arm.to_axes(q)
    return axes if arm.mapping is None else arm.mapping.to_controller(axes)


def from_controller(arm: Arm, shown: Floats) -> Floats:
    """The configuration (n,) [rad, m], chain order, of numbers that the controller shows."""
    return arm.from_axes(shown if arm.mapping is None else arm.mapping.from_controller(shown))

"""What can be sent of a configuration: degrees with two decimals."""

import numpy as np

from workbench.model.geometry import Floats

WIRE_STEP = np.deg2rad(0.01)
"""[rad] Configurations travel in degrees with two decimals."""

WHOLE = 1e-6
"""[0.01 degrees] A limit this close to a whole step is that step."""


def on_wire(q: Floats) -> Floats:
    """The nearest configurations (..., n) [rad] that can be sent: whole hundredths of a degree."""
    return np.deg2rad(np.round(np.rad2deg(q), 2))


def limits_on_wire(lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Joint limits (n,) [rad] moved inwards to what can be sent.

    Without this, a joint at its limit could be rounded to beyond it.  A joint with no room
    for two steps keeps its limits.
    """
    low = np.deg2rad(np.ceil(np.rad2deg(lower) * 100 - WHOLE) / 100)
    high = np.deg2rad(np.floor(np.rad2deg(upper) * 100 + WHOLE) / 100)
    has_range = low < high
    return np.where(has_range, low, lower), np.where(has_range, high, upper)

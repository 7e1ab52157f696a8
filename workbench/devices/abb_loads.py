"""Loads as ABB's controllers want them: RAPID's `loaddata`.

Source: Technical reference manual: RAPID instructions, functions and data types (3HAC050917): kg,
mm, a quaternion to the principal axes, and kg m2 about them.  Our tool frame is that of the wrist,
so that the load of a part is in the same frame as that of the tool.
"""

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.model.load import Load

LEAST_MASS = 0.001
"""[kg] No controller takes less, nor (0, 0, 0) for a centre of gravity."""


@dataclass(frozen=True, slots=True)
class LoadData:
    """`mass` [kg], `cog` [mm], `aom` (w, x, y, z), `moments` [kg m2], rounded as they are sent."""

    mass: float
    cog: tuple[float, ...]
    aom: tuple[float, ...]
    moments: tuple[float, ...]

    @property
    def numbers(self) -> tuple[float, ...]:
        """All eleven, in RAPID's order."""
        return (self.mass, *self.cog, *self.aom, *self.moments)


def load_data(load: Load) -> LoadData:
    """A load in the flange's frame, as a controller takes it."""
    cog = tuple((np.round(load.centre * 1000, 1) + 0.0).tolist())
    moments, axes = _principal(load.inertia)
    q = pin.Quaternion(axes)
    return LoadData(
        max(round(load.mass, 3), LEAST_MASS),
        cog if any(cog) else (0.0, 0.0, 0.1),
        tuple(round(float(value), 4) + 0.0 for value in (q.w, q.x, q.y, q.z)),
        tuple((np.round(np.maximum(moments, 0.0), 5) + 0.0).tolist()),
    )


def _principal(inertia: Floats) -> tuple[Floats, Floats]:
    """Moments (3,) [kg m2] and axes (3, 3) in columns, those that are turned the least."""
    values, axes = np.linalg.eigh(inertia)
    best = (-np.inf, values, axes)
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turned = axes[:, order] * signs
            if np.linalg.det(turned) > 0 and np.trace(turned) > best[0] + 1e-9:
                best = float(np.trace(turned)), values[list(order)], turned
    return best[1], best[2]

"""Parts that stay upright while they are carried: which axis counts, and how far it is tilted."""

import numpy as np

from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.scan import Detection


def tilt_from_vertical(axis: Floats) -> float:
    """The angle [rad] between an axis (3,) in the world and the vertical, 0 to pi."""
    return float(np.arctan2(np.hypot(axis[0], axis[1]), axis[2]))


def tilting_axis(part: Part, found: Detection) -> tuple[Floats, float]:
    """The axis (3,) of a part whose tilt counts, in its frame, and how far that may go [rad].

    It is the part's own, with its limit.  Where nobody knows how far the part is turned about
    another axis, it is that one: the part's own axis leans from it by a fixed angle to some side,
    so the limit is less by that angle.  Less than nothing means that no pose is upright for sure.
    """
    assert part.upright is not None
    if found.roll_known:
        return part.upright, part.tilt
    roll = part.symmetry.axis if found.roll_axis is None else found.roll_axis[1]
    roll = np.asarray(roll) / np.linalg.norm(roll)
    cosine = float(roll @ part.upright)
    if cosine < 0.0:
        roll, cosine = -roll, -cosine
    lean = float(np.arctan2(np.linalg.norm(np.cross(roll, part.upright)), cosine))
    return roll, part.tilt - lean


def leans_too_far(part: Part, found: Detection, R_world_part: Floats) -> float | None:
    """By how much a part is tilted [rad] in an orientation (3, 3) in which it is not upright.

    None where it is upright, or need not be.  Where nobody knows its roll, the largest tilt of all.
    """
    if part.upright is None:
        return None
    axis, most = tilting_axis(part, found)
    tilt = tilt_from_vertical(R_world_part @ axis)
    return None if tilt <= most else min(tilt + part.tilt - most, np.pi)

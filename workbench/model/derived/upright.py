"""Parts that stay upright while they are carried: which axis counts, and how far it may tilt."""

import numpy as np

from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.scan import Detection

PARALLEL_WITHIN = 1e-6
"""Directions are equal if their cosine differs from 1 by less than this."""

TURNS_TRIED = 24
"""Turns of a round part, of which one may leave it upside down."""


def tilt_from_vertical(axis: Floats) -> float:
    """The angle [rad] between an axis (3,) in the world and the vertical, 0 to pi."""
    return float(np.arctan2(np.hypot(axis[0], axis[1]), axis[2]))


def tilting_axis(part: Part, found: Detection) -> tuple[Floats, float]:
    """The axis (3,) of a part whose tilt counts, in its frame, and how far that may go [rad].

    It is the part's own, with its limit.  Of a part that looks the same upside down it is the end
    that points up where it lies.  Where nobody knows how far the part is turned about another
    axis, it is that one: the part's own axis leans from it to some side, so the limit is less by
    that angle.  A limit below 0 means that no pose is upright for sure.
    """
    assert part.upright is not None
    axis, most = np.asarray(part.upright), part.tilt
    if not found.roll_known:
        roll = np.asarray(part.symmetry.axis if found.roll_axis is None else found.roll_axis[1])
        roll = roll / np.linalg.norm(roll)
        along = float(roll @ axis)
        most -= float(np.arctan2(np.linalg.norm(np.cross(roll, axis)), abs(along)))
        axis = roll if along >= 0.0 else -roll
    if found.T_world_part.rotation[2] @ axis < 0.0 and _is_alike_upside_down(part, axis):
        axis = -axis
    return axis, most


def leans_too_far(part: Part, found: Detection, R_world_part: Floats) -> float | None:
    """How far a part is tilted [rad] in an orientation (3, 3) in which it is not upright.

    None where it is upright, or need not be.  Where nobody knows its roll, the most that it may be.
    """
    if part.upright is None:
        return None
    axis, most = tilting_axis(part, found)
    tilt = tilt_from_vertical(R_world_part @ axis)
    return None if tilt <= most else min(tilt + part.tilt - most, np.pi)


def _is_alike_upside_down(part: Part, axis: Floats) -> bool:
    """Whether some turn of a part's symmetry reverses an axis (3,)."""
    ends = part.symmetry.motions(TURNS_TRIED)[:, :3, :3] @ axis @ axis
    return bool((ends < PARALLEL_WITHIN - 1.0).any())

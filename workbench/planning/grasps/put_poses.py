"""How a part may lie at a place, as its symmetry and the place leave it, and the hand with it."""

from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.model.part import PartPlace
from workbench.model.symmetry import BALL, ROUND, SAME_TURN, Symmetry, make_turn
from workbench.planning.collision.legs import FREE_STEP, turn_steps

ROUND_STEPS = 12
"""A part that looks alike at any turn is put down at this many."""

SAME_POSE = 2e-4
"""[m, no unit] Poses whose numbers differ by less are one."""


@lru_cache(maxsize=512)
def ways_to_lie(place: PartPlace, symmetry: Symmetry) -> tuple[pin.SE3, ...]:
    """Poses `T_world_part` that are right at a place, the stated one first.

    The free rotation is covered in steps, the least of it first, and of a symmetry by any angle
    some stand for all.
    """
    z = np.array([0.0, 0.0, 1.0])
    turns = [make_turn(z, a).homogeneous for a in turn_steps(place.free_rotation, FREE_STEP)]
    motions = symmetry.motions(ROUND_STEPS)
    every = np.einsum("ij,ajk,skl->asil", place.T_world_part.homogeneous, turns, motions)
    every = every.reshape(-1, 4, 4)
    coarse = np.round(every[:, :3].reshape(len(every), -1) / SAME_POSE).astype(np.int64)
    first = np.sort(np.unique(coarse, axis=0, return_index=True)[1])
    return tuple(pin.SE3(T[:3, :3], T[:3, 3]) for T in every[first])


def suits_any_roll(place: PartPlace, symmetry: Symmetry, axis: Floats) -> bool:
    """Whether a part is right at a place however it is turned about an axis (2, 3) of its own.

    That needs a place at which it may be turned so all around, or a part to which that makes no
    difference.

    Args:
        place: for parts of that kind.
        symmetry: of the part.
        axis: a point [m] and a unit direction in the part's frame.
    """
    point, direction = axis
    if place.free_rotation >= np.pi - SAME_TURN and _is_one(
        np.zeros(3), np.eye(3)[2], point, direction
    ):
        return True
    centre = np.array(symmetry.point)
    if symmetry.form == BALL:
        return _is_one(centre, direction, point, direction)
    return symmetry.form == ROUND and _is_one(centre, symmetry.axes[0].axis, point, direction)


def _is_one(p: Floats, along: Floats, point: Floats, direction: Floats) -> bool:
    """Whether two axes are one line, whichever way they point."""
    off = point - p
    beside = float(np.linalg.norm(off - (off @ along) * along))
    return abs(float(along @ direction)) >= np.cos(SAME_TURN) and beside < SAME_POSE

"""How sure a turn is: other turns of the part that the scan shows nearly as well share its chance.

A gear turned by a tooth looks nearly alike, and so does a spring turned along its wire.  Each other
turn gets a weight that falls with the pixels by which the scan shows it less well.  The chance of
the pose is its share of them all.
"""

import math

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.sightings import EXPLAINED, closeness, tally
from workbench.perception.parts.part_surface import PartSurface

TELLING = 0.008
"""Share of the explained pixels by which a pose must be better than another to exclude it."""

FEWEST_TELLING = 8.0
"""[pixels] And by no less than this."""

SHARPNESS = 2.0
"""How fast the weight of another turn falls: by e to this power with each such margin.  So springs,
nuts, cups and screws in simulated piles, as three kinds of scanner see them, are right as often as
they say."""

NEARBY = np.deg2rad([-8.0, -6.0, -4.0, -2.0, 2.0, 4.0, 6.0, 8.0])
"""[rad] Rotations from the pose that are compared with it."""

FINE = np.deg2rad(np.linspace(-8.0, 8.0, 33))
"""[rad] Turns about the near-symmetry axis by which the outline is compared."""

OUTLINE_WORSE = 1.5
"""How many times as far off turns by the outline are as their likelihood says: pixels along an edge
err together.  Of 553 spacers and nuts in simulated piles and rings, as four kinds of scanner
see them, 523 were right to within 3 degrees."""

SAME_TURN = float(np.deg2rad(3.0))
"""[rad] A pose that is turned by less is as right as the true one."""


def margin(own: Floats) -> float:
    """By how many pixels a pose with a tally (4,) [px] must be better to exclude another."""
    return max(FEWEST_TELLING, TELLING * float(own[EXPLAINED]))


def is_better(own: Floats, others: Floats) -> bool:
    """Whether a tally (4,) is clearly better than all others (k, 4), no unit."""
    best = closeness(others).max(initial=-np.inf)
    return bool(closeness(own[None])[0] - best >= margin(own))


def weights(own: Floats, others: Floats) -> Floats:
    """How likely other poses are over the pose found (k,), no unit, at most 1.

    Args:
        own: (4,) [px] the tally of the pose found.
        others: (k, 4) [px] those of the others.
    """
    behind = closeness(own[None])[0] - closeness(others)
    return np.exp(-SHARPNESS * np.maximum(behind, 0.0) / margin(own))


def share_nearby(
    depth_map: DepthMap,
    surface: PartSurface,
    pose: Floats,
    known: Floats,
    tolerance: float,
    *,
    is_roll_free: bool,
) -> float:
    """The chance that the least known turn is right to within `SAME_TURN`, 0..1.

    The part is turned about that direction, and shifted as the fit would follow the turn.

    Args:
        depth_map: the scan.
        surface: the part.
        pose: (4, 4) [m] that was found.
        known: (6, 6) [m, rad] its covariance in the scanner's frame, see `certainty.covariance`.
        tolerance: [m] see `sightings.look`.
        is_roll_free: whether turns about the near-symmetry axis do not count.
    """
    if surface.is_ball:
        return 1.0
    counted = np.eye(3)
    if is_roll_free and surface.symmetry.axis is not None:
        axis = pose[:3, :3] @ surface.symmetry.axis[1]
        counted -= np.outer(axis, axis) / float(axis @ axis)
    _, directions = np.linalg.eigh(counted @ known[3:, 3:] @ counted)
    motion = known[:, 3:] @ directions[:, -1]
    motion = motion / float(motion[3:] @ directions[:, -1])
    tried = [np.array(pose)]
    for angle in NEARBY:
        moved = np.array(pose)
        moved[:3, :3] = pin.exp3(angle * motion[3:]) @ pose[:3, :3]
        moved[:3, 3] += angle * motion[:3]
        tried.append(moved)
    own, *others = tally(depth_map, surface, np.array(tried), tolerance)
    likely = weights(own, np.array(others))
    is_same = np.abs(NEARBY) < SAME_TURN
    return float((1.0 + likely[is_same].sum()) / (1.0 + likely.sum()))


def share_of_turns(error: float) -> float:
    """The chance, 0..1, that a turn with a standard error [rad] is right to within `SAME_TURN`."""
    return math.erf(SAME_TURN / (error * math.sqrt(2.0))) if error > 0.0 else 1.0


def with_turn_error(known: Floats, surface: PartSurface, pose: Floats, error: float) -> Floats:
    """A covariance (6, 6) [m, rad] with at least this standard error [rad] about the axis.

    Args:
        known: see `certainty.covariance`.
        surface: one that has a near-symmetry axis, where `error` is not 0.
        pose: (4, 4) [m] that was found.
        error: of its turn about that.
    """
    if error <= 0.0:
        return known
    assert surface.symmetry.axis is not None
    point, axis = surface.symmetry.axis
    turn = pose[:3, :3] @ axis
    motion = np.concatenate([np.cross(turn, -pose[:3, :3] @ point), turn])
    lacks = error**2 - float(turn @ known[3:, 3:] @ turn)
    return known + max(lacks, 0.0) * np.outer(motion, motion)


def turn_by_outline(
    depth_map: DepthMap, surface: PartSurface, pose: Floats, tolerance: float
) -> tuple[Floats, float]:
    """A pose (4, 4) [m] turned about its near-symmetry axis to where the outline has it.

    The faces of a nut that lies flat look alike at every turn, its six corners do not.

    Args:
        depth_map: the scan.
        surface: one that has such an axis.
        pose: (4, 4) [m] that was found.
        tolerance: [m] see `sightings.look`.

    Returns:
        The pose, at the mean of what is likely, and the standard error [rad] of its turn; that is
        infinite where a turn at the end of `FINE` is the likeliest.
    """
    assert surface.symmetry.axis is not None
    point, axis = surface.symmetry.axis
    turns = np.tile(np.eye(4), (len(FINE), 1, 1))
    turns[:, :3, :3] = [pin.exp3(angle * axis) for angle in FINE]
    turns[:, :3, 3] = point - turns[:, :3, :3] @ point
    tallies = tally(depth_map, surface, pose @ turns, tolerance)
    best = int(closeness(tallies).argmax())
    if best in (0, len(FINE) - 1):
        return pose, np.inf
    likely = weights(tallies[best], tallies)
    likely /= likely.sum()
    turn = float(likely @ FINE)
    deviation = OUTLINE_WORSE * float(np.sqrt(likely @ (FINE - turn) ** 2))
    R = pin.exp3(turn * axis)
    return pose @ pin.SE3(R, point - R @ point).homogeneous, deviation

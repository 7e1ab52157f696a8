"""How far a plan may be off what it states, in metres of whichever point moves farthest.

An angle says nothing of safety: one degree moves the corner of a 300 mm plate by 2.6 mm.  So poses
are compared by the displacement of points, never by a shift and an angle.  `docs/proof.md` lists
every tolerance with its displacement, and a test compares that table with this file.
"""

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.model.part import Part

STATED = 0.00005
"""[m] Any point of a part: where the plan states it in the hand, and where the hand takes it."""

GRASPED = 0.001
"""[m] Any point of a part: how the hand takes it, and how the grasp was authored."""

PLACED = 0.001
"""[m] Any point of a part: where the hand lets go of it, and a place that the cell states for the
hand."""

INSERTED = 0.0005
"""[m] Any point of a part: on its way onto another one, and on the straight line to its seat there;
at the end of the way, and at the seat."""

AT_SLOT = 0.001
"""[m] Any point of a tool, or of one in its place: where the arm couples or uncouples it, and where
it stands in its slot."""

OPENING = 1e-6
"""[m] The opening of fingers, and that of the grasp."""

OFF_LINE, OFF_ARC = 0.002, 0.005
"""[m] The TCP beside a straight line: at waypoints, and between them, where joints that move in
proportion lead the hand in an arc."""

HAND_TURN, HAND_TURN_REACH = np.deg2rad(1.5), 0.005
"""[rad, m] The hand on a straight line may turn by the angle; by less where that would move a
point of the part farther than the distance."""

OFF_AXIS = 0.001
"""[m] Any point of a part: turned about the axis that was found, and about that of a symmetry or a
place."""

TILTED = np.deg2rad(0.1)
"""[rad] A part that stays upright, and the tilt that it may have."""

BETWEEN_TURNS = 0.001
"""[m] Any point of a part of unknown roll, from the nearest turn at which it is checked."""

FEWEST_TURNS = 24
"""Turns at which a part of unknown roll is checked, however near to its axis all of it lies."""


def displacement(points: Floats, T: pin.SE3, other: pin.SE3) -> float:
    """How far [m] two poses of a body put any of its points (n, 3) [m] apart."""
    R, p = T.rotation - other.rotation, T.translation - other.translation
    return float(np.sqrt((np.square(points @ R.T + p)).sum(axis=1).max()))


def farthest(points: Floats, origin: Floats) -> float:
    """The distance [m] of a point (3,) to whichever of others (n, 3) [m] is farthest from it."""
    return float(np.sqrt(np.square(points - origin).sum(axis=1).max()))


def largest_turn(reach: float) -> float:
    """[rad] Largest rotation of a hand on a straight line, for a part of this reach [m]."""
    return float(min(HAND_TURN, HAND_TURN_REACH / max(reach, 1e-9)))


def turns_for(radius: float) -> int:
    """Number of rolls at which a body of unknown roll and this radius [m] is checked."""
    return max(int(np.ceil(np.pi * radius / BETWEEN_TURNS)), FEWEST_TURNS)


def is_on_axis(part: Part, axis: Floats, line: Floats) -> bool:
    """Whether a turn about one axis (2, 3) of a part is, within `OFF_AXIS`, one about another.

    An axis is a point [m] and a unit direction.  A turn by half a circle doubles the distance.
    """
    (point, along), (through, way) = axis, line
    lean = float(np.linalg.norm(np.cross(way, along)))
    aside = float(np.linalg.norm(np.cross(point - through, way)))
    return 2 * (aside + lean * farthest(np.asarray(part.mesh.points), point)) <= OFF_AXIS

"""Axes about which a part is round, or some stretch of it: grips on it may be turned about them."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.symmetry import ANY_TURN, make_turn
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.grasp_suggestions import opposite_points

PAIRS = 600
"""Points of the surface from which axes are searched for."""

AXIS_WITHIN = 0.0007
"""[m] Middles of pairs no farther from an axis belong to it."""

LEAST_SHARE = 0.12
"""Share of the pairs that a round body has to have."""

SPREAD = 5
"""Of twelve directions across an axis this many have to be among its pairs."""


@dataclass(frozen=True, slots=True, eq=False)
class RoundBody:
    """An axis (3,) through a point (3,) [m]; after `period` [rad] turns repeat by symmetry."""

    axis: Floats
    point: Floats
    period: float

    def turn_by(self, angle: float) -> pin.SE3:
        """The motion by an angle [rad] about it."""
        return make_turn(self.axis, angle, self.point)


def round_bodies(part: Part, checker: GraspChecker) -> tuple[RoundBody, ...]:
    """The axes of a part, that of its symmetry first."""
    found: list[RoundBody] = []
    for symmetry_axis in part.symmetry.axes[:1]:
        period = ANY_TURN if symmetry_axis.fold == 0 else 2 * np.pi / symmetry_axis.fold
        found.append(
            RoundBody(np.array(symmetry_axis.axis), np.array(part.symmetry.point), float(period))
        )
    if checker.pads is None:
        return tuple(found)
    rng = np.random.default_rng(0)
    points, inward, widths, _ = opposite_points(checker, PAIRS, rng)
    middles = points + widths[:, None] / 2 * inward
    for axis in np.eye(3):
        if any(abs(float(axis @ round_body.axis)) > 0.99 for round_body in found):
            continue
        across = np.abs(inward @ axis) < 0.05
        if across.sum() < max(1.0, LEAST_SHARE * len(inward)):
            continue
        flat = middles[across] - (middles[across] @ axis)[:, None] * axis
        near = np.linalg.norm(flat[:, None] - flat[None], axis=2) < AXIS_WITHIN
        best = int(near.sum(axis=1).argmax())
        mine = near[best]
        directions = _directions(inward[across][mine], axis)
        if mine.sum() >= LEAST_SHARE * len(inward) and directions >= SPREAD:
            found.append(RoundBody(axis, flat[mine].mean(axis=0), 2 * np.pi))
    return tuple(found)


def _directions(inward: Floats, axis: Floats) -> int:
    """How many of twelve directions over half a turn there are among unit vectors (n, 3)."""
    x = np.roll(axis, 1)
    angle = np.arctan2(inward @ np.cross(axis, x), inward @ x) % np.pi
    return len(np.unique((angle / np.pi * 12).astype(int) % 12))

"""How far apart two poses of a part are, when poses that look alike count as one."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.symmetry import BALL, NONE, SAME_TURN, Symmetry, SymmetryAxis

FINE_STEPS = 315
"""Turns that stand for any angle, as many as in `bop_toolkit`: arcs of 1 % of a diameter."""


def pose_error(
    part: Part,
    T_world_true: pin.SE3,
    T_world_found: pin.SE3,
    *,
    roll_known: bool = True,
    roll_axis: Floats | None = None,
) -> tuple[float, float]:
    """Distance of the middle [m] and turn [rad] between two poses, under the stated symmetry.

    Of all turns that leave the part as it is, that counts after which the turn is the smallest.
    (Hodan et al., On Evaluation of 6D Object Pose Estimation, 2016).

    Args:
        part: whose poses; its symmetry says which of them are one.
        T_world_true: one pose.
        T_world_found: the other one.
        roll_known: False leaves the angle about an axis out.
        roll_axis: (2, 3) that axis, a point [m] and a unit direction, as `Detection` has it; None:
            that of the symmetry.
    """
    T = T_world_true.actInv(T_world_found)
    symmetry = part.symmetry if roll_known else without_roll(part.symmetry, roll_axis)
    middle = symmetry.invariant_point(
        (part.mesh.points.min(axis=0) + part.mesh.points.max(axis=0)) / 2
    )
    if symmetry.form == BALL:
        return float(np.linalg.norm(T.act(middle) - middle)), 0.0
    if symmetry.form == NONE:
        motions = symmetry.motions(1)
        turns = [float(np.linalg.norm(pin.log3(T.rotation @ M[:3, :3].T))) for M in motions]
        best = motions[int(np.argmin(turns))]
        moved = best[:3, :3] @ middle + best[:3, 3]
        return float(np.linalg.norm(T.act(middle) - moved)), min(turns)
    # All points of the axis are where they were after any turn about it, and after a flip the
    # fixed one is.  The angle by sine and cosine: near zero an arc cosine sees nothing below 1e-8.
    axis = symmetry.axes[0].axis
    turned = T.rotation @ axis
    tilts = [
        float(np.arctan2(np.linalg.norm(np.cross(R @ axis, turned)), (R @ axis) @ turned))
        for R in symmetry.others
    ]
    return float(np.linalg.norm(T.act(middle) - middle)), min(tilts)


def without_roll(symmetry: Symmetry, roll_axis: Floats | None) -> Symmetry:
    """A symmetry joined by any turn about an axis (2, 3), a point [m] and a unit direction."""
    if symmetry.form != NONE:
        return symmetry
    if roll_axis is None:
        return replace(symmetry, fold=0)
    point, along = roll_axis
    flips = [
        axis.axis
        for axis in symmetry.axes
        if axis.fold % 2 == 0 and abs(float(axis.axis @ along)) < np.sin(SAME_TURN)
    ]
    if not flips:
        return Symmetry(along, 0, tuple(point))
    return Symmetry(along, 0, symmetry.point, (SymmetryAxis(flips[0], 2),))


def mahalanobis_squared(
    part: Part,
    T_world_true: pin.SE3,
    T_world_found: pin.SE3,
    covariance: Floats,
    *,
    roll_known: bool = True,
    roll_axis: Floats | None = None,
) -> tuple[float, int]:
    """The squared Mahalanobis distance of a pose from the truth; no unit.

    The covariance (6, 6) [m, rad] is that of `Detection`.

    Of all motions that leave the part as it is, that counts after which it is the smallest.  The
    other arguments are those of `pose_error`.

    Returns:
        The squared error, and its degrees of freedom: where any turn about an axis changes nothing
        there is one unknown less, of a ball there are three.
    """
    symmetry = part.symmetry if roll_known else without_roll(part.symmetry, roll_axis)
    if symmetry.form == BALL:
        point = np.array(symmetry.point)
        arm = T_world_found.rotation @ point
        moves = np.hstack([np.eye(3), np.cross(arm, np.eye(3))])
        error = T_world_found.act(point) - T_world_true.act(point)
        return float(error @ np.linalg.solve(moves @ covariance @ moves.T, error)), 3
    squares: list[float] = []
    for M in symmetry.motions(FINE_STEPS):
        T = T_world_true * pin.SE3(M)
        turn = pin.log3(T_world_found.rotation @ T.rotation.T)
        error = np.concatenate([T_world_found.translation - T.translation, turn])
        squares.append(float(error @ np.linalg.solve(covariance, error)))
    return min(squares), 6 if symmetry.form == NONE else 5


def mssd(part: Part, T_world_true: pin.SE3, T_world_found: pin.SE3) -> float:
    """Maximum symmetry-aware surface distance [m] (Hodan et al., BOP Challenge 2020).

    Args:
        part: whose poses.
        T_world_true: one pose.
        T_world_found: the other one.
    """
    points = part.mesh.points
    if part.symmetry.form == BALL:
        middle = np.array(part.symmetry.point)
        return float(np.linalg.norm(T_world_true.act(middle) - T_world_found.act(middle)))
    T = T_world_true.actInv(T_world_found).homogeneous
    found = points @ T[:3, :3].T + T[:3, 3]
    motions = part.symmetry.motions(FINE_STEPS)
    squares = [
        np.square(points @ M[:3, :3].T + M[:3, 3] - found).sum(axis=1).max() for M in motions
    ]
    return float(np.sqrt(min(squares)))

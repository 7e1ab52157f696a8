"""How fast points of an arm, its tool and a held part are, as shares of what a cell allows.

A leg is a curve whose parameter grows by 1 from waypoint to waypoint.  What is computed here is one
more slope like those of the joints, whose speed is at most 1: planning and streaming keep it like
the speed of a joint.  The proof has another computation of its own.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_tcp import by_taking
from workbench.model.derived.carried_points import (
    InHand,
    Points,
    find_flange,
    joined,
    link_points,
    moved,
    part_points,
    tool_points,
)
from workbench.model.derived.speed_limits import speed_limits
from workbench.model.geometry import Floats
from workbench.model.plan import ArmPlan, Leg, LegName, Plan

KEPT_SHARE = 0.98
"""Of a limit of the policy: between the marks of a curve points may be a little faster."""

WAY_MARKS = 33
"""On a straight segment between two waypoints."""


@dataclass(frozen=True, slots=True, eq=False)
class PointSpeeds:
    """What one arm moves on one leg, and how fast that may be [m/s].

    `bodies` are points by the count of the arm's joints that carry them, `tcp` (3,) [m] lies in the
    frame of the last one.
    """

    cell: Cell
    arm: Arm
    bodies: tuple[tuple[int, Points], ...]
    tcp: Floats
    tcp_limit: float
    point_limit: float

    def shares(self, q: Floats, slopes: Floats) -> Floats:
        """The fastest point's share (k,) of its limit, where the parameter grows by 1 a second.

        Args:
            q: configurations (k, n) [rad, m].
            slopes: how the joints change with the parameter (k, n) [rad, m].
        """
        fastest = v = w = np.zeros((len(q), 3))
        fastest = fastest[:, 0]
        points = dict(self.bodies)
        for count, (v, w) in enumerate(_twists(self.cell, self.arm, q, slopes)):
            if count in points:
                fastest = np.maximum(fastest, _fastest(v, w, *points[count]) / self.point_limit)
        tcp = _fastest(v, w, self.tcp[None], np.zeros(1)) / self.tcp_limit
        return np.maximum(fastest, tcp) / KEPT_SHARE

    def share_along(self, start: Floats, end: Floats) -> float:
        """The largest share on the straight segment between configurations (n,) [rad, m]."""
        steps = np.tile(end - start, (WAY_MARKS, 1))
        at = np.linspace(0.0, 1.0, WAY_MARKS)[:, None]
        return float(self.shares(start + at * steps, steps).max())


def speeds_on(
    cell: Cell,
    arm: Arm,
    holding: bool,
    opening: float,
    hand: InHand | None,
    leg: LegName | None = None,
) -> PointSpeeds | None:
    """What an arm moves on a leg, with its fingers at an `opening` [m]; None without limits.

    `hand` is what it carries where it is `holding` something.
    """
    tcp_limit, point_limit = speed_limits(cell, arm, holding, leg)
    if min(tcp_limit, point_limit) == np.inf:
        return None
    links = link_points(cell, arm.name)
    last = len(arm.joints)
    flange = [*tool_points(arm, opening)]
    if holding and hand is not None:
        T_flange_part = arm.tool.T_flange_tcp * hand.T_tcp_part
        flange += [moved(T_flange_part, points) for points in part_points(hand)]
    T_joint_flange = find_flange(cell, arm)
    there = [moved(T_joint_flange, points) for points in flange]
    bodies = {**links, last: joined([*([links[last]] if last in links else []), *there])}
    tcp = (T_joint_flange * arm.tool.T_flange_tcp).translation
    return PointSpeeds(cell, arm, tuple(bodies.items()), tcp, tcp_limit, point_limit)


def speeds_of(cell: Cell, plan: Plan, arm_plan: ArmPlan, leg: Leg) -> PointSpeeds | None:
    """What an arm of a plan moves on one of its legs; None in a cell without such limits."""
    hand, cell = None, by_taking(cell, arm_plan)
    if arm_plan.takes_part:
        found = plan.detections[arm_plan.detection]
        hand = InHand(cell.part(found.part), found, arm_plan.T_tcp_part)
    arm = cell.arm(arm_plan.arm)
    return speeds_on(cell, arm, leg.holding, leg.opening, hand, leg.name)


def _twists(cell: Cell, arm: Arm, q: Floats, slopes: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Velocities (k, 3) [m] and rates (k, 3) [rad] of what each count of joints carries, in it.

    The first is of what no joint of the arm carries, the last of what all do.
    """
    count = len(q)
    v, w = np.zeros((count, 3)), np.zeros((count, 3))
    yield v, w
    column, T = 0, cell.T_world_robot
    for joint in cell.robot.chain(arm.flange):
        T = T * joint.T_parent_joint
        if joint.kind == "fixed":
            continue
        # What is seen from the frame before, seen from this one.
        v = _times(T.rotation.T, v + _cross(w, T.translation))
        w = _times(T.rotation.T, w)
        axis = np.asarray(joint.axis)
        if joint.kind == "prismatic":
            v = v + _cross(w, q[:, column, None] * axis) + slopes[:, column, None] * axis
        else:
            v, w = (_turned(x, axis, -q[:, column]) for x in (v, w))
            w = w + slopes[:, column, None] * axis
        column, T = column + 1, pin.SE3.Identity()
        yield v, w


def _times(R: Floats, x: Floats) -> Floats:
    """R x for each of `x` (k, 3)."""
    return x[:, :1] * R[:, 0] + x[:, 1:2] * R[:, 1] + x[:, 2:] * R[:, 2]


def _cross(a: Floats, b: Floats) -> Floats:
    """The cross product of vectors (k, 3) with one (3,) or as many."""
    x, y, z = (b[..., i] for i in range(3))
    return np.stack(
        [a[:, 1] * z - a[:, 2] * y, a[:, 2] * x - a[:, 0] * z, a[:, 0] * y - a[:, 1] * x], axis=1
    )


def _turned(x: Floats, axis: Floats, angles: Floats) -> Floats:
    """Vectors (k, 3) turned about an axis (3,) by angles (k,) [rad] (Rodrigues)."""
    sin, cos = np.sin(angles)[:, None], np.cos(angles)[:, None]
    along = (x * axis).sum(axis=1, keepdims=True)
    return x * cos - _cross(x, axis) * sin + axis * along * (1.0 - cos)


def _fastest(v: Floats, w: Floats, points: Floats, radii: Floats) -> Floats:
    """The largest speed (k,) of points of bodies that move by `v` and `w` (k, 3)."""
    # |v + w x p|2 = |v|2 + 2 (v x w) p + |w|2 |p|2 - (w p)2, in the frame of the body.
    turning = np.sqrt((w * w).sum(axis=1))
    u, x = _cross(v, w), points.T
    far = (points * points).sum(axis=1)
    along = w[:, :1] * x[0] + w[:, 1:2] * x[1] + w[:, 2:] * x[2]
    pulled = u[:, :1] * x[0] + u[:, 1:2] * x[1] + u[:, 2:] * x[2]
    square = (v * v).sum(axis=1)[:, None] + 2.0 * pulled + turning[:, None] ** 2 * far - along**2
    return (np.sqrt(np.maximum(square, 0.0)) + turning[:, None] * radii).max(axis=1)

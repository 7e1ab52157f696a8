"""Points whose hull holds what an arm carries: its links, its tool, and the part in its hand."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Box, Capsule, Cylinder, Floats, Shape, Solid, Sphere, transform
from workbench.model.part import Part
from workbench.model.scan import Detection

RING = 12
"""Points of a ring that stands for a part at every turn; its radius holds the circle."""

CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))

Points = tuple[Floats, Floats]
"""Points (m, 3) [m] in the frame of what carries them, and radii (m,) [m] of balls around them."""


@dataclass(frozen=True, slots=True, eq=False)
class InHand:
    """A part as a hand holds it: `T_tcp_part`, and the detection, which may not know its roll."""

    part: Part
    found: Detection
    T_tcp_part: pin.SE3


@lru_cache(maxsize=16)
def link_points(cell: Cell, name: str) -> dict[int, Points]:
    """What joints of an arm carry without its tool: count of joints -> points in the last one."""
    arm = cell.arm(name)
    carriers = {arm.joints[k]: k + 1 for k in range(len(arm.joints))}
    at: dict[str, tuple[int, pin.SE3]] = {}
    found: dict[int, list[Points]] = {}
    for joint in cell.robot.joints:
        count, T = at.get(joint.parent, (0, pin.SE3.Identity()))
        if joint.name in carriers:
            at[joint.child] = carriers[joint.name], pin.SE3.Identity()
        elif count:
            at[joint.child] = count, T * joint.T_parent_joint
    for link in cell.robot.links:
        if link.name in at:
            count, T = at[link.name]
            found.setdefault(count, []).extend(_points(T, link.collision))
    if housing := cell.scanner.housing_of(name):
        found.setdefault(len(arm.joints), []).extend(_points(find_flange(cell, arm), housing))
    return {count: joined(some) for count, some in found.items() if some}


def find_flange(cell: Cell, arm: Arm) -> pin.SE3:
    """Where the flange is in the frame of the arm's last joint."""
    T = pin.SE3.Identity()
    for joint in cell.robot.chain(arm.flange):
        T = T * joint.T_parent_joint if joint.kind == "fixed" else pin.SE3.Identity()
    return T


def tool_points(arm: Arm, opening: float) -> Iterator[Points]:
    """What the tool has, in the frame of the flange."""
    yield from _points(pin.SE3.Identity(), arm.tool.body)
    for finger in arm.tool.fingers:
        slid = pin.SE3(np.eye(3), np.asarray(finger.direction) * (opening / 2))
        yield from _points(slid, (finger.solid,))


def part_points(hand: InHand) -> Iterator[Points]:
    """A part in its own frame; where its roll is not known, rings about its axis."""
    some = [*_points(pin.SE3.Identity(), hand.part.pieces)]
    if hand.found.roll_known:
        yield from some
        return
    axis = hand.found.roll_axis
    symmetry = hand.part.symmetry
    at, along = (symmetry.point, symmetry.axis) if axis is None else axis
    points, radii = joined(some)
    high = (points - at) @ along
    wide = float((np.linalg.norm(points - at - np.outer(high, along), axis=1) + radii).max())
    side = np.linalg.svd(np.asarray(along)[None])[2][1:]
    angles = np.arange(RING) * (2 * np.pi / RING)
    ring = np.column_stack([np.cos(angles), np.sin(angles)]) @ side * wide / np.cos(np.pi / RING)
    for end in (float((high - radii).min()), float((high + radii).max())):
        yield at + end * np.asarray(along) + ring, np.zeros(RING)


def _points(T: pin.SE3, solids: Sequence[Solid]) -> Iterator[Points]:
    """Points of solids, whose frame is at `T`."""
    for solid in solids:
        yield moved(T * solid.T_owner_shape, _of_shape(solid.shape))


@lru_cache(maxsize=4096)
def _of_shape(shape: Shape) -> Points:
    """Points with balls around them whose hull holds a shape."""
    match shape:
        case Box(size=size):
            return CORNERS * size, np.zeros(8)
        case Sphere(radius=radius):
            return np.zeros((1, 3)), np.array([radius])
        case Cylinder(radius=radius, length=length) | Capsule(radius=radius, length=length):
            ends = np.array([[0.0, 0.0, -length / 2], [0.0, 0.0, length / 2]])
            return ends, np.full(2, radius)
        case _:
            points = np.unique(shape.points, axis=0)
            if not shape.is_convex:
                low, high = points.min(axis=0), points.max(axis=0)
                points = (low + high) / 2 + CORNERS * (high - low)
            return points, np.zeros(len(points))


def moved(T: pin.SE3, points: Points) -> Points:
    """Points (m, 3) [m] of a frame that is at `T`."""
    return transform(T, points[0]), points[1]


def joined(some: Sequence[Points]) -> Points:
    """All of several points (m, 3) [m]."""
    return np.concatenate([p for p, _ in some]), np.concatenate([r for _, r in some])

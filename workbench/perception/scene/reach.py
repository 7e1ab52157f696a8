"""How far from its foot a robot gets with anything: a bound, not the workspace."""

from collections.abc import Iterable

import numpy as np

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.geometry import Box, Capsule, Cylinder, Shape, Solid, Sphere


def reach(cell: Cell) -> float:
    """Radius [m] of a ball around the robot's base that it leaves with nothing, a part included.

    Lengths along the chains are added as if every arm could be stretched straight, whatever the
    limits of its joints.  So the true workspace is smaller.
    """
    from_base = {cell.robot.root: 0.0}
    for joint in cell.robot.joints:
        slides = max(abs(joint.lower), abs(joint.upper)) if joint.kind == "prismatic" else 0.0
        step = float(np.linalg.norm(joint.T_parent_joint.translation)) + slides
        from_base[joint.child] = from_base[joint.parent] + step
    links = [from_base[link.name] + _extent(link.collision) for link in cell.robot.links]
    size = max((float(np.ptp(part.mesh.points, axis=0).max()) for part in cell.parts), default=0.0)
    carried = 2 * np.sqrt(3.0) * size
    hands = [
        from_base[arm.flange] + _hand(tool) + carried for arm in cell.arms for tool in _tools(arm)
    ]
    housings = [
        from_base[arm.flange] + _extent(cell.scanner.housing_of(arm.name)) for arm in cell.arms
    ]
    return max((*links, *hands, *housings))


def _tools(arm: Arm) -> tuple[Tool, ...]:
    return (arm.tool, *arm.tools)


def _hand(tool: Tool) -> float:
    """How far a tool gets from its flange [m]."""
    tip = float(np.linalg.norm(tool.T_flange_tcp.translation))
    fingers = _extent(finger.solid for finger in tool.fingers) + tool.stroke[1]
    return max(tip, _extent(tool.body), fingers)


def _extent(solids: Iterable[Solid]) -> float:
    """How far solids get from their owner's frame [m]."""
    return max(
        (
            float(np.linalg.norm(solid.T_owner_shape.translation)) + _radius(solid.shape)
            for solid in solids
        ),
        default=0.0,
    )


def _radius(shape: Shape) -> float:
    """Of a ball around the shape's frame that holds it [m]."""
    match shape:
        case Box(size=size):
            return float(np.linalg.norm(size)) / 2
        case Cylinder(radius=radius, length=length):
            return float(np.hypot(radius, length / 2))
        case Capsule(radius=radius, length=length):
            return radius + length / 2
        case Sphere(radius=radius):
            return radius
        case _:
            return float(np.linalg.norm(shape.points, axis=1).max())

"""How far from its foot a robot gets with anything: a bound, not the workspace."""

from collections.abc import Iterable

import numpy as np

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.geometry import Solid


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
    return max(tool.reach, float(np.linalg.norm(tool.T_flange_tcp.translation)))


def _extent(solids: Iterable[Solid]) -> float:
    """How far solids get from their owner's frame [m]."""
    return max((solid.reach for solid in solids), default=0.0)

"""What of a robot never moves, so that tables can stand clear of it."""

import numpy as np

from workbench.formats.meshes.triangles import surface_of
from workbench.model.cell import Cell
from workbench.model.geometry import Floats, transform
from workbench.planning.kinematics.chain import chain_of

BAND = (-0.1, 0.2)
"""[m] Below and above the floor of a bin: what stands there is in the way of bin and table."""


def front_of(cell: Cell, direction: float, height: float) -> float:
    """How far what never moves reaches in a direction [rad], from the middle of the arms' feet [m].

    Only what is about at a height [m] counts; minus infinity where nothing is.
    """
    points = _standing(cell)
    out = np.array([np.cos(direction), np.sin(direction), 0.0])
    feet = np.mean([chain_of(cell, arm).p[0] for arm in cell.arms], axis=0)
    there = points[(points[:, 2] > height + BAND[0]) & (points[:, 2] < height + BAND[1])]
    return float(((there - feet) @ out).max()) if len(there) else -np.inf


def _standing(cell: Cell) -> Floats:
    """Corners of all links that no joint moves, in the world (n, 3) [m]."""
    poses = {cell.robot.root: cell.T_world_robot}
    for joint in cell.robot.joints:
        if joint.kind == "fixed" and joint.parent in poses:
            poses[joint.child] = poses[joint.parent] * joint.T_parent_joint
    found = [
        transform(poses[link.name], np.asarray(surface_of(link.collision).vertices))
        for link in cell.robot.links
        if link.name in poses and link.collision
    ]
    return np.vstack([np.empty((0, 3)), *found])

"""How far scanned points lie from the robot as its model expects it."""

from collections.abc import Mapping

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.perception.simulation.held_plate import robot_scene


def distances_to_robot(cell: Cell, Ts_world_link: Mapping[str, pin.SE3], points: Floats) -> Floats:
    """The distance (n,) [m] of points (n, 3) [m] in the world from the surface of robot and tools.

    Args:
        cell: whose robot.
        Ts_world_link: where every link is.
        points: what was scanned.
    """
    scene = robot_scene(cell, Ts_world_link)
    queries = np.ascontiguousarray(points, dtype=np.float32)
    return scene.compute_distance(o3d.core.Tensor(queries), nthreads=1).numpy().astype(np.float64)

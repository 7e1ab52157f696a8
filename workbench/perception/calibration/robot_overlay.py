"""How far scanned points lie from the robot, or the whole cell, as the model expects it."""

from collections.abc import Mapping

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.perception.simulation.ball_plate import cell_scene, robot_scene


def distances_to_cell(cell: Cell, Ts_world_link: Mapping[str, pin.SE3], points: Floats) -> Floats:
    """The distance (n,) [m] of points (n, 3) [m] in the world from the surface of robot and tools.

    A scanner on an arm sees little of them: there bin and fixtures count, too.

    Args:
        cell: whose robot.
        Ts_world_link: where every link is.
        points: what was scanned.
    """
    scene_of = robot_scene if cell.scanner.on_arm is None else cell_scene
    scene = scene_of(cell, Ts_world_link)
    queries = np.ascontiguousarray(points, dtype=np.float32)
    return scene.compute_distance(o3d.core.Tensor(queries), nthreads=1).numpy().astype(np.float64)

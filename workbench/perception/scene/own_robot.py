"""The robot in a scan: which points are of it, by where its joints say that it stands."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Bools, Solid
from workbench.model.messages.calibration import ScanText
from workbench.model.scan import Scan
from workbench.perception.views.surfaces import add_surface, triangles_of

AROUND_ROBOT = 0.01
"""[m] Around what is modelled of the robot: cables, and what calibration and scanner are off."""


def without_robot(scan: Scan, cell: Cell) -> Scan:
    """The scan without points on the robot or within `AROUND_ROBOT` of it.

    Fingers count at both ends of their stroke: nobody reports how far they are open.

    Args:
        scan: with the joints at which it was taken; as it is where it has none.
        cell: whose robot it is.

    Raises:
        InputError: nothing is left.
    """
    if scan.joints is None:
        return scan
    keeps = ~_on_robot(scan, cell)
    if keeps.all():
        return scan
    if not keeps.any():
        raise InputError(ScanText.ONLY_ROBOT())
    return replace(
        scan,
        points=scan.points[keeps],
        pixels=None if scan.pixels is None else scan.pixels[keeps],
        colours=None if scan.colours is None else scan.colours[keeps],
    )


def _on_robot(scan: Scan, cell: Cell) -> Bools:
    points = scan.points_world
    lowest, highest = points.min(axis=0), points.max(axis=0)
    is_robot = np.zeros(len(points), bool)
    for solid, T_world_owner in robot_solids(cell, scan.joints or {}):
        surface, T = triangles_of(solid.shape), T_world_owner * solid.T_owner_shape
        corners = np.asarray(surface.vertices) @ T.rotation.T + T.translation
        low, high = corners.min(axis=0) - AROUND_ROBOT, corners.max(axis=0) + AROUND_ROBOT
        if np.any((low > highest) | (high < lowest)):
            continue
        near = np.flatnonzero(~is_robot & np.all((points >= low) & (points <= high), axis=1))
        if len(near):
            scene = o3d.t.geometry.RaycastingScene()
            add_surface(scene, surface, T)
            queries = o3d.core.Tensor(points[near].astype(np.float32))
            away = scene.compute_signed_distance(queries, nthreads=1).numpy()
            is_robot[near[away <= AROUND_ROBOT]] = True
    return is_robot


def robot_solids(cell: Cell, joints: Mapping[str, float]) -> Iterator[tuple[Solid, pin.SE3]]:
    """What the robot is made of, with the pose in the world of the link that carries it.

    Args:
        cell: whose robot it is; the scanner's own housing is not in its picture.
        joints: name -> [rad, m].
    """
    poses = cell.robot.link_poses(joints)
    for link in cell.robot.links:
        for solid in link.collision:
            yield solid, cell.T_world_robot * poses[link.name]
    for arm in cell.arms:
        T_world_flange = cell.T_world_robot * poses[arm.flange]
        for solid in arm.tool.body:
            yield solid, T_world_flange
        for finger in arm.tool.fingers:
            for opening in arm.tool.stroke:
                shift = pin.SE3(np.eye(3), np.asarray(finger.direction) * opening / 2)
                yield finger.solid, T_world_flange * shift

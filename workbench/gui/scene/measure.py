"""What a person clicks on: the first thing that a ray through the scene meets."""

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.shared.look import View
from workbench.model.cell import Cell
from workbench.model.derived.by_bin import surfaces
from workbench.model.geometry import Floats, Shape, Solid
from workbench.planning.kinematics.robot import Kinematics

NEAR_RAY = 0.003
"""[m] A scanned point this close to the ray was meant."""

HEIGHTS = np.deg2rad([25.0, 45.0, 10.0, 65.0])
"""[rad] Above the horizon, from where a place is viewed, the best first."""


def pick_point(
    origin: Floats, direction: Floats, cell: Cell, q: Mapping[str, Floats], points: Floats
) -> Floats | None:
    """The first point (3,) of cell, robot or scan on a ray; None when it meets nothing.

    Args:
        origin: of the ray (3,) [m], world frame.
        direction: of the ray (3,).
        cell: what stands there.
        q: arm -> configuration (n,) [rad]; arms not named stand at home.
        points: of the scan (n, 3) [m].
    """
    ray = np.asarray(direction) / np.linalg.norm(direction)
    corners = np.concatenate([_corners(T, solids) for T, solids in _owners(cell, q)])
    distances = _triangle_distances(np.asarray(origin), ray, corners)
    distances = np.append(distances, _point_distances(np.asarray(origin), ray, points))
    if not len(distances) or not np.isfinite(distances.min()):
        return None
    return np.asarray(origin) + distances.min() * ray


def pointed_at(view: View, origin: Floats, direction: Floats) -> Floats | None:
    """The first point (3,) [m] on a ray of cell, scan, or robot as it is drawn; see `met`."""
    scan = view.state.scan
    points = np.zeros((0, 3)) if scan is None else scan.points_world
    # The robot as it is drawn, not as it stands at home.
    q = {arm: moment.q for arm, moment in view.moments.items()}
    return pick_point(origin, direction, view.state.cell, q, points)


def part_at(view: View, origin: Floats, direction: Floats) -> int | None:
    """The number of the part found that a ray meets before anything of cell or robot, if any.

    Args:
        view: what is seen.
        origin: of the ray (3,) [m], world frame.
        direction: of the ray (3,).
    """
    state = view.state
    ray = np.asarray(direction) / np.linalg.norm(direction)
    distances = [
        _triangle_distances(
            origin, ray, _placed(found.T_world_part, state.cell.part(found.part).mesh)
        ).min(initial=np.inf)
        for found in state.detections or ()
    ]
    nearest = int(np.argmin(distances)) if distances else 0
    if not distances or not np.isfinite(distances[nearest]):
        return None
    q = {arm: moment.q for arm, moment in view.moments.items()}
    before = pick_point(origin, direction, state.cell, q, np.zeros((0, 3)))
    if before is not None and (before - origin) @ ray < distances[nearest]:
        return None
    return nearest


def clear_way(
    target: Floats, line: Floats, far: float, cell: Cell, q: Mapping[str, Floats]
) -> Floats:
    """From which side (3,) a point is seen, and best a line through it: nothing stands between.

    Args:
        target: the point (3,) [m], world frame.
        line: (3,) along what is to be seen from its side.
        far: how far off it is seen from [m].
        cell: what stands there.
        q: arm -> configuration (n,) [rad]; arms not named stand at home.
    """
    turns, heights = np.meshgrid(np.linspace(0, 2 * np.pi, 24, endpoint=False), HEIGHTS)
    level = np.cos(heights)
    sides = np.stack([level * np.cos(turns), level * np.sin(turns), np.sin(heights)], axis=-1)
    sides = sides.reshape(-1, 3)
    along = line / max(float(np.linalg.norm(line)), 1e-9)
    sides = sides[np.argsort(np.abs(sides @ along).round(2), kind="stable")]
    corners = np.concatenate([_corners(T, solids) for T, solids in _owners(cell, q)])
    for side in sides:
        if _triangle_distances(target + far * side, -side, corners).min() >= far:
            return side
    return sides[0]


def _owners(cell: Cell, q: Mapping[str, Floats]) -> list[tuple[pin.SE3, tuple[Solid, ...]]]:
    kinematics = Kinematics(cell)
    links = kinematics.link_poses(cell.joint_values(q))
    owners = [(links[link.name], link.visual or link.collision) for link in cell.robot.links]
    owners += [
        (links[a.flange], (*a.tool.body, *cell.scanner.housing_of(a.name))) for a in cell.arms
    ]
    owners += [(fixture.T_world_fixture, fixture.solids) for fixture in surfaces(cell)]
    return [*owners, (cell.bin.T_world_bin, cell.bin.solids)]


def _corners(T: pin.SE3, solids: tuple[Solid, ...]) -> Floats:
    """Triangles (n, 3, 3) in the world."""
    found = [np.zeros((0, 3, 3))]
    for solid in solids:
        found.append(_placed(T * solid.T_owner_shape, solid.shape))
    return np.concatenate(found)


def _placed(T: pin.SE3, shape: Shape) -> Floats:
    """Triangles (n, 3, 3) [m] of a shape at a pose."""
    surface = triangles_of(shape)
    points = np.asarray(surface.vertices) @ T.rotation.T + T.translation
    return points[np.asarray(surface.faces)]


def _triangle_distances(origin: Floats, ray: Floats, corners: Floats) -> Floats:
    """How far along the ray it meets each triangle, infinite where it does not.

    Source: T. Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
    """
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(ray, v)
    determinant = np.einsum("ij,ij->i", u, across)
    # A ray along a triangle's plane meets nothing: what is divided by zero compares as False.
    with np.errstate(all="ignore"):
        offset = origin - a
        first = np.einsum("ij,ij->i", offset, across) / determinant
        other = np.cross(offset, u)
        second = other @ ray / determinant
        distance = np.einsum("ij,ij->i", v, other) / determinant
        is_met = (first >= 0) & (second >= 0) & (first + second <= 1) & (distance > 1e-6)
    return np.where(is_met, distance, np.inf)


def _point_distances(origin: Floats, ray: Floats, points: Floats) -> Floats:
    along = (points - origin) @ ray
    beside = np.linalg.norm(points - origin - along[:, None] * ray, axis=1)
    return np.where((beside < NEAR_RAY) & (along > 0), along, np.inf)

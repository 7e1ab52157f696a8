"""What a scan shows that neither the cell nor the parts found explain: obstacles nobody modelled.

Points near a known surface are explained by it.  What is left is counted in small cubes: so the
cost goes by how much there is to see and not by how finely it was seen; mistakes of the
scanner are dropped (`spurious`), and the rest becomes a few upright boxes.  They reach down to the
floor below: the scanner does not see what is underneath.
"""

from collections.abc import Iterable, Iterator

import numpy as np
import open3d as o3d
import pinocchio as pin
from numba import njit

from workbench.model.cell import Cell
from workbench.model.derived.by_bin import barriers
from workbench.model.derived.by_view import scans_by_view
from workbench.model.geometry import Box, Floats, Ints, Solid
from workbench.model.scan import Detection, Obstacle, Scan, Unexplained
from workbench.perception.scene.hidden import Room, hidden_columns
from workbench.perception.scene.reach import reach
from workbench.perception.scene.roofs import roofs_over
from workbench.perception.scene.spurious import believed, pixel_angle
from workbench.perception.scene.upright_boxes import Grid, upright_boxes
from workbench.perception.scene.voxels import Voxels, counted
from workbench.perception.views.surfaces import add_surface, triangles_of

EXPLAINED_WITHIN = 0.006
"""[m] This far from a known surface a point still belongs to it: noise, and pose errors."""

CUBE = 0.002
"""[m] Edge of the cubes that points are counted in: a third of the tolerance."""

NARROWEST = 0.006
"""[m] Seen from above, things so near to each other are one, as are those between wide pixels."""

BETWEEN = 1.5
"""Width of a grid cell over the distance of points: what lies between them is not seen."""

FARTHEST_REACH = 20.0
"""[m] No arm gets further, whatever the limits of its joints say."""

GOES_ON = 0.25
"""Share of the longest part's length by which things go on unseen, beside what is seen of them."""

AT_ONCE = 4096
"""Points: Open3D lets no other thread of the process run meanwhile, and the page's draws scans."""

OF_THE_CELL = -1
UNEXPLAINED = -2


def explained_by(cell: Cell, detections: tuple[Detection, ...], points: Floats) -> Ints:
    """What each point (n, 3) [m] in the world belongs to, as integers (n,).

    Returns:
        The number of the detection, `OF_THE_CELL` for bin and fixtures, or `UNEXPLAINED`.
    """
    scene, owners = known_surfaces(cell, detections)
    return _owners(scene, owners, points)


def unexplained(
    cell: Cell,
    scan: Scan,
    detections: tuple[Detection, ...],
    standing: tuple[Detection, ...] = (),
) -> tuple[Obstacle, ...]:
    """Upright boxes around all within the robot's reach that nothing known explains.

    Args:
        cell: bin and fixtures; the robot is expected to be out of the picture.
        scan: what was seen.
        detections: the parts found in it.
        standing: parts that stand in an assembly.
    """
    return look_around(cell, scan, detections, standing).seen


def look_around(
    cell: Cell,
    scan: Scan,
    detections: tuple[Detection, ...],
    standing: tuple[Detection, ...] = (),
) -> Unexplained:
    """As `unexplained`, and where all that may go on unseen.

    Args:
        cell: bin and fixtures; the robot is expected to be out of the picture.
        scan: what was seen.
        detections: the parts found in it.  Of a merged one each view counts: what any of them
            shows is there.
        standing: parts that stand in an assembly, which explain what is seen of them.
    """
    if len(scan.views) > 1:
        found = [look_around(cell, each, detections, standing) for each in scans_by_view(scan)]
        return Unexplained(
            tuple(box for each in found for box in each.seen),
            tuple(box for each in found for box in each.unseen),
        )
    T_bin_world = cell.bin.T_world_bin.inverse()
    T_bin_scanner = T_bin_world * scan.T_world_scanner
    centre = T_bin_world.act(cell.T_world_robot.translation)
    radius = min(reach(cell), FARTHEST_REACH)
    boxes = [
        (T_bin_world * T, solid.shape.size)
        for T, solid in _solids(cell)
        if isinstance(solid.shape, Box)
    ]
    Ts = np.array([T.inverse().homogeneous for T, _ in boxes])
    halves = np.array([size / 2 for _, size in boxes])
    T = T_bin_scanner.homogeneous
    left, within = _points_left(scan.points, T, centre, radius, Ts, halves, EXPLAINED_WITHIN)
    if len(left) == 0:
        return Unexplained()
    voxels = counted(left, CUBE)
    scene, owners = known_surfaces(cell, (*detections, *standing), T_bin_world)
    voxels = voxels.only(_owners(scene, owners, voxels.centres) == UNEXPLAINED)
    if len(voxels.counts) == 0:
        return Unexplained()
    angle = pixel_angle(scan.points, within)
    pitch = angle * float(np.linalg.norm(T_bin_scanner.translation))
    voxels = voxels.only(believed(voxels, T_bin_scanner.translation, angle, pitch, scene))
    parts = o3d.t.geometry.RaycastingScene(nthreads=1)
    _add_parts(parts, cell, detections, T_bin_world)
    half = cell.bin.size[:2] / 2
    longest = max(float(np.linalg.norm(np.ptp(part.mesh.points, axis=0))) for part in cell.parts)
    eye, top = T_bin_scanner.translation, _top(cell, detections)
    room = Room(parts, eye, half, top, GOES_ON * longest)
    return Unexplained(*(_place(cell, some) for some in _boxes_around(voxels, pitch, room)))


def _place(cell: Cell, boxes: Iterable[Obstacle]) -> tuple[Obstacle, ...]:
    """Boxes of the bin's frame in the world."""
    return tuple(Obstacle(cell.bin.T_world_bin * box.T_world_box, box.size) for box in boxes)


def _top(cell: Cell, detections: tuple[Detection, ...]) -> float:
    """Height [m] of the highest of the parts over the bin's floor, 0 for none."""
    T_bin_world = cell.bin.T_world_bin.inverse()
    up = (T_bin_world * detection.T_world_part for detection in detections)
    heights = (
        T.translation[2] + cell.part(detection.part).mesh.points @ T.rotation[2]
        for detection, T in zip(detections, up, strict=True)
    )
    return max((float(some.max()) for some in heights), default=0.0)


def _boxes_around(voxels: Voxels, pitch: float, room: Room) -> Iterator[tuple[Obstacle, ...]]:
    """Boxes in the frame of the voxels, clear of parts where they can.

    First those that hold all voxels, then those where what is seen there may go on.
    """
    many = max(int(np.ceil(BETWEEN * pitch / voxels.edge)), 1)
    cells, place = np.unique(voxels.index[:, :2] // many, axis=0, return_inverse=True)
    tops = np.full(len(cells), -np.inf)
    np.maximum.at(tops, place.reshape(-1), (voxels.index[:, 2] + 1) * voxels.edge)
    edge = many * voxels.edge
    grid = Grid(edge, max(int(np.ceil(NARROWEST / edge)), 1))
    for columns in (cells, tops), hidden_columns(cells, tops, edge, room):
        yield upright_boxes(*columns, grid, roofs_over(*columns, edge, room.parts))


def _add_parts(
    scene: o3d.t.geometry.RaycastingScene,
    cell: Cell,
    detections: tuple[Detection, ...],
    T_frame_world: pin.SE3,
) -> None:
    for detection in detections:
        mesh = cell.part(detection.part).mesh
        add_surface(scene, triangles_of(mesh), T_frame_world * detection.T_world_part)


def _solids(cell: Cell) -> list[tuple[pin.SE3, Solid]]:
    """All that stands still, with its pose in the world."""
    owners = [(cell.bin.T_world_bin, cell.bin.solids)]
    owners += [(fixture.T_world_fixture, fixture.solids) for fixture in barriers(cell)]
    return [(T * solid.T_owner_shape, solid) for T, solids in owners for solid in solids]


def known_surfaces(
    cell: Cell, detections: tuple[Detection, ...], T_frame_world: pin.SE3 | None = None
) -> tuple[o3d.t.geometry.RaycastingScene, Ints]:
    """All known surfaces in some frame, the world's for None, and whose each is.

    Whose they are is said as by `explained_by`, for the index (g,) of each geometry.
    """
    T_frame_world = pin.SE3.Identity() if T_frame_world is None else T_frame_world
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    solids = _solids(cell)
    for T, solid in solids:
        add_surface(scene, triangles_of(solid.shape), T_frame_world * T)
    _add_parts(scene, cell, detections, T_frame_world)
    return scene, np.array([OF_THE_CELL] * len(solids) + list(range(len(detections))))


def _owners(scene: o3d.t.geometry.RaycastingScene, owners: Ints, points: Floats) -> Ints:
    """Whose the surface near each point (n, 3) is, `UNEXPLAINED` where none is, (n,)."""
    queries = np.ascontiguousarray(points, dtype=np.float32)
    found = np.full(len(points), UNEXPLAINED, dtype=owners.dtype)
    for begin in range(0, len(queries), AT_ONCE):
        some = queries[begin : begin + AT_ONCE]
        nearest = scene.compute_closest_points(o3d.core.Tensor(some), nthreads=1)
        away = np.linalg.norm(nearest["points"].numpy() - some, axis=1)
        whose = owners[nearest["geometry_ids"].numpy().astype(np.int64)]
        found[begin : begin + AT_ONCE] = np.where(away <= EXPLAINED_WITHIN, whose, UNEXPLAINED)
    return found


@njit(cache=True)
def _points_left(
    points: Floats,
    T: Floats,
    centre: Floats,
    radius: float,
    Ts: Floats,
    halves: Floats,
    tolerance: float,
) -> tuple[Floats, Ints]:  # pragma: no cover (compiled)
    """Points (m, 3) in a ball and away from all box surfaces; and the indices of those in the ball.

    A scan shows mostly bin and table, which are boxes: distances to boxes are quick to compute.

    Args:
        points: (n, 3) [m] in some frame.
        T: (4, 4) puts them in the frame of all else, and of what is returned.
        centre: (3,) [m] of the ball.
        radius: [m] of the ball.
        Ts: (b, 4, 4) put points in the frames of boxes.
        halves: (b, 3) [m] half lengths of boxes.
        tolerance: [m] distance that counts as near.
    """
    left, within = np.empty(points.shape), np.empty(len(points), np.int64)
    count, number = 0, 0
    for k in range(len(points)):
        a, b, c = points[k, 0], points[k, 1], points[k, 2]
        x = T[0, 0] * a + T[0, 1] * b + T[0, 2] * c + T[0, 3]
        y = T[1, 0] * a + T[1, 1] * b + T[1, 2] * c + T[1, 3]
        z = T[2, 0] * a + T[2, 1] * b + T[2, 2] * c + T[2, 3]
        if not (x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2 <= radius**2:
            continue
        within[number] = k
        number += 1
        is_near = False
        for i in range(len(Ts)):
            deepest, outside = -np.inf, 0.0
            for j in range(3):
                B = Ts[i, j]
                over = abs(B[0] * x + B[1] * y + B[2] * z + B[3]) - halves[i, j]
                deepest = max(deepest, over)
                outside += max(over, 0.0) ** 2
            if -tolerance <= deepest and outside <= tolerance**2:
                is_near = True
                break
        if not is_near:
            left[count, 0], left[count, 1], left[count, 2] = x, y, z
            count += 1
    return left[:count], within[:number]

"""A simulated scan of the reference plate: held by the robot, or standing over the bin.

The piles that `synthesize` looks at have no robot in them; here it is the robot that is checked.
"""

from collections.abc import Mapping

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.calibration import BallPlate
from workbench.model.cell import Bin, Cell
from workbench.model.derived.by_bin import surfaces
from workbench.model.errors import InputError
from workbench.model.geometry import Cylinder, Floats, Solid, Sphere
from workbench.model.scan import Scan
from workbench.perception.views.camera import Pinhole
from workbench.perception.views.surfaces import add_solids, rays_of

ROD = 0.002
"""[m] Radius of the rods that carry the balls."""

GRAZING = 0.26
"""Cosine of incidence below which nothing is measured."""

LOST = 0.02
"""Share of pixels that fail."""

OFFSET, HEIGHT = 0.11, -0.06
"""[m] Offset of the simulated plate from the tool, along x of the TCP, and above it."""


def held_pose(plate: BallPlate) -> pin.SE3:
    """`T_tcp_plate` of the simulation: next to the tool, which hides no ball from above."""
    middle = plate.centres.mean(axis=0)
    return pin.SE3(np.eye(3), np.array([OFFSET, -middle[1], HEIGHT]))


def standing_pose(box: Bin, plate: BallPlate) -> pin.SE3:
    """`T_world_plate` of the simulation: level in the middle of a bin, as high as its rim."""
    middle = np.array([0.0, 0.0, box.size[2] + plate.radius]) - plate.centres.mean(axis=0)
    return box.T_world_bin * pin.SE3(np.eye(3), middle)


def _plate_solids(plate: BallPlate) -> tuple[Solid, ...]:
    """The balls, rods between them, and one to hold the plate by, in the plate's frame."""
    hold = np.array([-OFFSET, plate.centres.mean(axis=0)[1], 0.0])
    return ball_solids(plate.centres, plate.radius, ((plate.centres[0], hold),))


def ball_solids(
    centres: Floats, radius: float, more: tuple[tuple[Floats, Floats], ...] = ()
) -> tuple[Solid, ...]:
    """Balls of a radius [m] at centres (k, 3) [m], and rods from each to the next and the first.

    `more` are the ends (3,) [m] of further rods.
    """
    solids = [
        Solid(f"ball_{k + 1}", Sphere(radius), pin.SE3(np.eye(3), centre))
        for k, centre in enumerate(centres)
    ]
    rods = zip(centres, np.roll(centres, -1, axis=0), strict=True)
    for k, (start, end) in enumerate((*rods, *more)):
        along = end - start
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), along).matrix()
        rod = Cylinder(ROD, float(np.linalg.norm(along)))
        solids.append(Solid(f"rod_{k + 1}", rod, pin.SE3(turn, (start + end) / 2)))
    return tuple(solids)


def scan_plate(
    cell: Cell,
    Ts_world_link: Mapping[str, pin.SE3],
    plate: BallPlate,
    T_world_plate: pin.SE3,
    *,
    seed: int,
    T_world_scanner: pin.SE3,
) -> Scan:
    """What the scanner sees of robot, tools, plate, bin and fixtures.

    Args:
        cell: with the scanner.
        Ts_world_link: where every link is.
        plate: the reference.
        T_world_plate: where it is.
        seed: of the noise.
        T_world_scanner: where the scanner truly is.

    Raises:
        InputError: nothing is within the scanner's range.
    """
    scene = cell_scene(cell, Ts_world_link)
    add_solids(scene, _plate_solids(plate), T_world_plate)
    return scan_scene(cell, scene, seed=seed, T_world_scanner=T_world_scanner)


def scan_scene(
    cell: Cell, scene: o3d.t.geometry.RaycastingScene, *, seed: int, T_world_scanner: pin.SE3
) -> Scan:
    """What the scanner of a cell sees of a scene from a pose; see `scan_plate`."""
    mount = cell.scanner
    rays = Pinhole.of_scanner(mount).rays().reshape(-1, 3)
    directions = rays @ T_world_scanner.rotation.T
    hits = scene.cast_rays(rays_of(T_world_scanner.translation, directions))
    depth = hits["t_hit"].numpy().astype(np.float64)
    normals = hits["primitive_normals"].numpy()
    cosine = np.abs(np.sum(normals * directions, axis=1)) / np.linalg.norm(directions, axis=1)
    generator = np.random.default_rng(seed)
    seen = np.isfinite(depth) & (cosine > GRAZING) & (generator.random(len(depth)) > LOST)
    seen &= (depth > mount.near) & (depth < mount.far)
    pixels = np.flatnonzero(seen)
    if len(pixels) == 0:
        raise InputError(f"the scanner of cell {cell.name} sees nothing within its range")
    deviation = mount.depth_noise * depth[pixels] ** 2 / cosine[pixels]
    depth = depth[pixels] + deviation * generator.standard_normal(len(pixels))
    points = rays[pixels] * depth[:, None]
    return Scan(points, T_world_scanner, "simulated", pixels, mount.resolution)


def is_plate_in_sight(
    cell: Cell,
    Ts_world_link: Mapping[str, pin.SE3],
    plate: BallPlate,
    T_world_plate: pin.SE3,
    T_world_scanner: pin.SE3,
) -> bool:
    """Whether all three balls lie inside the scanner's picture and nothing of the robot hides them.

    Each ball is checked in its middle and at four places around it.
    """
    T_scanner_plate = T_world_scanner.actInv(T_world_plate)
    around = (
        0.8 * plate.radius * np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    )
    centres = plate.centres @ T_scanner_plate.rotation.T + T_scanner_plate.translation
    points = (centres[:, None] + around).reshape(-1, 3)
    camera = Pinhole.of_scanner(cell.scanner)
    pixels = points[:, :2] / points[:, 2:] * camera.focal + camera.centre
    rows, columns = camera.shape
    is_inside = (pixels >= 0).all() and (pixels < (columns, rows)).all()
    if not is_inside or points[:, 2].min() < cell.scanner.near + plate.radius:
        return False
    directions = points @ T_world_scanner.rotation.T
    rays = rays_of(T_world_scanner.translation, directions)
    hits = robot_scene(cell, Ts_world_link).cast_rays(rays)
    # A direction is as long as the way to its point: 1 is there.
    return bool((hits["t_hit"].numpy() > 1.0).all())


def robot_scene(cell: Cell, Ts_world_link: Mapping[str, pin.SE3]) -> o3d.t.geometry.RaycastingScene:
    """The robot and its tools, fingers closed."""
    scene = o3d.t.geometry.RaycastingScene()
    for link in cell.robot.links:
        add_solids(scene, link.visual or link.collision, Ts_world_link[link.name])
    for arm in cell.arms:
        solids = (*arm.tool.body, *(finger.solid for finger in arm.tool.fingers))
        add_solids(scene, solids, Ts_world_link[arm.flange])
    return scene


def cell_scene(cell: Cell, Ts_world_link: Mapping[str, pin.SE3]) -> o3d.t.geometry.RaycastingScene:
    """The robot, its tools, the bin and all fixtures."""
    scene = robot_scene(cell, Ts_world_link)
    add_solids(scene, cell.bin.solids, cell.bin.T_world_bin)
    for fixture in surfaces(cell):
        add_solids(scene, fixture.solids, fixture.T_world_fixture)
    return scene

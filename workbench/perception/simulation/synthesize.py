"""A scan of a known scene: what a scanner would have measured."""

from collections.abc import Sequence

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived import by_bin
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.scan import Detection, Scan
from workbench.perception.scene.own_robot import robot_solids
from workbench.perception.simulation.colouring import Light, coloured
from workbench.perception.simulation.noise_models import NoiseModel, noise_of
from workbench.perception.simulation.scan_noise import noisy
from workbench.perception.views.camera import Pinhole
from workbench.perception.views.surfaces import add_solids, add_surface, rays_of, triangles_of

PLAIN = 180
"""Of 255, each channel of what has no colours."""

LIT = 0.9995
"""Share of the way from projector to surface that must be free, short of the surface itself."""


def synthesize(
    cell: Cell,
    truth: Sequence[Detection],
    *,
    seed: int,
    noise: NoiseModel | None = None,
    light: Light | None = None,
    shows_robot: bool = False,
) -> Scan:
    """The organised cloud of the parts in their bin, seen by the cell's scanner.

    Rays through all pixels hit parts, bin and fixtures; the robot is outside the view.  Points that
    the projector next to the camera does not light are not measured (stereo shadows).  For the
    errors of the others see `scan_noise`.  If a part of the cell has colours, each point has one.

    Args:
        cell: bin, fixtures, parts and scanner.
        truth: the parts in the bin; may be empty.
        seed: of noise and failures.
        noise: the type of scanner; None: that of the cell.  The mount's `depth_noise` is the
            standard deviation of a single pixel.
        light: for colours; None: even white light.
        shows_robot: whether the robot, at home, is in the scene.

    Raises:
        InputError: a part that the cell does not know, or nothing within the scanner's range.
    """
    noise = noise or noise_of(cell.scanner)
    scene = _scene(cell, truth)
    if shows_robot:
        _add_robot(scene, cell)
    camera = Pinhole.of_scanner(cell.scanner)
    rays = camera.rays().reshape(-1, 3)
    depth, cosine, hits = _cast(scene, rays, cell.scanner.T_world_scanner, noise.baseline)
    generator = np.random.default_rng(seed)
    deviation = cell.scanner.depth_noise
    image = (depth.reshape(camera.shape), cosine.reshape(camera.shape))
    depth = noisy(*image, deviation, noise, generator).ravel()
    measured = (depth >= cell.scanner.near) & (depth <= cell.scanner.far)
    pixels = np.flatnonzero(measured)
    if len(pixels) == 0:
        raise InputError(
            f"the scanner of cell {cell.name} sees nothing between {cell.scanner.near:g} m "
            f"and {cell.scanner.far:g} m; look at its position, near and far"
        )
    return Scan(
        points=rays[pixels] * depth[pixels, None],
        T_world_scanner=cell.scanner.T_world_scanner,
        source="simulated",
        pixels=pixels,
        resolution=cell.scanner.resolution,
        colours=_colours(cell, truth, hits[pixels], cosine[pixels], light or Light(), seed),
    )


def _colours(
    cell: Cell,
    truth: Sequence[Detection],
    hits: np.ndarray,
    cosine: Floats,
    light: Light,
    seed: int,
) -> np.ndarray | None:
    """Colours (n, 3) of what was hit (n, 2), see `_cast`; None where no part has any."""
    if all(part.colours is None for part in cell.parts):
        return None
    solids = (
        *cell.bin.solids,
        *(solid for fixture in by_bin.surfaces(cell) for solid in fixture.solids),
    )
    # What is seen across an edge, where nothing is hit, is as grey as parts without colours.
    paints = np.full((len(hits), 3), PLAIN, np.uint8)
    for number, detection in enumerate(truth):
        colours = cell.part(detection.part).colours
        if colours is not None:
            of = hits[:, 0] == number
            paints[of] = colours[hits[of, 1]]
    for number, solid in enumerate(solids, start=len(truth)):
        paints[hits[:, 0] == number] = np.round(255.0 * np.array(solid.colour))
    # Its own generator: the points are those of a scan without colours.
    return coloured(paints, cosine, light, np.random.default_rng((seed, 1)))


def visible_shares(cell: Cell, truth: Sequence[Detection]) -> tuple[float, ...]:
    """How much of each part the camera sees of what it would see were the part alone, 0..1."""
    camera = Pinhole.of_scanner(cell.scanner)
    directions = camera.rays().reshape(-1, 3) @ cell.scanner.T_world_scanner.rotation.T
    rays = rays_of(cell.scanner.T_world_scanner.translation, directions)
    hit = _scene(cell, truth).cast_rays(rays)["geometry_ids"].numpy()
    shares: list[float] = []
    for number, detection in enumerate(truth):
        alone = o3d.t.geometry.RaycastingScene()
        add_surface(alone, triangles_of(cell.part(detection.part).mesh), detection.T_world_part)
        shown = int(np.count_nonzero(np.isfinite(alone.cast_rays(rays)["t_hit"].numpy())))
        shares.append(np.count_nonzero(hit == number) / shown if shown else 0.0)
    return tuple(shares)


def _scene(cell: Cell, truth: Sequence[Detection]) -> o3d.t.geometry.RaycastingScene:
    """All that stands still, after the parts in their order."""
    scene = o3d.t.geometry.RaycastingScene()
    surfaces = {
        name: triangles_of(cell.part(name).mesh) for name in {detection.part for detection in truth}
    }
    for detection in truth:
        add_surface(scene, surfaces[detection.part], detection.T_world_part)
    add_solids(scene, cell.bin.solids, cell.bin.T_world_bin)
    for fixture in by_bin.surfaces(cell):
        add_solids(scene, fixture.solids, fixture.T_world_fixture)
    return scene


def _add_robot(scene: o3d.t.geometry.RaycastingScene, cell: Cell) -> None:
    at_home = cell.joint_values({arm.name: arm.home for arm in cell.arms})
    for solid, T_world_owner in robot_solids(cell, at_home):
        add_solids(scene, (solid,), T_world_owner)


def _cast(
    scene: o3d.t.geometry.RaycastingScene, rays: Floats, T_world_scanner: pin.SE3, baseline: float
) -> tuple[Floats, Floats, np.ndarray]:
    """Depth along z (infinite where nothing is hit) and cosine of incidence, each (n,).

    And what is hit (n, 2): the number of the surface in the scene, and of the triangle on it.

    The cosine is the smaller one of camera and projector, and zero where the projector's light is
    blocked or falls on the back.
    """
    directions = rays @ T_world_scanner.rotation.T
    hits = scene.cast_rays(rays_of(T_world_scanner.translation, directions))
    depth = hits["t_hit"].numpy().astype(np.float64)
    normals = hits["primitive_normals"].numpy().astype(np.float64)
    seen = np.sum(normals * directions, axis=1)
    # Normals look at the camera, whichever way round the triangle was written.
    normals *= -np.sign(seen)[:, None]
    cosine = np.abs(seen) / np.linalg.norm(directions, axis=1)

    hit = np.flatnonzero(np.isfinite(depth))
    projector = T_world_scanner.act(np.array([baseline, 0.0, 0.0]))
    beams = T_world_scanner.translation + depth[hit, None] * directions[hit] - projector
    is_dark = scene.test_occlusions(rays_of(projector, beams), tfar=LIT).numpy()
    lit = -np.sum(normals[hit] * beams, axis=1) / np.linalg.norm(beams, axis=1)
    cosine[hit] = np.where(is_dark, 0.0, np.clip(lit, 0.0, cosine[hit]))
    hit_ids = [hits[name].numpy().astype(np.int64) for name in ("geometry_ids", "primitive_ids")]
    return depth, cosine, np.stack(hit_ids, axis=1)

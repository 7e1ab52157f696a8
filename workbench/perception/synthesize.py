"""A scan of a known scene: what a structured-light scanner would have measured."""

from collections.abc import Iterable, Sequence

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Solid
from workbench.model.part import Part
from workbench.model.scan import Scan
from workbench.perception.camera import Pinhole
from workbench.perception.surfaces import add_surface, surface_of

GRAZING = 0.26
"""Cosine of incidence (75 degrees) below which too little of the pattern comes back."""

FADING = 0.42
"""Cosine (65 degrees) at which measurements begin to fail now and then."""

DROP_OUT = 0.01
"""Share of pixels that fail anywhere: dust, gloss, decoding errors."""


def synthesize(cell: Cell, part: Part, Ts_world_part: Sequence[pin.SE3], *, seed: int) -> Scan:
    """The organised cloud of the parts in their bin, seen by the cell's scanner.

    Rays through all pixels meet parts, bin and fixtures (the robot waits outside the view).
    The error lies along the ray and is Gaussian; its standard deviation grows with the square
    of the depth, as for every triangulating sensor, and with the inverse cosine of incidence,
    as the pattern is smeared over the surface.  Pixels fail at random, more often on surfaces
    seen at a grazing angle.

    Args:
        cell: bin, fixtures and scanner.
        part: what the poses belong to.
        Ts_world_part: the true poses; may be empty.
        seed: of noise and failures.

    Raises:
        InputError: the scanner sees nothing within its range.
    """
    scene = o3d.t.geometry.RaycastingScene()
    surface = surface_of(part.mesh)
    for T_world_part in Ts_world_part:
        add_surface(scene, surface, T_world_part)
    _add_solids(scene, cell.bin.solids, cell.bin.T_world_bin)
    for fixture in cell.fixtures:
        _add_solids(scene, fixture.solids, fixture.T_world_fixture)

    camera = Pinhole.of_scanner(cell.scanner)
    rays = camera.rays().reshape(-1, 3)
    depth, cosine = _cast(scene, rays, cell.scanner.T_world_scanner)
    generator = np.random.default_rng(seed)
    depth = depth + _errors(depth, cosine, rays, cell.scanner.depth_noise, generator)
    measured = (
        (depth >= cell.scanner.near)
        & (depth <= cell.scanner.far)
        & ~_fails(cosine, generator.random(len(rays)))
    )
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
    )


def _add_solids(
    scene: o3d.t.geometry.RaycastingScene, solids: Iterable[Solid], T_world_owner: pin.SE3
) -> None:
    for solid in solids:
        add_surface(scene, surface_of(solid.shape), T_world_owner * solid.T_owner_shape)


def _cast(
    scene: o3d.t.geometry.RaycastingScene, rays: Floats, T_world_scanner: pin.SE3
) -> tuple[Floats, Floats]:
    """Depth along z (infinite where nothing is hit) and cosine of incidence, each (n,)."""
    directions = rays @ T_world_scanner.rotation.T
    origins = np.broadcast_to(T_world_scanner.translation, directions.shape)
    hits = scene.cast_rays(
        o3d.core.Tensor(np.concatenate([origins, directions], axis=1).astype(np.float32))
    )
    depth = hits["t_hit"].numpy().astype(np.float64)
    normals = hits["primitive_normals"].numpy().astype(np.float64)
    cosine = np.abs(np.sum(normals * directions, axis=1)) / np.linalg.norm(directions, axis=1)
    return depth, cosine


def _errors(
    depth: Floats,
    cosine: Floats,
    rays: Floats,
    noise: float,
    generator: np.random.Generator,
) -> Floats:
    """Errors of the depth [m], (n,); `noise` is their deviation at 1 m, met head-on."""
    seen = np.isfinite(depth)
    deviation = np.zeros_like(depth)
    deviation[seen] = noise * depth[seen] ** 2 / np.maximum(cosine[seen], GRAZING)
    return deviation * generator.standard_normal(len(depth)) / np.linalg.norm(rays, axis=1)


def _fails(cosine: Floats, chance: Floats) -> np.ndarray:
    """Which pixels give no measurement; `chance` (n,) is uniform in 0..1."""
    fading = np.clip((FADING - cosine) / (FADING - GRAZING), 0.0, 1.0)
    return chance < DROP_OUT + (1.0 - DROP_OUT) * fading

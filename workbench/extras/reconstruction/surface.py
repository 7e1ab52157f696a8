"""From a signed distance field to one closed surface of few triangles."""

import numpy as np
import open3d as o3d
import trimesh
from scipy import ndimage
from scipy.spatial import KDTree

from workbench.model.errors import InputError
from workbench.model.geometry import Bools, Floats, Ints
from workbench.perception.views.surfaces import add_surface

AVERAGED = 1.0
"""[voxels] Deviation of the weights by which the field is averaged: takes noise and steps away."""

LEAST_VALUE = 1e-3
"""Values nearer to zero would put corners of several triangles on one voxel."""

ROUGHEST = 16.0
"""Squared distances of planes, as multiples of the squared tolerance, that are tried first."""

MOST_HALVINGS = 8
"""How often a simplification that is too far off is tried again with half the distance."""


def closed_surface(field: Floats, origin: Floats, voxel: float) -> trimesh.Trimesh:
    """The largest closed surface of a field, what is enclosed in it left out.

    Args:
        field: (x, y, z), positive outside, as `fused` has it.
        origin: (3,) [m] middle of the first voxel.
        voxel: [m].

    Raises:
        InputError: nothing is inside.
    """
    smooth = ndimage.gaussian_filter(field, AVERAGED)
    smooth = np.where(
        np.abs(smooth) < LEAST_VALUE, np.where(smooth < 0, -LEAST_VALUE, LEAST_VALUE), smooth
    )
    bodies, count = _label(smooth < 0)
    if count == 0:
        raise InputError("the scans show no part in the region")
    largest = 1 + int(np.argmax(np.bincount(bodies.ravel())[1:]))
    smooth = np.where((smooth < 0) & (bodies != largest), LEAST_VALUE, smooth)
    airs, _ = _label(smooth > 0)
    smooth = np.where((smooth > 0) & (airs != airs[0, 0, 0]), -LEAST_VALUE, smooth)
    # Open3D has z, y, x in this order, and the triangles of what is negative look inward.
    volume = o3d.core.Tensor(np.ascontiguousarray(smooth.transpose(2, 1, 0), dtype=np.float32))
    found = o3d.t.geometry.TriangleMesh.create_isosurfaces(volume, [0.0])
    points = origin + voxel * found.vertex.positions.numpy().astype(np.float64)
    triangles = found.triangle.indices.numpy()[:, ::-1]
    return trimesh.Trimesh(points, triangles, process=False)


def _label(mask: Bools) -> tuple[Ints, int]:
    """The bodies of a mask (x, y, z), from 1 on and 0 elsewhere, and how many there are."""
    bodies = np.zeros(mask.shape, dtype=np.int32)
    count = ndimage.label(mask, output=bodies)
    return bodies, int(np.asarray(count))


def simplified(surface: trimesh.Trimesh, tolerance: float) -> trimesh.Trimesh:
    """The surface with fewer triangles, still closed; no corner of either further off the other.

    Simplified by quadric error (Garland, Heckbert, 1997), which bounds no distance: so that is
    measured, and a result that is too far off is tried again with a smaller error.

    Args:
        surface: closed.
        tolerance: [m].

    Returns:
        The surface as it was when every result is too far off or open.
    """
    full = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(surface.vertices), o3d.utility.Vector3iVector(surface.faces)
    )
    # Open3D weighs the squared distance to a plane by the area that it stands for.
    error = ROUGHEST * tolerance**2 * float(surface.area_faces.mean())
    for _ in range(MOST_HALVINGS):
        fewer = full.simplify_quadric_decimation(4, maximum_error=error)
        tried = trimesh.Trimesh(np.asarray(fewer.vertices), np.asarray(fewer.triangles))
        if (
            tried.is_watertight
            and tried.is_winding_consistent
            and tried.body_count == 1
            and distances(surface.vertices, tried).max() <= tolerance
            and distances(tried.vertices, surface).max() <= tolerance
        ):
            return tried
        error /= 4
    return surface


def distances(points: Floats, surface: trimesh.Trimesh) -> Floats:
    """How far points (n, 3) [m] lie from a surface, (n,) [m], never below zero."""
    scene = o3d.t.geometry.RaycastingScene()
    add_surface(scene, surface)
    query = o3d.core.Tensor(np.ascontiguousarray(points, dtype=np.float32))
    return scene.compute_distance(query).numpy().astype(np.float64)


def unseen_share(surface: trimesh.Trimesh, measured: Floats, gate: float) -> float:
    """The share (0..1) of the surface where nothing was measured: it was closed there.

    Args:
        surface: with triangles that are small beside the gate.
        measured: (n, 3) [m] of the part, by all views.
        gate: [m] what is no further from a measured point was seen.
    """
    middles = surface.triangles_center
    away = KDTree(measured).query(middles, distance_upper_bound=gate)[0]
    areas = surface.area_faces
    return float(areas[~np.isfinite(away)].sum() / areas.sum())

"""Shapes as triangles, as the simulated scanner and the localizer see them."""

from collections.abc import Iterable
from typing import assert_never

import numpy as np
import open3d as o3d
import pinocchio as pin
import trimesh

from workbench.model.geometry import Box, Capsule, Cylinder, Floats, Mesh, Shape, Solid, Sphere

SECTIONS = 64
"""Facets around a cylinder."""


def triangles_of(shape: Shape) -> trimesh.Trimesh:
    """The closed surface of a shape in its own frame [m]."""
    match shape:
        case Box(size=size):
            return trimesh.creation.box(extents=np.array(size))
        case Cylinder(radius=radius, length=length):
            return trimesh.creation.cylinder(radius, length, sections=SECTIONS)
        case Capsule(radius=radius, length=length):
            capsule = trimesh.creation.capsule(length, radius, count=(SECTIONS // 2, SECTIONS))
            capsule.apply_translation(-capsule.bounds.mean(axis=0))
            return capsule
        case Sphere(radius=radius):
            return trimesh.creation.icosphere(3, radius)
        case Mesh(points=points, triangles=triangles):
            return trimesh.Trimesh(np.array(points), np.array(triangles), process=False)
        case _:
            assert_never(shape)


def add_surface(
    scene: o3d.t.geometry.RaycastingScene, surface: trimesh.Trimesh, T: pin.SE3 | None = None
) -> None:
    """Put a surface at pose `T` of the scene's frame into a ray-casting scene."""
    points = np.asarray(surface.vertices)
    if T is not None:
        points = points @ T.rotation.T + T.translation
    scene.add_triangles(
        o3d.core.Tensor(np.ascontiguousarray(points, dtype=np.float32)),
        o3d.core.Tensor(np.ascontiguousarray(surface.faces, dtype=np.uint32)),
    )


def add_solids(
    scene: o3d.t.geometry.RaycastingScene, solids: Iterable[Solid], T_world_owner: pin.SE3
) -> None:
    """Put the solids of an owner (bin, fixture, link, flange, plate) into a scene of the world."""
    for solid in solids:
        add_surface(scene, triangles_of(solid.shape), T_world_owner * solid.T_owner_shape)


def rays_of(origins: Floats, directions: Floats) -> o3d.core.Tensor:
    """Rays as Open3D casts them, from origins (n, 3) or one (3,) along directions (n, 3) [m].

    Distances along a ray are reported in lengths of its direction.
    """
    starts = np.broadcast_to(origins, directions.shape)
    return o3d.core.Tensor(np.concatenate([starts, directions], axis=1).astype(np.float32))

"""Solids as triangles: for drawing, and for programs that know nothing but meshes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, assert_never

import numpy as np

from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Shape, Solid, Sphere

if TYPE_CHECKING:
    import trimesh  # takes half a second, which who only reads a cell need not wait for


def triangles_of(shape: Shape) -> trimesh.Trimesh:
    """The surface of a shape in its own frame [m]."""
    import trimesh

    match shape:
        case Box(size=size):
            return trimesh.creation.box(extents=np.array(size))
        case Cylinder(radius=radius, length=length):
            return trimesh.creation.cylinder(radius, length, sections=48)
        case Capsule(radius=radius, length=length):
            capsule = trimesh.creation.capsule(length, radius, count=(24, 24))
            capsule.apply_translation([0.0, 0.0, -capsule.bounds.mean(axis=0)[2]])
            return capsule
        case Sphere(radius=radius):
            return trimesh.creation.icosphere(3, radius)
        case Mesh(pieces=(_, *_) as pieces):
            return join_surfaces([triangles_of(piece) for piece in pieces])
        case Mesh(points=points, triangles=triangles):
            return trimesh.Trimesh(np.array(points), np.array(triangles), process=False)
        case _:
            assert_never(shape)


def join_surfaces(surfaces: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    """Several surfaces as one."""
    import trimesh

    offsets = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    return trimesh.Trimesh(
        np.concatenate([surface.vertices for surface in surfaces]),
        np.concatenate(
            [surface.faces + shift for surface, shift in zip(surfaces, offsets, strict=False)]
        ),
        process=False,
    )


def surface_of(solids: Iterable[Solid]) -> trimesh.Trimesh:
    """All solids of one body as one surface in the body's frame [m]."""
    surfaces: list[trimesh.Trimesh] = []
    for solid in solids:
        surface = triangles_of(solid.shape)
        surface.apply_transform(solid.T_owner_shape.homogeneous)
        surfaces.append(surface)
    return join_surfaces(surfaces)


def stl_of(surface: trimesh.Trimesh) -> bytes:
    """A surface as the content of a binary STL file [m]."""
    from trimesh.exchange.stl import export_stl

    return export_stl(surface)

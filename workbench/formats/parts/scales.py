"""A part's size over its CAD file, and how far off it its surface lies: applied, and written."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import tomlkit

from workbench.formats.files.toml_documents import read_document, short
from workbench.formats.files.whole_files import write_whole
from workbench.model.errors import FileError
from workbench.model.geometry import Box, Capsule, Floats, Mesh, Solid, Sphere, outwards

LEAST_SCALE, MOST_SCALE = 0.5, 2.0
"""Of a part over its CAD file, about what its symmetry leaves in its place."""

MOST_OFFSET = 10.0
"""[mm] By which the surface may lie outside or inside of the CAD file."""

DIGITS, OFFSET_DIGITS = 4, 2


def scale_mesh(mesh: Mesh, scale: float, fixed: Floats) -> Mesh:
    """The mesh `scale` times as large about a point (3,) [m]."""
    if scale == 1.0:
        return mesh
    pieces = tuple(scale_mesh(piece, scale, fixed) for piece in mesh.pieces)
    return replace(mesh, points=fixed + scale * (mesh.points - fixed), pieces=pieces)


def scale_solid(solid: Solid, scale: float, fixed: Floats) -> Solid:
    """The solid `scale` times as large about a point (3,) [m] of its owner's frame."""
    if scale == 1.0:
        return solid
    shape, T = solid.shape, solid.T_owner_shape
    if isinstance(shape, Mesh):
        shape = scale_mesh(shape, scale, np.zeros(3))
    elif isinstance(shape, Box):
        shape = Box(scale * shape.size)
    elif isinstance(shape, Sphere):
        shape = Sphere(scale * shape.radius)
    else:
        shape = replace(shape, radius=scale * shape.radius, length=scale * shape.length)
    moved = pin.SE3(T.rotation, fixed + scale * (T.translation - fixed))
    return replace(solid, shape=shape, T_owner_shape=moved)


def grow_mesh(mesh: Mesh, by: float) -> Mesh:
    """The mesh with its faces `by` [m] further outside, inside where negative."""
    if by == 0.0:
        return mesh
    # STL names each corner once a triangle.
    points, numbers = np.unique(mesh.points, axis=0, return_inverse=True)
    triangles = numbers.reshape(-1)[mesh.triangles]
    pieces = tuple(grow_mesh(piece, by) for piece in mesh.pieces)
    moved = points + by * outwards(points, triangles)
    return replace(mesh, points=moved, triangles=triangles, pieces=pieces)


def grow_solid(solid: Solid, by: float) -> Solid:
    """The convex solid with its surface `by` [m] further outside."""
    shape = solid.shape
    if isinstance(shape, Mesh):
        shape = grow_mesh(shape, by)
    elif isinstance(shape, Box):
        shape = Box(shape.size + 2 * by)
    elif isinstance(shape, Sphere):
        shape = Sphere(shape.radius + by)
    elif isinstance(shape, Capsule):
        shape = replace(shape, radius=shape.radius + by)
    else:
        shape = replace(shape, radius=shape.radius + by, length=shape.length + 2 * by)
    return replace(solid, shape=shape)


def round_shape(file: Path, scale: float, offset: float) -> tuple[float, float]:
    """Size and offset of a part as its file holds them.

    Args:
        file: the `part.toml` that is meant.
        scale: of the part over its CAD file, no unit.
        offset: [m] by which its surface lies outside of that; inside where negative.

    Raises:
        FileError: one of them is no longer allowed.
    """
    scale, offset_mm = short(scale, DIGITS), short(offset * 1000, OFFSET_DIGITS)
    if not LEAST_SCALE <= scale <= MOST_SCALE:
        raise FileError(
            file,
            f"scale would be {scale:g}: from {LEAST_SCALE:g} to {MOST_SCALE:g} is allowed, so the "
            "mesh's unit may be wrong",
        )
    if abs(offset_mm) > MOST_OFFSET:
        raise FileError(
            file,
            f"offset_mm would be {offset_mm:g}: from {-MOST_OFFSET:g} to {MOST_OFFSET:g} is "
            "allowed, so this may be another part",
        )
    return float(scale), float(offset_mm) / 1000


def write_shape(folder: Path, scale: float, offset: float) -> tuple[float, float]:
    """Write a part's size and offset into its `part.toml`; comments and all else stay.

    Args:
        folder: of the part.
        scale: see `round_shape`.
        offset: see there.

    Returns:
        Both as they are written.

    Raises:
        FileError: the file cannot be read or written, or one of them is no longer allowed.
    """
    file = folder / "part.toml"
    scale, offset = round_shape(file, scale, offset)
    document: Any = read_document(file)
    mesh = document["mesh"]
    for key, value, usual in (("scale", scale, 1.0), ("offset_mm", offset * 1000, 0.0)):
        if value != usual:
            mesh[key] = short(value)
        else:
            mesh.pop(key, None)
    write_whole(file, tomlkit.dumps(document).encode())
    return scale, offset

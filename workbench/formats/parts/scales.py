"""The size of a part over its CAD file: applied to its mesh and bodies, and written beside them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import tomlkit

from workbench.formats.files.toml_documents import read_document, short
from workbench.formats.files.whole_files import write_whole
from workbench.model.errors import FileError
from workbench.model.geometry import Box, Floats, Mesh, Solid, Sphere

LEAST_SCALE, MOST_SCALE = 0.5, 2.0
"""Of a part over its CAD file, about what its symmetry leaves in its place."""

DIGITS = 4


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


def change_scale(path: Path, factor: float) -> float:
    """Make a part `factor` times as large as its `part.toml` has it; comments and all else stay.

    Args:
        path: of the part's folder, or of its `part.toml`.
        factor: over the size that is written there, no unit.

    Returns:
        The size over the CAD file that is written now, no unit.

    Raises:
        FileError: the file cannot be read or written, or the size is no longer allowed.
    """
    file = path / "part.toml" if path.is_dir() else path
    document: Any = read_document(file)
    mesh = document["mesh"]
    scale = short(float(mesh.get("scale", 1.0)) * factor, DIGITS)
    if not LEAST_SCALE <= scale <= MOST_SCALE:
        raise FileError(
            file,
            f"scale would be {scale:g}: from {LEAST_SCALE:g} to {MOST_SCALE:g} is allowed, so the "
            "mesh's unit may be wrong",
        )
    mesh["scale"] = scale
    write_whole(file, tomlkit.dumps(document).encode())
    return float(scale)

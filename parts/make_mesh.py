"""Makes the mesh of a part: the union of the pieces in its part.toml, less the holes below.

Run after a change of part.toml, with the workbench and `manifold3d` installed, from the
repository's root: `python -m parts.make_mesh keyed_cylinder`.
"""

import sys
from pathlib import Path

import numpy as np
import trimesh
from trimesh.creation import box, cylinder

from workbench.formats.files.toml_keys import read_toml
from workbench.formats.meshes.solids import read_solid
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy

PARTS = Path(__file__).resolve().parent

SECTIONS = 48
"""Facets around the cylinders: the largest is 0.04 mm away from the circle."""

DIGITS = 4
"""Decimals of a millimetre that tell corners apart: edges that should meet in one point do."""

HOLES = {
    "bracket": (
        Solid("foot", Cylinder(0.006, 0.02), pose_from_rpy((0.055, 0, 0))),
        Solid("heel", Cylinder(0.004, 0.02), pose_from_rpy((0.025, 0.010, 0))),
        Solid("back", Cylinder(0.006, 0.02), pose_from_rpy((0, 0, 0.028), (0, np.pi / 2, 0))),
    )
}
"""What is drilled out of a part; pieces are convex and cannot say it."""


def mesh(name: str) -> trimesh.Trimesh:
    """The surface of the part in that folder [mm]."""
    pieces = read_toml(PARTS / name / "part.toml").tables("piece")
    whole = trimesh.boolean.union([_surface(read_solid(piece)) for piece in pieces])
    holes = [_surface(hole) for hole in HOLES.get(name, ())]
    made = trimesh.boolean.difference([whole, *holes]) if holes else whole
    made.merge_vertices(digits_vertex=DIGITS)
    made.update_faces(made.nondegenerate_faces())
    return made


def _surface(piece: Solid) -> trimesh.Trimesh:
    T = piece.T_owner_shape.homogeneous
    match piece.shape:
        case Box(size):
            made = box(extents=size, transform=T)
        case Cylinder(radius, length):
            made = cylinder(radius=radius, height=length, sections=SECTIONS, transform=T)
        case other:
            raise TypeError(f"piece {piece.name}: no surface is known for {type(other).__name__}")
    return made.apply_scale(1000)


if __name__ == "__main__":
    part = sys.argv[1]
    surface = mesh(part)
    surface.export(PARTS / part / f"{part}.stl")
    print(f"{len(surface.faces)} triangles, watertight: {surface.is_watertight}")

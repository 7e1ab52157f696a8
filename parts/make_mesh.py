"""Makes the mesh of a part whose surface is the union of the pieces in its part.toml.

Run after a change of part.toml, with the workbench and `manifold3d` installed, from the
repository's root: `python -m parts.make_mesh keyed_cylinder`.
"""

import sys
from pathlib import Path

import trimesh
from trimesh.creation import box, cylinder

from workbench.formats.solids import read_solid
from workbench.formats.toml_keys import read_toml
from workbench.model.geometry import Box, Cylinder, Solid

PARTS = Path(__file__).resolve().parent

SECTIONS = 48
"""Facets around the cylinders: the largest is 0.04 mm away from the circle."""


def mesh(name: str) -> trimesh.Trimesh:
    """The surface of the part in that folder [mm]."""
    pieces = read_toml(PARTS / name / "part.toml").tables("piece")
    return trimesh.boolean.union([_surface(read_solid(piece)) for piece in pieces])


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

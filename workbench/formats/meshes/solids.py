"""Poses and solids as they stand in TOML files: millimetres and degrees."""

import numpy as np
import pinocchio as pin

from workbench.formats.files.toml_keys import Table
from workbench.formats.files.units import UNITS
from workbench.formats.meshes.pieces.convex_pieces import hull_of
from workbench.formats.meshes.reading import read_mesh
from workbench.model.geometry import (
    Box,
    Capsule,
    Cylinder,
    Mesh,
    Shape,
    Solid,
    Sphere,
    pose_from_rpy,
)

SHAPES = ("box", "cylinder", "capsule", "sphere", "mesh")
REACH_MM = 20_000.0
"""Positions further away are refused: somebody wrote other units."""


def read_pose(table: Table) -> pin.SE3:
    """A pose from `position_mm` (3) and `rpy_deg` (3), both zero when not given."""
    xyz = table.numbers("position_mm", 3, [0, 0, 0], low=-REACH_MM, high=REACH_MM) / 1000
    return pose_from_rpy(
        xyz, np.deg2rad(table.numbers("rpy_deg", 3, [0, 0, 0], low=-360, high=360))
    )


def read_solid(table: Table, prefix: str = "") -> Solid:
    """A solid: `name`, `shape` with its measures, pose and colour.

    box: `size_mm` (3); cylinder and capsule: `radius_mm`, `length_mm`; sphere: `radius_mm`;
    mesh: `file` beside the TOML file, `unit`, and `convex` (true: its hull counts as solid).
    """
    name = table.text("name")
    shape = _shape(table)
    T = read_pose(table)
    red, green, blue = table.numbers("colour", 3, [0.7, 0.7, 0.72], low=0, high=1).tolist()
    table.finish()
    return Solid(prefix + name, shape, T, (red, green, blue))


def _shape(table: Table) -> Shape:
    def length(key: str) -> float:
        return table.number(key, low=0.01, high=REACH_MM) / 1000

    match table.text("shape", among=SHAPES):
        case "box":
            return Box(table.numbers("size_mm", 3, low=0.01, high=REACH_MM) / 1000)
        case "cylinder":
            return Cylinder(length("radius_mm"), length("length_mm"))
        case "capsule":
            return Capsule(length("radius_mm"), length("length_mm"))
        case "sphere":
            return Sphere(length("radius_mm"))
        case _:
            return read_mesh_entry(table, convex=table.flag("convex", True))


def read_mesh_entry(table: Table, *, convex: bool) -> Mesh:
    """The mesh that `file` and `unit` of a table name."""
    unit = UNITS[table.text("unit", "mm", among=tuple(UNITS))]
    mesh = read_mesh(table.path.parent / table.text("file"), unit)
    if not convex:
        return mesh
    hull = hull_of(mesh)
    if hull is None:
        raise table.error("file", "its mesh is flat and has no convex hull")
    return hull

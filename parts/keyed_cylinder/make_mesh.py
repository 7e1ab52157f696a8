"""Makes keyed_cylinder.stl: the union of the pieces in part.toml, in millimetres.

Run from the repository's root: `python parts/keyed_cylinder/make_mesh.py`.
"""

from pathlib import Path

import trimesh
from trimesh.creation import box, cylinder
from trimesh.transformations import translation_matrix

SECTIONS = 48
"""Facets around the cylinders."""


def mesh() -> trimesh.Trimesh:
    """The part's surface [mm]."""
    body = cylinder(radius=15, height=80, sections=SECTIONS)
    collar = cylinder(
        radius=19, height=8, sections=SECTIONS, transform=translation_matrix((0, 0, 36))
    )
    key = box(extents=(10, 8, 24), transform=translation_matrix((14, 0, 18)))
    return trimesh.boolean.union([body, collar, key], engine="manifold")


if __name__ == "__main__":
    surface = mesh()
    surface.export(Path(__file__).with_name("keyed_cylinder.stl"))
    print(f"{len(surface.faces)} triangles, watertight: {surface.is_watertight}")

"""Parts that are larger or smaller than their CAD files have them."""

from dataclasses import replace

import numpy as np

from workbench.model.geometry import Mesh, outwards
from workbench.model.part import Part
from workbench.perception.views.surfaces import triangles_of

LEVEL = 0.05
"""See `outwards`: these meshes are exact."""


def sized(part: Part, factor: float, *, about_middle: bool = False) -> Part:
    """The part with a mesh `factor` times as large, about what its symmetry leaves in its place.

    Its convex pieces, symmetry and grasps are as they were.

    Args:
        part: the part.
        factor: no unit.
        about_middle: about the place of these that is nearest to the mesh's middle, so that a pose
            has both meshes in the same place.
    """
    if factor == 1.0:
        return part
    fixed = np.array(part.symmetry.point)
    if about_middle:
        middle = (part.mesh.points.min(axis=0) + part.mesh.points.max(axis=0)) / 2
        fixed = part.symmetry.invariant_point(middle)
    points = fixed + factor * (part.mesh.points - fixed)
    return replace(part, mesh=replace(part.mesh, points=points))


def grown(part: Part, by: float) -> Part:
    """The part with a mesh whose faces lie `by` [m] further outside, inside where that is negative.

    Its convex pieces, symmetry and grasps are as they were.
    """
    if by == 0.0:
        return part
    mesh = triangles_of(part.mesh)
    mesh.merge_vertices()
    triangles = np.asarray(mesh.faces)
    points = mesh.vertices + by * outwards(np.asarray(mesh.vertices), triangles, LEVEL)
    return replace(part, mesh=Mesh(points, triangles))

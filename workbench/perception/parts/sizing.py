"""Parts that are larger or smaller than their CAD files have them."""

from dataclasses import replace

import numpy as np

from workbench.model.part import Part


def sized(part: Part, factor: float) -> Part:
    """The part with a mesh `factor` times as large, about what its symmetry leaves in its place.

    Its convex pieces, symmetry and grasps are as they were.
    """
    if factor == 1.0:
        return part
    fixed = np.array(part.symmetry.point)
    points = fixed + factor * (part.mesh.points - fixed)
    return replace(part, mesh=replace(part.mesh, points=points))

"""Whether what is measured in the place of parts bends as the parts do.

A part of another size than its CAD file has the same directions on its surface.  A camera that
smooths changes them near edges alone.  Another kind may lie within the tolerance, a thick cylinder
where a thin bolt is thought to be, and turn away less.  So the measured normals are fitted to the
predicted ones: the slope is about 1 for the part, and the ratio of both radii for another cylinder.
Noise of the normals leaves the slope as it is.
"""

from collections.abc import Iterable

import numpy as np
from scipy.ndimage import binary_erosion

from workbench.model.geometry import Floats
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.sightings import Sighting, drawing, predicted
from workbench.perception.parts.part_surface import PartSurface

TELLING = 25.0
"""[pixels] Sum of the squared differences of predicted normals from their mean, from which on a
slope is known: flat surfaces show none."""


def measure_slope(
    depth_map: DepthMap,
    surface: PartSurface,
    placed: Iterable[tuple[Floats, Sighting]],
    tolerance: float,
) -> float | None:
    """The slope of measured normals over predicted ones, of all parts together, no unit.

    Args:
        depth_map: the scan.
        surface: the part.
        placed: poses (4, 4) [m] in the scanner's frame, and what the scan says of each.
        tolerance: [m] see `sightings.look`.

    Returns:
        None where the parts show too little that bends.
    """
    it = drawing(depth_map, surface, tolerance)
    squares = products = 0.0
    for pose, sighting in placed:
        first_v, first_u, shown, hit, normals = predicted(it, np.array(pose, order="C"))
        v, u = np.divmod(sighting.explained, depth_map.depth.shape[1])
        inside = np.zeros(shown.shape, np.bool_)
        inside[v - first_v, u - first_u] = True
        # Near edges normals mix both sides.
        inside = binary_erosion(inside, np.ones((3, 3)), iterations=depth_map.mixed)
        j, i = np.nonzero(inside)
        measured, expected = depth_map.normals[j + first_v, i + first_u], normals[hit[j, i]]
        has_normal = measured.any(axis=1)
        if not has_normal.any():
            continue
        differences = expected[has_normal] - expected[has_normal].mean(axis=0)
        squares += float(np.sum(differences**2))
        products += float(np.sum(differences * measured[has_normal]))
    return products / squares if squares >= TELLING else None

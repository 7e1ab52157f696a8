"""Known parts seen from below: what boxes around unknown things have to stay under."""

from dataclasses import dataclass

import numpy as np
import open3d as o3d
from scipy.ndimage import maximum_filter, minimum_filter

from workbench.model.geometry import Floats, Ints
from workbench.perception.views.surfaces import rays_of

BELOW_ALL = -1.0
"""[m] Below any part; rays upwards begin there."""

MOST_CELLS = 100_000
"""Of the grid; things strewn wider than that are boxed without a look at the parts above."""


@dataclass(frozen=True, slots=True, eq=False)
class Roofs:
    """Where known parts begin overhead: places (k, 2) and heights (k,) [m]."""

    places: Floats
    heights: Floats


NO_ROOFS = Roofs(np.empty((0, 2)), np.empty(0))


def roofs_over(
    cells: Ints, tops: Floats, edge: float, parts: o3d.t.geometry.RaycastingScene
) -> Roofs:
    """Undersides of parts, one grid cell wider than they are; of those that no cell reaches into.

    What lies on a part or leans over it holds that down anyway: boxes need not stay clear of it.

    Args:
        cells: (n, 2) whole numbers, of a grid seen from above.
        tops: (n,) height of the highest point in each [m].
        edge: of a grid cell [m].
        parts: that are known, in the frame of the grid.
    """
    if len(cells) == 0:
        return NO_ROOFS
    low = cells.min(axis=0) - 2
    shape = cells.max(axis=0) + 3 - low
    if np.prod(shape.astype(float)) > MOST_CELLS:
        return NO_ROOFS
    own = np.full(shape, -np.inf)
    own[tuple((cells - low).T)] = tops
    places = (np.indices(shape).reshape(2, -1).T + low + 0.5) * edge
    origins = np.column_stack([places, np.full(len(places), BELOW_ALL)])
    directions = np.broadcast_to((0.0, 0.0, 1.0), origins.shape)
    hits = parts.cast_rays(rays_of(origins, directions), nthreads=1)
    heights = BELOW_ALL + hits["t_hit"].numpy().astype(float).reshape(shape)
    whose = hits["geometry_ids"].numpy().reshape(shape)
    heights[np.isin(whose, whose[own > heights])] = np.inf
    heights = minimum_filter(heights, size=3)
    is_roof = (np.isfinite(heights) & (heights >= maximum_filter(own, size=3))).reshape(-1)
    return Roofs(places[is_roof], heights.reshape(-1)[is_roof])

"""Outlines that the background eats: cameras that see near things too small by some pixels.

A pose that is right then has a rim all around through which the scan seems to look; one that is
wrong has it on one side, or is looked through in its middle too.  So the width is measured at the
parts that the first vote finds, and all of them must show it.  Background that lies so close to
something nearer then counts as not measured: it is no evidence against a pose.  Free space seen
further inside stays evidence.
"""

from dataclasses import replace
from math import ceil

import numpy as np
from numba import njit
from scipy.ndimage import distance_transform_cdt

from workbench.model.geometry import Bools, Floats
from workbench.perception.localization.choice import Choice, Compete, PartSearch
from workbench.perception.localization.loosening import measure_explained
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.sightings import Sighting

WIDEST_ERROR = 4
"""[pixels] More is never taken for eaten: it is another part, or another size."""

STRAY = 0.1
"""Share of the pixels at one distance from the outline that the scan may look through anywhere."""

SEEN_THROUGH_SHARE = 0.05
"""Further inside, the scan may look through no more than this share of a part."""

FEWEST_PIXELS = 40
"""[pixels] Measured along the outline, or a pose says nothing."""

FEWEST_PARTS = 2
"""Parts that have to show an eaten outline."""

NOT_EATEN = 0.25
"""[pixels] A width up to it counts as none; larger ones are rounded up, less so much."""


def allow_eaten_outlines(found: list[PartSearch], compete: Compete) -> list[PartSearch]:
    """The searches in a scan without the background that eats outlines, where it does.

    Kept only if more of what lies in the bin is explained; otherwise the searches stay as they are.

    Args:
        found: the searches of all kinds, after the first vote.
        compete: see there.
    """
    widths = [width for search in found for width in _widths(search)]
    if len(widths) < FEWEST_PARTS or min(widths) <= NOT_EATEN:
        return found
    wide = ceil(float(np.median(widths)) - NOT_EATEN)
    grown = [_without_background(search, min(wide, WIDEST_ERROR)) for search in found]
    compete(
        grown,
        [
            [search.hypothesis(pose) for pose in before.choice.poses]
            for search, before in zip(grown, found, strict=True)
        ],
    )
    # Both over what the scan itself shows: without some background, less has to be explained.
    scan = found[0].depth_map
    return grown if measure_explained(grown, scan=scan) > measure_explained(found) else found


def _widths(search: PartSearch) -> list[float]:
    """By how many pixels [px] the outlines of parts are eaten that were taken."""
    columns = search.depth_map.depth.shape[1]
    widths = [eaten_width(part.sighting, columns) for part in search.choice.chosen]
    return [width for width in widths if width is not None]


def _without_background(search: PartSearch, width: int) -> PartSearch:
    depth_map = without_background(search.depth_map, width, search.tolerance)
    coarse_map = depth_map if search.coarse_map is search.depth_map else depth_map.halved()
    return replace(
        search,
        depth_map=depth_map,
        coarse_map=coarse_map,
        eaten=width,
        choice=Choice.empty(depth_map),
    )


def eaten_width(sighting: Sighting, columns: int) -> float | None:
    """By how many pixels [px] a part's outline is eaten in the mean, None where that is unknown.

    Args:
        sighting: what the scan says of a pose.
        columns: of the map that its pixels are in.
    """
    drawn = np.concatenate([sighting.explained, sighting.violated, sighting.hidden])
    if len(drawn) == 0:
        return None
    v, u = np.divmod(drawn, columns)
    picture = np.zeros((int(np.ptp(v)) + 3, int(np.ptp(u)) + 3), np.bool_)
    v, u = v - v.min() + 1, u - u.min() + 1
    picture[v, u] = True
    inwards = np.asarray(distance_transform_cdt(picture, "chessboard"))[v, u]
    explained, violated = len(sighting.explained), len(sighting.violated)
    through = np.bincount(inwards[explained : explained + violated], minlength=WIDEST_ERROR + 3)
    on = np.bincount(inwards[:explained], minlength=WIDEST_ERROR + 3)
    if on[1] + through[1] < FEWEST_PIXELS:
        return None
    width, reach = 0.0, 0
    while reach <= WIDEST_ERROR and through[reach + 1] > STRAY * (
        on[reach + 1] + through[reach + 1]
    ):
        reach += 1
        width += float(through[reach] / (on[reach] + through[reach]))
    inside = through[reach + 1 :].sum(), on[reach + 1 :].sum()
    if inside[1] == 0 or inside[0] > SEEN_THROUGH_SHARE * sum(inside):
        return None
    return width


def without_background(depth_map: DepthMap, width: int, step: float) -> DepthMap:
    """The scan without what lies behind something nearer and close to it.

    Args:
        depth_map: the scan.
        width: [pixels] how close.
        step: [m] behind the plane of the nearer pixel, to count as another surface.
    """
    if width == 0:
        return depth_map
    is_left = ~_is_near_edge(depth_map.rays, depth_map.depth, depth_map.normals, width, step)
    return replace(
        depth_map,
        depth=np.where(is_left, depth_map.depth, 0.0),
        normals=depth_map.normals * is_left[..., None],
        foreground=depth_map.foreground & is_left,
    )


@njit(cache=True)
def _is_near_edge(
    rays: Floats, depth: Floats, normals: Floats, width: int, step: float
) -> Bools:  # pragma: no cover (compiled)
    """Which pixels (rows, columns) are `step` [m] behind the plane of one within `width` pixels."""
    rows, columns = depth.shape
    is_near_edge = np.zeros((rows, columns), np.bool_)
    for v in range(rows):
        for u in range(columns):
            z = depth[v, u]
            if z == 0.0:
                continue
            for b in range(max(v - width, 0), min(v + width + 1, rows)):
                for a in range(max(u - width, 0), min(u + width + 1, columns)):
                    near = depth[b, a]
                    if is_near_edge[v, u] or near == 0.0 or near > z - step:
                        continue
                    off, facing = 0.0, 0.0
                    for k in range(3):
                        n = normals[b, a, k]
                        off += n * (rays[v, u, k] * z - rays[b, a, k] * near)
                        facing += n * n
                    is_near_edge[v, u] = facing == 0.0 or off < -step
    return is_near_edge

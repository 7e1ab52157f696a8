"""Whether a part ends where a pose has it end: around its outline the scan must show that.

A bolt's head is a small disk, and so is every piece of a larger face.  Where another kind's surface
explains all that a pose predicts, it goes on beyond the outline; where the part itself lies, it
does not, unless a neighbour lies flush with it: but that is found as well, most of the time.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Bools, Floats
from workbench.perception.matching.maps import MIXED, DepthMap, Seen
from workbench.perception.matching.sightings import Drawing, drawing, predicted
from workbench.perception.parts.part_surface import PartSurface

BEYOND = 4
"""Distance [pixels] of the checked pixels from the outline.  Nearer pixels are unreliable: window
matching extends near objects over far ones and smooths low edges."""

LEAST_ENDS = 0.9
"""Share of its outline at which a part must end.  Of 288 parts found in simulated piles, as
four kinds of scanner see them, the least had 0.91; two pixels outside it had 0.56."""

MOST_BENT = 0.33
"""Share of its outline at which the surface beyond may fall off evenly: a bolt fits on a cylinder's
side.  Of 415 parts found in simulated piles, as six kinds of scanner see them, one had 0.25, all
others less; bolts on cylinders, in three scans by time of flight, 0.38 to 0.66."""

FEWEST_PIXELS = 12
"""[pixels] With less of the outline seen, nothing is said."""

STEEP, EVEN = 2.0, 0.6
"""Depth over width up to which a surface bends away, and the share of it in one pixel: no step."""

ALIKE_NORMALS = 0.95
"""Cosine between normals above which what lies beyond may be the same surface."""


def has_visible_boundary(
    depth_map: DepthMap,
    surface: PartSurface,
    pose: Floats,
    tolerance: float,
    is_other: np.ndarray,
    *,
    least: float = LEAST_ENDS,
    most_bent: float = MOST_BENT,
    eaten: int = 0,
) -> bool:
    """Whether a part ends along its outline, as far as that is seen.

    Also where fewer than `FEWEST_PIXELS` pixels of the outline are seen.

    Where nothing is measured beyond, or something lies in front, or another part found, nothing is
    known.

    Args:
        depth_map: the scan.
        surface: the part.
        pose: (4, 4) [m] in the scanner's frame.
        tolerance: [m] see `sightings.look`.
        is_other: (pixels,) which of them other parts found explain.
        least: share of the outline at which the part must end.
        most_bent: share of it at which the surface may go on evenly, straight or bent.
        eaten: [pixels] of the part along its outline that show the background.
    """
    others = is_other.reshape(depth_map.depth.shape)
    beyond = BEYOND + depth_map.mixed - MIXED
    ends, goes_on, bends = _outline(
        drawing(depth_map, surface, tolerance), np.ascontiguousarray(pose), others, eaten, beyond
    )
    seen = ends + goes_on
    return seen < FEWEST_PIXELS or (ends >= least * seen and bends + goes_on <= most_bent * seen)


@njit(cache=True)
def _outline(
    drawing: Drawing, T: Floats, is_other: Bools, eaten: int, reach: int
) -> tuple[int, int, int]:  # pragma: no cover (compiled)
    """Pixels along the outline: where the part ends, its surface goes on, or it bends away there.

    Where a surface bends away no step shows that the part ends; these are among the first.
    """
    seen, tolerance = drawing.seen, drawing.tolerance
    first_v, first_u, shown, hit, normals = predicted(drawing, T)
    high, wide = shown.shape
    ends, goes_on, bends = 0, 0, 0
    for j in range(high):
        for i in range(wide):
            if shown[j, i] == np.inf:
                continue
            v, u = first_v + j, first_u + i
            n = normals[hit[j, i]]
            if seen.depth[v, u] == 0.0 or not seen.foreground[v, u]:
                continue
            here = seen.depth[v, u]
            along = (
                n[0] * seen.rays[v, u, 0] + n[1] * seen.rays[v, u, 1] + n[2] * seen.rays[v, u, 2]
            )
            if abs(along * (here - shown[j, i])) > tolerance:
                continue
            for side in range(4):
                dj, di = (0, 1, 0, -1)[side], (1, 0, -1, 0)[side]
                outside = (j + (eaten + 1) * dj, i + (eaten + 1) * di)
                beyond = (j + (eaten + reach) * dj, i + (eaten + reach) * di)
                if eaten > 0 and not _is_drawn(shown, (j + eaten * dj, i + eaten * di)):
                    continue
                if _is_drawn(shown, outside) or _is_drawn(shown, beyond):
                    continue
                b, a = first_v + beyond[0], first_u + beyond[1]
                if not (0 <= b < seen.depth.shape[0] and 0 <= a < seen.depth.shape[1]):
                    continue
                there = seen.depth[b, a]
                if there == 0.0 or is_other[b, a]:
                    continue
                off, agreement = 0.0, 0.0
                for k in range(3):
                    off += n[k] * (seen.rays[b, a, k] * there - seen.rays[v, u, k] * here)
                    agreement += n[k] * seen.normals[b, a, k]
                if seen.foreground[b, a] and abs(off) <= tolerance and agreement > ALIKE_NORMALS:
                    goes_on += 1
                elif there >= here - tolerance or not seen.foreground[b, a]:
                    ends += 1
                    bends += _bends_away(seen, (v, u), (dj, di), eaten + reach)
    return ends, goes_on, bends


@njit(cache=True)
def _bends_away(
    seen: Seen, at: tuple[int, int], step: tuple[int, int], count: int
) -> bool:  # pragma: no cover (compiled)
    """Whether the surface at a pixel falls off evenly, without a step, over a count of pixels."""
    depth = seen.depth[at[0], at[1]]
    total = seen.depth[at[0] + count * step[0], at[1] + count * step[1]] - depth
    if not seen.foreground[at[0] + count * step[0], at[1] + count * step[1]]:
        return False
    if abs(total) > STEEP * count * depth / seen.focal:
        return False
    before = depth
    for k in range(1, count + 1):
        here = seen.depth[at[0] + k * step[0], at[1] + k * step[1]]
        if here == 0.0 or abs(here - before) > EVEN * abs(total):
            return False
        before = here
    return True


@njit(cache=True)
def _is_drawn(shown: Floats, at: tuple[int, int]) -> bool:  # pragma: no cover (compiled)
    """Whether the picture of the part covers that place."""
    j, i = at
    is_in_picture = 0 <= j < shown.shape[0] and 0 <= i < shown.shape[1]
    return is_in_picture and shown[j, i] < np.inf

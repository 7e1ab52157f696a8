"""Larger tolerances for scans with correlated errors, or parts that differ from their CAD file.

The noise of a scan sets the tolerance between scan and part.  Cameras that smooth over many pixels,
and parts some per cent off their CAD size, exceed it.  When the found parts explain little of the
bin's content, the same poses are compared again with several times the tolerance.  The result is
used if it explains much of the content, and far more than before.  The scan's curvature must also
agree with that of the parts, which excludes wrong parts.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.model.geometry import Bools
from workbench.perception.localization.choice import Choice, Compete, Hypothesis, PartSearch
from workbench.perception.localization.hypotheses import select_distinct
from workbench.perception.localization.judging import JudgedChoice, judge_choices
from workbench.perception.localization.settling import refine_poses
from workbench.perception.matching.bending import measure_slope
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.sightings import look

DOUBTFUL = 0.5
"""Where parts explain less than this share of what lies in the bin, they are asked again."""

LOOSER_BY = 3.0
"""The tolerance then, over what it was."""

LOOSE_SPREAD, LOOSE_MOST = 0.15, 1.5
"""Deviation of a part's points over that tolerance, as most of them still lie closely on it; and
[nat] by which a pixel may speak for it in the mean."""

LOOSE_ENDS = 0.75
"""Share of its outline at which a part must end then: an outline that is off lies on the next."""

EXPLAINED, TIMES = 0.25, 1.5
"""They must explain this share then, and this many times what they did."""

LEAST_SLOPE = 0.65
"""Slope of the directions measured over those of the parts of a kind, see `bending`, below which
another kind lies there.  Parts that are a tenth larger than their CAD file have 0.85, and 0.75 as
cameras by time of flight smooth them; bolts on cylinders of twice their radius have 0.5."""

STEP_LENGTHS = (0.02, 0.01, 0.005)
"""Lengths of the steps by which poses are brought to rest, over the diameter."""


def relax_tolerance(found: list[PartSearch], compete: Compete) -> list[PartSearch]:
    """The searches with a relaxed tolerance where the accepted parts explain less than half.

    The result is used only if it explains much more.  The search for a kind stays as it is if the
    scan contradicts its curvature.

    Args:
        found: the searches of all kinds, after the first vote.
        compete: see there.
    """
    strict = measure_explained(found)
    if strict >= DOUBTFUL:
        return found
    loose = [_loosen(search) for search in found]
    compete(
        loose,
        [_restart(search, before) for search, before in zip(loose, found, strict=True)],
    )
    loose = [
        search if _bends_alike(search) else before
        for search, before in zip(loose, found, strict=True)
    ]
    now = measure_explained(loose)
    return loose if now >= max(EXPLAINED, TIMES * strict) else found


def measure_explained(
    found: Sequence[PartSearch],
    judged: Sequence[JudgedChoice] | None = None,
    *,
    scan: DepthMap | None = None,
) -> float:
    """Share of what lies in the bin that the parts which stand explain, 0..1.

    Args:
        found: the searches of all kinds.
        judged: which parts stand, if that is known.
        scan: what shows what lies there, if not the first search's map.
    """
    if not found:
        return 1.0
    judged = judge_choices(found) if judged is None else judged
    depth_map = found[0].depth_map if scan is None else scan
    covered: Bools = np.zeros(depth_map.depth.size, np.bool_)
    for search, standing in zip(found, judged, strict=True):
        for part in standing.choice.chosen:
            seen = part.sighting
            if search.depth_map is not depth_map:
                seen = look(depth_map, search.surface, part.pose, search.tolerance)
            covered[seen.explained] = True
    lying = depth_map.foreground.ravel()
    return float(np.count_nonzero(covered & lying)) / max(int(np.count_nonzero(lying)), 1)


def _loosen(search: PartSearch) -> PartSearch:
    tolerance = LOOSER_BY * search.tolerance
    return replace(
        search,
        tolerance=tolerance,
        spread=max(search.spread, LOOSE_SPREAD * tolerance),
        least_ends=LOOSE_ENDS,
        most=LOOSE_MOST,
        is_loose=True,
        choice=Choice.empty(search.depth_map),
    )


def _bends_alike(search: PartSearch) -> bool:
    """Whether the scan bends as the parts of a kind that were taken; also where nothing bends."""
    placed = [(part.pose, part.sighting) for part in search.choice.chosen]
    slope = measure_slope(search.depth_map, search.surface, placed, search.tolerance)
    return slope is None or slope >= LEAST_SLOPE


def _restart(search: PartSearch, before: PartSearch) -> list[Hypothesis]:
    """What was taken and what was rejected before, brought to rest anew."""
    surface, poses = search.surface, before.choice.poses
    if len(poses) == 0:
        return []
    # With so much tolerance those that lie as one come to rest in one place.
    apart = select_distinct(surface, poses, np.arange(len(poses)))
    steps = tuple(step * surface.diameter for step in STEP_LENGTHS)
    rested = refine_poses(search.coarse_map, surface, poses[apart], search.tolerance, steps)
    rested = rested[search.are_possible(rested)]
    return [search.hypothesis(pose) for pose in rested]

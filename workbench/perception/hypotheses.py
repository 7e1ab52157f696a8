"""Poses worth a closer look: voted for, fitted, and thinned out under near-symmetry."""

import numpy as np

from workbench.model.geometry import Floats
from workbench.perception.maps import DepthMap
from workbench.perception.oriented import OrientedPoints
from workbench.perception.part_surface import PartSurface
from workbench.perception.point_pairs import vote
from workbench.perception.poses import distinct
from workbench.perception.registration import quick_scores, refine

SPACING = 0.055
"""Distance between the points of the scan that vote, over the part's diameter."""

REFERENCES, FEWEST_REFERENCES, PEAKS = 0.3, 100, 6
"""Share of the points that collect votes, their least number, and poses that each proposes."""

MOST_VOTED, MOST_FITTED, MOST_VARIANTS = 60, 30, 3
"""Poses that are followed after voting and after the first fit, and near-symmetric ones each."""

NEARBY, MOST_NEARBY = 0.4, 8
"""Within this share of the diameter no more are followed, so that one clear part does not
crowd out the others."""

WIDE_GATES = np.array([4.0, 4.0, 3.0, 3.0, 2.0, 2.0])
NARROW_GATES = np.array([4.0, 3.0, 2.0, 2.0, 1.5, 1.5])
"""Largest distances of pairs in the iterations of the two fits, over the tolerance."""

SAME_DISTANCE, SAME_ANGLE = 0.08, float(np.deg2rad(15.0))
"""Poses nearer than this share of the diameter and this angle are one."""


def voted_poses(maps: DepthMap, surface: PartSurface, tolerance: float, *, seed: int) -> Floats:
    """Poses (k, 4, 4) that point pairs of the scan vote for, best first.

    Of poses that are one under near-symmetry the best is returned.
    """
    chosen = maps.foreground & maps.normals.any(axis=-1)
    if not chosen.any():
        return np.empty((0, 4, 4))
    seen = OrientedPoints((maps.rays * maps.depth[..., None])[chosen], maps.normals[chosen])
    seen = seen.thinned(SPACING * surface.diameter)
    count = max(FEWEST_REFERENCES, round(REFERENCES * len(seen)))
    references = np.random.default_rng(seed).permutation(len(seen))[:count]
    poses, _ = vote(surface.table, seen, references, PEAKS)
    values = _values(maps, poses, surface.table.model, 2 * tolerance)
    kept = distinct(
        poses,
        np.argsort(-values, kind="stable"),
        surface.symmetry.motions,
        surface.middle,
        distance=SAME_DISTANCE * surface.diameter,
        angle=SAME_ANGLE,
        most=MOST_VOTED,
        nearby=NEARBY * surface.diameter,
        most_nearby=MOST_NEARBY,
    )
    return poses[kept]


def fitted_poses(maps: DepthMap, surface: PartSurface, poses: Floats, tolerance: float) -> Floats:
    """The poses (k, 4, 4) after a first fit, best first, those that became one only once."""
    poses, errors = refine(maps, poses, surface.coarse, WIDE_GATES * tolerance)
    poses = poses[np.isfinite(errors)]
    values = _values(maps, poses, surface.coarse, tolerance)
    kept = distinct(
        poses,
        np.argsort(-values, kind="stable"),
        surface.symmetry.motions,
        surface.middle,
        distance=SAME_DISTANCE * surface.diameter,
        angle=SAME_ANGLE,
        most=MOST_FITTED,
    )
    return poses[kept]


def variants(maps: DepthMap, surface: PartSurface, pose: Floats, tolerance: float) -> Floats:
    """The best few near-symmetric poses (k, 4, 4) of one pose, each fitted closely."""
    poses = pose @ surface.symmetry.motions
    values = _values(maps, poses, surface.fine, tolerance)
    kept = distinct(
        poses,
        np.argsort(-values, kind="stable"),
        surface.stated,
        surface.middle,
        distance=np.inf,
        angle=SAME_ANGLE,
        most=MOST_VARIANTS,
    )
    return refine(maps, poses[kept], surface.fine, NARROW_GATES * tolerance)[0]


def _values(maps: DepthMap, poses: Floats, model: OrientedPoints, tolerance: float) -> Floats:
    """How good the poses (k, 4, 4) look at a quick glance, (k,), at most 1."""
    support, violation, occlusion = quick_scores(maps, poses, model, tolerance).T
    return support - violation - 0.2 * occlusion

"""Poses worth a closer look: voted for, fitted, and thinned out under near-symmetry."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from workbench.model.geometry import Floats
from workbench.perception.localization.settling import refine_poses
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.poses import distinct
from workbench.perception.matching.registration import quick_scores, refine
from workbench.perception.matching.sightings import closeness, tally
from workbench.perception.parts.oriented import OrientedPoints
from workbench.perception.parts.part_surface import PartSurface
from workbench.perception.parts.point_pairs import vote

SPACING = 0.055
"""Distance between the points of the scan that vote, over the part's diameter."""

MOST_REFERENCES = 5000
"""Points that collect votes: a part that is small in its bin makes a hundred thousand points, and
each proposes up to 80 poses."""

MOST_SCORED, GLANCED = 2500, 4
"""Voted poses that are scored with all points of the part; of more the best by every fourth."""

MOST_VOTED, MOST_FITTED = 60, 30
"""Poses that are followed after voting and after the first fit."""

MOST_UNFITTED = 10
"""The best voted poses are also followed as they are: the fit may lead narrow surfaces astray."""

NEARBY, MOST_NEARBY = 0.4, 8
"""Within this share of the diameter no more are followed, so that one clear part does not
crowd out the others."""

WIDE_GATES = np.array([4.0, 4.0, 3.0, 3.0, 2.0, 2.0])
"""Largest distances of pairs in the iterations of the first fit, over the tolerance."""

WIDE_STEPS = (0.06, 0.03, 0.015)
"""Lengths of the steps by which they are brought to rest, over the diameter."""

SAME_DISTANCE, SAME_ANGLE = 0.08, float(np.deg2rad(15.0))
"""Poses nearer than this share of the diameter and this angle are one."""


class Effort(NamedTuple):
    """How thorough a vote is.

    `references` is the share of the points that collect votes, `fewest` their least number,
    `peaks` how many poses each of them proposes.
    """

    references: float
    fewest: int
    peaks: int


EFFORTS = (Effort(0.1, 80, 6), Effort(0.5, 150, 24), Effort(1.0, 300, 80))
"""Three rounds vote with rising effort: clear parts first, hidden ones with patience."""

LITTLE_EFFORT = Effort(0.0, 80, 6)
FEW_VOTED, FEW_FITTED = 30, 12
"""What is enough to tell which of many kinds may lie there, and the poses that are followed."""


def find_coarse_poses(
    coarse_map: DepthMap,
    surface: PartSurface,
    tolerance: float,
    is_possible: Callable[[Floats], np.ndarray],
    *,
    seed: int,
) -> Floats:
    """The best poses (k, 4, 4) [m] by the votes of a few points; see `find_hypotheses`."""
    voted = _vote(coarse_map, surface, tolerance, is_possible, LITTLE_EFFORT, (seed, len(EFFORTS)))
    return _fit(coarse_map, surface, voted[:FEW_VOTED], tolerance)[:FEW_FITTED]


def find_hypotheses(
    depth_map: DepthMap,
    coarse_map: DepthMap,
    surface: PartSurface,
    tolerance: float,
    is_possible: Callable[[Floats], np.ndarray],
    effort: Effort,
    *,
    seed: tuple[int, int],
) -> tuple[Floats, Floats]:
    """Refined poses inside the bin, best first, and the fitted poses outside of it.

    Args:
        depth_map: the scan; its foreground is what votes.
        coarse_map: the same, coarser.
        surface: the part.
        tolerance: [m] see `sightings.look`.
        is_possible: which of poses (k, 4, 4) may be at all, (k,).
        effort: see there.
        seed: of the choice of points that vote.

    Returns:
        Poses (k, 4, 4) brought to rest, and (m, 4, 4).
    """
    voted = _vote(depth_map, surface, tolerance, is_possible, effort, seed)
    fitted = _fit(depth_map, surface, voted, tolerance)
    poses = np.concatenate([fitted, voted[:MOST_UNFITTED]])
    possible = is_possible(poses)
    return _refine_best_symmetric(coarse_map, surface, poses[possible], tolerance), poses[~possible]


def _vote(
    depth_map: DepthMap,
    surface: PartSurface,
    tolerance: float,
    is_possible: Callable[[Floats], np.ndarray],
    effort: Effort,
    seed: tuple[int, int],
) -> Floats:
    """Poses (k, 4, 4) that point pairs vote for, best first.

    Of poses that are one under near-symmetry the best is returned.
    """
    chosen = depth_map.foreground & depth_map.normals.any(axis=-1)
    if not chosen.any():
        return np.empty((0, 4, 4))
    seen = OrientedPoints(
        (depth_map.rays * depth_map.depth[..., None])[chosen], depth_map.normals[chosen]
    )
    seen = seen.thinned(SPACING * surface.diameter)
    count = min(MOST_REFERENCES, max(effort.fewest, round(effort.references * len(seen))))
    references = np.random.default_rng(seed).permutation(len(seen))[:count]
    poses, _ = vote(surface.table, seen, references, effort.peaks)
    poses = poses[is_possible(poses)]
    model = surface.table.model
    if len(poses) > MOST_SCORED:
        glances = _values(depth_map, poses, model[np.arange(0, len(model), GLANCED)], 2 * tolerance)
        poses = poses[np.argsort(-glances, kind="stable")[:MOST_SCORED]]
    values = _values(depth_map, poses, model, 2 * tolerance)
    return _best(surface, poses, values, most=MOST_VOTED, most_nearby=MOST_NEARBY)


def _fit(depth_map: DepthMap, surface: PartSurface, poses: Floats, tolerance: float) -> Floats:
    """The poses (k, 4, 4) after a first fit, best first; where several became one, the best."""
    poses, errors = refine(depth_map, poses, surface.coarse, WIDE_GATES * tolerance)
    poses = poses[np.isfinite(errors)]
    values = _values(depth_map, poses, surface.coarse, tolerance)
    return _best(surface, poses, values, most=MOST_FITTED)


def _best(
    surface: PartSurface, poses: Floats, values: Floats, *, most: int, most_nearby: int = 0
) -> Floats:
    """The best by value of the poses (k, 4, 4), one of those that near-symmetry makes alike."""
    kept = distinct(
        poses,
        np.argsort(-values, kind="stable"),
        surface.symmetry.motions,
        surface.middle,
        distance=SAME_DISTANCE * surface.diameter,
        angle=SAME_ANGLE,
        most=most,
        nearby=(NEARBY * surface.diameter, most_nearby),
    )
    return poses[kept]


def select_distinct(
    surface: PartSurface,
    poses: Floats,
    order: np.ndarray,
    *,
    distance: float = SAME_DISTANCE,
    most: int | None = None,
) -> np.ndarray:
    """The indices (m,) of poses (k, 4, 4) [m] that differ by more than a stated symmetry.

    Args:
        surface: the part.
        poses: of which each stands for those after it that are the same.
        order: indices (n,) of the poses, the best first.
        distance: over the diameter, up to which poses can be the same.
        most: indices that are enough; None: no limit.
    """
    return distinct(
        poses,
        order,
        surface.stated,
        surface.fixed,
        distance=distance * surface.diameter,
        angle=np.pi if surface.is_ball else SAME_ANGLE,
        most=len(poses) if most is None else most,
    )


def _refine_best_symmetric(
    coarse_map: DepthMap, surface: PartSurface, poses: Floats, tolerance: float
) -> Floats:
    """The best near-symmetric pose of each of the poses (k, 4, 4), settled.

    Of turns about an axis one stands for all: they are distinguished at the close look.
    """
    motions = surface.symmetry.motions
    if surface.symmetry.axis is not None:
        motions = motions[:: len(surface.symmetry.turns)]
    variants = (poses[:, None] @ motions).reshape(-1, 4, 4)
    values = closeness(tally(coarse_map, surface, variants, 2 * tolerance))
    best = values.reshape(len(poses), len(motions)).argmax(axis=1)
    steps = tuple(step * surface.diameter for step in WIDE_STEPS)
    return refine_poses(coarse_map, surface, poses @ motions[best], 2 * tolerance, steps)


def _values(depth_map: DepthMap, poses: Floats, model: OrientedPoints, tolerance: float) -> Floats:
    """How good the poses (k, 4, 4) look at a quick glance, (k,), at most 1."""
    support, violation, occlusion = quick_scores(depth_map, poses, model, tolerance).T
    return support - violation - 0.2 * occlusion

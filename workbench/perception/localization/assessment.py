"""A last close look at a part found: polish its pose, and see how sure it is."""

from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats, own
from workbench.perception.localization.alternatives import is_better, turn_by_outline, weights
from workbench.perception.localization.certainty import count_shared
from workbench.perception.localization.hypotheses import SAME_ANGLE, select_distinct
from workbench.perception.localization.settling import is_constrained, refine_poses, roll_error
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.sightings import (
    Sighting,
    closeness,
    gains,
    look,
    tally,
)
from workbench.perception.parts.part_surface import PartSurface

RIVALS = 4
"""Near-symmetric poses that are polished before the best of them is taken."""

MOST_SHARING = 8
"""Near-symmetric poses that may share the chance of the one found."""

SHARING_TURNS = 2
"""Turns about the axis that are brought to rest before the roll counts as known."""

SLIDES = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Shifts along the axis, over the tolerance, the best of which each of them gets first."""

MOST_SWITCHES = 3
"""How often a pose gives way to one that its near-symmetries lead to."""

CLOSE_RIVAL = 0.02
"""Rivals that are worse by more than this share after a rough polish get no fine one."""

STEPS_OVER_TOLERANCE = (2.0, 1.0, 0.5, 0.25, 0.125)
"""Lengths of the polishing steps."""

FAR_BEHIND, TURNED_FAR_BEHIND = 0.2, 0.4
"""A rival that is seen by this share less well than the pose found needs no polish; and one that is
turned about the axis, which may have to be shifted along a thread."""

ROLL_ERROR = float(np.deg2rad(1.0))
"""[rad] A roll whose standard error is larger counts as unknown."""

OUTLINE_ERROR = float(np.deg2rad(2.25))
"""[rad] And one that the outline alone holds, where pixels are coarse over a part."""


@dataclass(frozen=True, slots=True, eq=False)
class Assessment:
    """A pose in the scanner's frame with its quality.

    Attributes:
        pose: the pose (4, 4) [m].
        gap: lead in the explained share of the surface over the best different pose of the same
            object; None: the part has no near-symmetry.
        roll_known: False: rotating the part about its axis changes nothing that the scan shows.
        is_constrained: False: another small motion changes nothing that the scan shows.
        share: chance (0..1) of this rotation among those that fit nearly as well.  For a lying cup
            it is about 0.5, since the scan does not show which end is open.
        by_colour: see `Detection`.
        outline_error: standard error of a roll that only the outline shows [rad]; otherwise 0.
    """

    pose: Floats
    sighting: Sighting
    gap: float | None
    roll_known: bool
    is_constrained: bool
    share: float
    by_colour: bool | None = None
    outline_error: float = 0.0

    def __post_init__(self) -> None:
        own(self, "pose")


def assess(
    depth_map: DepthMap, coarse_map: DepthMap, surface: PartSurface, pose: Floats, tolerance: float
) -> Assessment:
    """Look at all near-symmetric poses of one that was found, and take the best.

    Args:
        depth_map: the scan.
        coarse_map: the same, coarser.
        surface: the part.
        pose: (4, 4) found for it.
        tolerance: [m] see `look`.
    """
    motions = surface.symmetry.motions
    pose = _best_of(depth_map, coarse_map, surface, pose @ motions, tolerance)
    others = _select_different(coarse_map, surface, pose, tolerance)
    for _ in range(MOST_SWITCHES):
        tallies = tally(depth_map, surface, pose @ motions[[0, *others[:RIVALS]]], tolerance)
        best = int(closeness(tallies).argmax())
        if best == 0:
            break
        # Turns of a pose that lies well are seen better than those of one that did not.
        rival = pose @ motions[others[[best - 1]]]
        pose = _best_of(depth_map, coarse_map, surface, rival, tolerance)
        others = _select_different(coarse_map, surface, pose, tolerance)
    is_turn = _are_turns(surface, others)
    turns = others[is_turn][:RIVALS]
    sighting = look(depth_map, surface, pose, tolerance)
    own, *rest = tally(depth_map, surface, pose @ motions[[0, *others[:1], *turns]], tolerance)
    gap = None
    if rest:
        gap = max(0.0, float(gains(own[None])[0] - gains(np.array(rest)).max()))
        gap /= max(sighting.shown, 1)
    turned = np.array(rest[1:]).reshape(-1, 4)
    is_known, outline_error = len(turns) == 0, 0.0
    if not is_known and len(sighting.explained) > 0 and is_better(own, turned):
        is_known = _do_faces_hold_roll(depth_map, surface, pose, sighting, tolerance)
        if not is_known:
            at_outline, error = turn_by_outline(depth_map, surface, pose, tolerance)
            is_known = error < OUTLINE_ERROR
            if is_known:
                pose, outline_error = at_outline, error
                sighting = look(depth_map, surface, pose, tolerance)
                own = tally(depth_map, surface, pose[None], tolerance)[0]
    is_round = surface.symmetry.axis is not None
    # Where the roll is not known, all turns about the axis are one pose.
    flips = others[~is_turn][: 1 if is_round else MOST_SHARING]
    value = float(closeness(own[None])[0])
    least = (1.0 - FAR_BEHIND) * value
    sharing = _tally_refined(depth_map, surface, pose, pose @ motions[flips], tolerance, least)
    if len(turns) > 0 and is_known:
        # A screw that is turned by a face of its head and shifted along its thread looks the same.
        nearest = _slide_along_axis(
            depth_map, surface, pose @ motions[turns[:SHARING_TURNS]], tolerance
        )
        least = (1.0 - TURNED_FAR_BEHIND) * value
        rested = _tally_refined(depth_map, surface, pose, nearest, tolerance, least)
        is_known = is_better(own, rested)
        sharing = np.concatenate([sharing, rested, turned[SHARING_TURNS:]])
    return Assessment(
        pose=pose,
        sighting=sighting,
        gap=gap,
        roll_known=is_known,
        is_constrained=is_constrained(depth_map, surface, pose, tolerance),
        share=1.0 / (1.0 + float(weights(own, sharing).sum())),
        outline_error=outline_error,
    )


def _are_turns(surface: PartSurface, which: np.ndarray) -> np.ndarray:
    """Which of the near-symmetries (k,) are turns about the axis, up to a stated symmetry (k,)."""
    if surface.symmetry.axis is None:
        return np.zeros(len(which), np.bool_)
    axis = surface.symmetry.axis[1]
    moved = surface.symmetry.motions[which][:, None, :3, :3] @ surface.stated[:, :3, :3] @ axis
    return (moved @ axis > np.cos(SAME_ANGLE)).any(axis=1)


def _select_different(
    coarse_map: DepthMap, surface: PartSurface, pose: Floats, tolerance: float
) -> np.ndarray:
    """Which near-symmetries (k,) make a different pose of one, the best at a glance first."""
    motions = surface.symmetry.motions
    others = pose @ motions
    order = np.argsort(-closeness(tally(coarse_map, surface, others, tolerance)), kind="stable")
    both = np.concatenate([pose[None], others])
    return _select_apart(surface, both, np.concatenate([[0], order + 1]))[1:] - 1


def _select_apart(surface: PartSurface, poses: Floats, order: np.ndarray) -> np.ndarray:
    """Which of the poses (k, 4, 4), the first in the order (k,) first, are turned otherwise."""
    return select_distinct(surface, poses, order, distance=np.inf)


def _slide_along_axis(
    depth_map: DepthMap, surface: PartSurface, poses: Floats, tolerance: float
) -> Floats:
    """The poses (k, 4, 4), each shifted along its near-symmetry axis to where it is seen best."""
    assert surface.symmetry.axis is not None
    slides = np.tile(np.eye(4), (len(SLIDES), 1, 1))
    slides[:, :3, 3] = np.outer(SLIDES, tolerance * surface.symmetry.axis[1])
    tried = (poses[:, None] @ slides).reshape(-1, 4, 4)
    seen = closeness(tally(depth_map, surface, tried, tolerance)).reshape(len(poses), -1)
    return poses @ slides[seen.argmax(axis=1)]


def _tally_refined(
    depth_map: DepthMap,
    surface: PartSurface,
    pose: Floats,
    rivals: Floats,
    tolerance: float,
    least: float,
) -> Floats:
    """The tallies (m, 4) [px] of rivals (k, 4, 4) of a pose after their refinement.

    Rivals with a closeness below `least` [px] are left out, and those that end where others do.
    """
    rivals = rivals[closeness(tally(depth_map, surface, rivals, tolerance)) >= least]
    rivals = refine_at_full_resolution(depth_map, surface, rivals, tolerance)
    both = np.concatenate([pose[None], rivals])
    rivals = both[_select_apart(surface, both, np.arange(len(both)))[1:]]
    return tally(depth_map, surface, rivals, tolerance)


def refine_at_full_resolution(
    depth_map: DepthMap, surface: PartSurface, poses: Floats, tolerance: float
) -> Floats:
    """Poses (k, 4, 4) [m] brought to rest, each where it is seen best; see `refine_poses`."""
    steps = tuple(step * tolerance for step in STEPS_OVER_TOLERANCE)
    return refine_poses(depth_map, surface, poses, tolerance, steps)


def _do_faces_hold_roll(
    depth_map: DepthMap, surface: PartSurface, pose: Floats, sighting: Sighting, tolerance: float
) -> bool:
    """Whether the points on a part's faces say how far it is turned about its axis."""
    alike = count_shared(sighting, depth_map.depth.shape[1])
    deviation = float(np.sqrt(alike * np.mean(sighting.off**2)))
    return roll_error(depth_map, surface, pose, tolerance, deviation) < ROLL_ERROR


def _best_of(
    depth_map: DepthMap, coarse_map: DepthMap, surface: PartSurface, poses: Floats, tolerance: float
) -> Floats:
    """The best of the poses (k, 4, 4), after polishing the few that look best."""
    glances = closeness(tally(coarse_map, surface, poses, tolerance))
    kept = select_distinct(surface, poses, np.argsort(-glances, kind="stable"), most=RIVALS)
    steps = tuple(step * tolerance for step in STEPS_OVER_TOLERANCE)
    rough = refine_poses(coarse_map, surface, poses[kept], tolerance, steps[:3])
    values = closeness(tally(depth_map, surface, rough, tolerance))
    close = values >= values.max() - CLOSE_RIVAL * abs(values.max())
    polished = refine_poses(depth_map, surface, rough[close], tolerance, steps)
    return polished[int(np.argmax(closeness(tally(depth_map, surface, polished, tolerance))))]

"""Parts of another size than their CAD file, or with a surface that stands off it all around.

Where the floor shows that parts are not as their CAD file (`floor_contact`), both changes are
tried.  The one counts that the scan meets better, outlines included, if it does so about as well as
the CAD file.  The search goes on with that surface.
"""

from dataclasses import replace

import numpy as np

from workbench.model.geometry import Floats
from workbench.model.scan import Objection, OffsetCheck, ScaleCheck
from workbench.perception.localization.assessment import refine_at_full_resolution
from workbench.perception.localization.cad_scale import (
    fit_to_size,
    fit_to_surface,
    scale_check,
)
from workbench.perception.localization.choice import Choice, Compete, Hypothesis, PartSearch
from workbench.perception.localization.floor_contact import agree, shown_offsets, shown_scales
from workbench.perception.localization.judging import JudgedChoice
from workbench.perception.localization.loosening import measure_explained
from workbench.perception.localization.settling import refine_poses
from workbench.perception.matching.poses import distinct
from workbench.perception.matching.sightings import closeness, look, tally
from workbench.perception.parts.growing import grow_surface
from workbench.perception.parts.part_surface import prepare, resize_surface

MOST_OFF, MOST_SCALED = 0.04, 0.15
"""How far off a surface may lie, over the diameter, if the part does not say; and by which share it
may be larger or smaller."""

FEWEST_PARTS, FEWEST_TRIED = 3, 2
"""Parts that have to show a change before it is reported, and before it is tried."""

SAME_OFFSET, SAME_SCALE = 0.0003, 0.01
"""Changes that parts show are the same within this [m], and within this share."""

NOTICED, REPORTED = 0.5, 0.0003
"""Offsets are noticed at once that are larger than this share of the tolerance, up to which parts
are found as they are; and in the end those larger than this [m]."""

SHARED_OFF, SHARED_SCALE = 0.0001, 0.003
"""Deviation of the floor that all parts share [m], and what it makes of a size."""

MOST_TRIED, LEAST_DISTANCE = 6, 0.3
"""Poses of a kind that are fitted with another surface, no two closer than this share of the
diameter."""

LEAST_SCORE = 0.5
"""Poses that explain a smaller share of what they show say nothing of the surface."""

STEP_LENGTHS = (0.03, 0.015)
"""Lengths of the steps by which poses are brought to rest roughly, over the diameter."""

LEAST_CLOSE = 0.97
"""The scan must meet the changed surface this well at least, over the CAD file: some cameras see
outlines too small, some too large."""

LEAST_EXPLAINED = 0.5
"""Share of what lies in the bin that parts of a changed surface must explain."""


def allow_changes(found: list[PartSearch], compete: Compete) -> list[PartSearch]:
    """The searches with the surfaces that the scan shows, where CAD files have others.

    Args:
        found: the searches of all kinds, after a vote.
        compete: see there.
    """
    changed = [_change_surface(search) for search in found]
    if all(search is before for search, before in zip(changed, found, strict=True)):
        return found
    changed = [replace(search, choice=Choice.empty(search.depth_map)) for search in changed]
    compete(
        changed, [_restart(search, before) for search, before in zip(changed, found, strict=True)]
    )
    # Changed far enough, a part fits on many others: it must explain most of what lies there.
    least = max(LEAST_EXPLAINED, measure_explained(found))
    return changed if measure_explained(changed) >= least else found


def report_shape(
    search: PartSearch, standing: JudgedChoice
) -> tuple[PartSearch, JudgedChoice, tuple[ScaleCheck, ...], tuple[OffsetCheck, ...]]:
    """The search and its poses fitted to the surface that the scan shows, and what that is.

    Args:
        search: for a part as the CAD file has it, or changed already.
        standing: what was found.
    """
    name, poses = search.part.name, [chosen.pose for chosen in standing.choice.chosen]
    scale = None
    if search.grown == 0.0:
        scale = scale_check(name, search.depth_map, search.surface, poses, search.tolerance)
    if scale is not None and scale.is_off:
        scale = replace(scale, ratio=round(scale.ratio * search.scaled, 4))
        search, standing = fit_to_size(search, standing, scale.ratio / search.scaled)
        return search, standing, (scale,), ()
    if not search.is_loose and search.grown == 0.0 and search.scaled == 1.0:
        shown = agree(shown_offsets(search, poses), SAME_OFFSET, FEWEST_PARTS)
        if shown is not None and abs(shown.value) > REPORTED:
            changed = find_change(search, np.array(poses[:MOST_TRIED]), REPORTED)
            if changed is not search:
                moved = _keep_seen_in_place(changed, np.array(poses))
                search, standing = fit_to_surface(changed, standing, moved)
                poses = [chosen.pose for chosen in standing.choice.chosen]
    if search.scaled != 1.0:
        return _report_scale(search, standing, scale)
    scales = () if scale is None else (scale,)
    shown = agree(shown_offsets(search, poses), SAME_OFFSET, FEWEST_PARTS)
    if search.grown == 0.0 or shown is None:
        return search, standing, scales, ()
    deviation = float(np.hypot(shown.deviation, SHARED_OFF))
    said = OffsetCheck(name, round(shown.value, 5), round(deviation, 5), shown.count)
    return search, standing, scales, (said,)


def _report_scale(
    search: PartSearch, standing: JudgedChoice, fitted: ScaleCheck | None
) -> tuple[PartSearch, JudgedChoice, tuple[ScaleCheck, ...], tuple[OffsetCheck, ...]]:
    """The same for a part of another size, whose surface may tell no scale by itself."""
    poses = [chosen.pose for chosen in standing.choice.chosen]
    shown = agree(shown_scales(search, poses), SAME_SCALE, FEWEST_PARTS)
    if shown is not None:
        said = ScaleCheck(search.part.name, round(shown.value, 4), SHARED_SCALE, shown.count)
        search, standing = fit_to_size(search, standing, said.ratio / search.scaled)
    elif fitted is not None:
        said = replace(fitted, ratio=round(fitted.ratio * search.scaled, 4))
    else:
        return search, standing, (), ()
    return search, standing, (said,), ()


def _change_surface(search: PartSearch) -> PartSearch:
    """The search for a part with the surface that the scan shows, if that is another one."""
    if search.is_loose or search.grown != 0.0 or search.scaled != 1.0:
        return search
    poses = _select_tried(search)
    offsets = shown_offsets(search, poses)
    if len(offsets) < FEWEST_TRIED or abs(np.median(offsets)) < NOTICED * search.tolerance:
        return search
    return find_change(search, poses, NOTICED * search.tolerance)


def find_change(search: PartSearch, poses: Floats, least: float) -> PartSearch:
    """The search with a grown or resized surface, if poses (k, 4, 4) [m] show one; else as it is.

    Args:
        search: for the part as its CAD file has it.
        poses: each fitted to what is seen, in the scanner's frame.
        least: [m] by which the surface has to move somewhere.
    """
    best, close = search, LEAST_CLOSE * _closeness(search, _refine(search, poses))
    for trial in (_grow(search, poses), _resize(search, poses)):
        if trial is None:
            continue
        larger = abs(trial.scaled - 1.0) * search.surface.diameter / 2
        if max(abs(trial.grown), larger) < least:
            continue
        now = _closeness(trial, _refine(trial, poses))
        if now > close:
            best, close = trial, now
    return best


def _grow(search: PartSearch, poses: Floats) -> PartSearch | None:
    """The search with a surface that stands off as parts show it, None where they do not agree."""
    stated = search.part.tolerance
    most = MOST_OFF * search.surface.diameter if stated is None else stated
    if most == 0.0:
        return None

    def grow(offset: float) -> PartSearch:
        offset = float(np.clip(offset, -most, most))
        return replace(search, surface=grow_surface(search.surface, offset), grown=offset)

    # A first guess brings the poses to rest, by which it is read again.
    trial = grow(float(np.median(shown_offsets(search, poses))))
    shown = agree(shown_offsets(trial, _select_good(trial, poses)), SAME_OFFSET, FEWEST_TRIED)
    return None if shown is None or abs(shown.value) < REPORTED else grow(shown.value)


def _resize(search: PartSearch, poses: Floats) -> PartSearch | None:
    """The search with a surface as large as parts show it, None where they do not agree."""

    def scale(size: float) -> PartSearch:
        size = float(np.clip(size, 1.0 - MOST_SCALED, 1.0 + MOST_SCALED))
        return replace(search, surface=resize_surface(search.surface, size), scaled=size)

    trial = scale(float(np.median(shown_scales(search, poses))))
    shown = agree(shown_scales(trial, _select_good(trial, poses)), SAME_SCALE, FEWEST_TRIED)
    return None if shown is None or abs(shown.value - 1.0) < SAME_SCALE else scale(shown.value)


def _select_good(search: PartSearch, poses: Floats) -> list[Floats]:
    """Of the poses (k, 4, 4), brought to rest, those (4, 4) that explain much of what they show."""
    return [pose for pose in _refine(search, poses) if search.look(pose).score >= LEAST_SCORE]


def _closeness(search: PartSearch, poses: Floats) -> float:
    """How well the scan meets poses (k, 4, 4) [px], together."""
    tallies = tally(search.depth_map, search.surface, poses, search.tolerance)
    return float(np.maximum(closeness(tallies), 0.0).sum())


def _select_tried(search: PartSearch) -> Floats:
    """The poses (k, 4, 4) that may be parts of which the other side is off."""
    outside = [each for each in search.choice.rejected if each.reason is Objection.OUTSIDE]
    outside.sort(key=lambda each: -each.sighting.score)
    poses = np.array([each.pose for each in (*search.choice.chosen, *outside)])
    if len(poses) == 0:
        return np.empty((0, 4, 4))
    surface = search.surface
    return poses[
        distinct(
            poses, np.arange(len(poses)), surface.stated, surface.fixed,
            distance=LEAST_DISTANCE * surface.diameter, angle=np.pi, most=MOST_TRIED,
        )
    ]  # fmt: skip


def _refine(search: PartSearch, poses: Floats) -> Floats:
    """Poses (k, 4, 4) of the part as its CAD file has it, brought to rest with the surface."""
    poses = _refine_roughly(search, poses)
    return refine_at_full_resolution(search.depth_map, search.surface, poses, search.tolerance)


def _refine_roughly(search: PartSearch, poses: Floats) -> Floats:
    steps = tuple(step * search.surface.diameter for step in STEP_LENGTHS)
    return refine_poses(
        search.coarse_map,
        search.surface,
        _keep_seen_in_place(search, poses),
        2 * search.tolerance,
        steps,
    )


def _keep_seen_in_place(search: PartSearch, poses: Floats) -> Floats:
    """The poses (k, 4, 4) moved so that what is seen of a part of another size stays in place."""
    if search.scaled == 1.0:
        return poses
    depth_map, surface = search.depth_map, prepare(search.part)
    seen = depth_map.rays.reshape(-1, 3) * depth_map.depth.reshape(-1, 1)
    moved = np.array(poses)
    for pose in moved:
        explained = look(depth_map, surface, pose, search.tolerance).explained
        if len(explained) > 0:
            arm = seen[explained].mean(axis=0) - pose[:3, :3] @ surface.fixed - pose[:3, 3]
            pose[:3, 3] += (1.0 - search.scaled) * arm
    return moved


def _restart(search: PartSearch, before: PartSearch) -> list[Hypothesis]:
    """What was taken and what was rejected before, brought to rest with the surface of now."""
    poses = before.choice.poses
    if len(poses) == 0:
        return []
    if search.surface is not before.surface:
        poses = _refine_roughly(search, poses)
    poses = poses[search.are_possible(poses)]
    return [search.hypothesis(pose) for pose in poses]

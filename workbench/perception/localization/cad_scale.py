"""Whether parts are as large as their CAD file has them: a fit with a scale, over all detections.

A point-to-plane fit (Chen & Medioni 1992) with eight unknowns: a pose, a scale about the part's
middle, and one distance by which the whole surface seems to be off along its normals.  The latter
takes what scanners do to curved surfaces (they average neighbours, and have near things grow); so
the radius alone of something round says nothing: lengths between faces and edges of different
directions do.  Pose and distance are eliminated for each detection; what is left of the scale is
put together by the weights of its information.  Where the part has another size than its CAD file,
its poses are fitted in that size.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_erosion

from workbench.model.geometry import Floats, frozen
from workbench.model.scan import Objection, ScaleCheck
from workbench.perception.localization.assessment import refine_at_full_resolution
from workbench.perception.localization.choice import PartSearch, enough
from workbench.perception.localization.judging import JudgedChoice, without
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.registration import move, transformed
from workbench.perception.matching.sightings import AGREEING, Drawing, predicted
from workbench.perception.parts.part_surface import PartSurface, resize_surface

FIT_STEPS = 6
"""Of the fit: each draws the part anew."""

RIM = 2
"""Pixels around the part's picture that do not count: there both sides of an edge are mixed."""

FEWEST_POINTS = 30

WIDE_TOLERANCES, WIDE_STEPS = 2.5, 4
"""Tolerances within which points count in the first steps where too few parts tell a scale: of a
part that is found at one end the other one is off by the whole difference."""

SHARED = 4.0
"""Points that share their errors: this many count as one."""

OUTLIER_DEVIATIONS = 6.0
"""Robust deviations beyond which a point says nothing."""

LEAST_NOISE = 1e-6
"""[m] Noise is never taken for less."""

LARGEST_STEP = 0.02
"""By which the scale changes in one step."""

OPEN = 1e-4
"""Share of the mean information that unknowns get which the points leave open."""

TELLING = 0.05
"""Standard deviation of a scale above which a detection says nothing of it."""

FEWEST_DETECTIONS = 3
"""Detections that have to tell a scale."""

SHARED_OFF = 1.5e-5
"""Common error [m] of all points along the direction that shows the scale.  A part with only short
visible lengths gives little information, however many points it has."""

LEAST_DEVIATION = 0.001
"""Standard deviation of a scale, at least: no scanner is calibrated better."""


def scale_check(
    name: str, depth_map: DepthMap, surface: PartSurface, poses: Sequence[Floats], tolerance: float
) -> ScaleCheck | None:
    """How large a kind of part is in the scan over its CAD file, None where that is unknown.

    Args:
        name: of the part.
        depth_map: the scan.
        surface: the part.
        poses: (4, 4) [m] of those found, in the scanner's frame.
        tolerance: [m] see `sightings.look`.
    """
    for reach in (1.0, WIDE_TOLERANCES):
        fits = [_fit(depth_map, surface, pose, tolerance, reach) for pose in poses]
        sure = [fit for fit in fits if fit is not None and np.hypot(*fit[1:]) <= TELLING]
        if len(sure) >= FEWEST_DETECTIONS or len(poses) < FEWEST_DETECTIONS:
            break
    if len(sure) < FEWEST_DETECTIONS:
        return None
    scales, deviations, shared = np.array(sure).T
    weights = 1.0 / (deviations**2 + shared**2)
    mean = float(weights @ scales / weights.sum())
    # Where they differ by more than they say, all of them are less sure (Birge 1932).
    birge = float(deviations**-2.0 @ (scales - mean) ** 2) / (len(sure) - 1)
    own = max(birge, 1.0) * float(weights**2 @ deviations**2) / weights.sum() ** 2
    common = float(weights @ shared) / weights.sum()
    deviation = np.sqrt(own + common**2 + LEAST_DEVIATION**2)
    # Rounded, so that it is the same on any machine.
    return ScaleCheck(name, round(1.0 + mean, 4), round(float(deviation), 4), len(sure))


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Where the surface is predicted (n, 3) [m], its normals there, how far off the scan is [m]."""

    points: Floats
    normals: Floats
    off: Floats


def _fit(
    depth_map: DepthMap, surface: PartSurface, pose: Floats, tolerance: float, reach: float
) -> tuple[float, float, float] | None:
    """By which share one part is larger than its CAD file, and the standard deviations of that.

    The first is its own, the second what all parts of the scan share.  In the first steps points
    count up to `reach` tolerances away.
    """
    T, scale, radius = np.array(pose), 0.0, surface.diameter / 2
    deviation = shared = np.inf
    for step in range(FIT_STEPS):
        wide = tolerance * (reach if step < WIDE_STEPS else 1.0)
        pairs = _pair(depth_map, surface, T, 1.0 + scale, wide)
        if len(pairs.off) < FEWEST_POINTS:
            return None
        centre = transformed(T, surface.middle)
        arms = (pairs.points - np.array(centre)) / radius
        rows = np.column_stack([
            np.cross(arms, pairs.normals), pairs.normals, np.ones(len(arms)),
            np.sum(arms * pairs.normals, axis=1),
        ])  # fmt: skip
        # The robust deviation is not asked before the pose is nearly right.
        spread = max(1.48 * float(np.median(np.abs(pairs.off))), LEAST_NOISE)
        gate = wide if step < 2 else min(wide, OUTLIER_DEVIATIONS * spread)
        weights = np.clip(1.0 - (pairs.off / gate) ** 2, 0.0, None) ** 2  # Tukey's biweight
        if not weights.any():
            return None
        A, b = rows.T @ (weights[:, None] * rows), rows.T @ (weights * pairs.off)
        others = A[:7, :7] + OPEN * np.trace(A[:6, :6]) / 6 * np.eye(7)
        taken = np.linalg.solve(others, A[:7, 7])
        information = float(A[7, 7] - A[:7, 7] @ taken)
        if not information > 1e-9 * A[7, 7]:
            return None
        change = (b[7] - b[:7] @ taken) / information
        change = float(np.clip(change, -LARGEST_STEP * radius, LARGEST_STEP * radius))
        x = np.linalg.solve(others, b[:7] - A[:7, 7] * change)
        move(T, centre, x[:6], radius)
        scale += change / radius
        variance = max(float(weights @ pairs.off**2) / float(weights.sum()), LEAST_NOISE**2)
        deviation = float(np.sqrt(SHARED * variance / information)) / radius
        shared = SHARED_OFF * float(np.sqrt(weights.sum() / information)) / radius
    return scale, deviation, shared


def _pair(
    depth_map: DepthMap, surface: PartSurface, T: Floats, scale: float, tolerance: float
) -> _Pairs:
    """The pixels that a part of another size explains at `T` (4, 4), but those at its rim."""
    seen, middle = depth_map.seen, surface.middle
    drawn = frozen(middle + scale * (surface.vertices - middle))
    drawing = Drawing(seen, drawn, surface.triangles, surface.is_closed, tolerance)
    first_v, first_u, shown, hit, normals = predicted(drawing, np.array(T, order="C"))
    j, i = np.nonzero(binary_erosion(np.isfinite(shown), iterations=RIM))
    v, u = first_v + j, first_u + i
    n, rays, depth = normals[hit[j, i]], seen.rays[v, u], seen.depth[v, u]
    off = np.sum(n * rays, axis=1) * (depth - shown[j, i])
    agrees = np.sum(n * seen.normals[v, u], axis=1) > AGREEING
    on = (depth > 0) & (np.abs(off) <= tolerance) & seen.foreground[v, u] & agrees
    # Predicted points, since the noise of measured points would look like size.
    return _Pairs((rays * shown[j, i][:, None])[on], n[on], off[on])


def fit_to_size(
    search: PartSearch, standing: JudgedChoice, size: float
) -> tuple[PartSearch, JudgedChoice]:
    """The search for a part of another size than its CAD file, and its poses fitted to that.

    A wrong CAD file fits at one of its ends only, so the poses are off by up to the difference.

    Args:
        search: by the CAD file as it is.
        standing: what was found.
        size: of the part over its CAD file, no unit.
    """
    # About its middle: whoever draws the CAD file as it is at such a pose has it around the part.
    fixed = search.surface.fixed
    surface = resize_surface(search.surface, size)
    seen = search.depth_map.rays.reshape(-1, 3) * search.depth_map.depth.reshape(-1, 1)
    before = standing.choice.chosen
    poses = np.array([assessed.pose for assessed in before])
    for pose, assessed in zip(poses, before, strict=True):
        # What is seen of it stays in place at first.
        middle = seen[assessed.sighting.explained].mean(axis=0)
        pose[:3, 3] += (1.0 - size) * (middle - pose[:3, :3] @ fixed - pose[:3, 3])
    resized = replace(search, surface=surface, scaled=search.scaled * size)
    return fit_to_surface(resized, standing, poses)


def fit_to_surface(
    search: PartSearch, standing: JudgedChoice, poses: Floats
) -> tuple[PartSearch, JudgedChoice]:
    """A search with a new surface, and what was found fitted to it; what is not seen enough falls.

    Args:
        search: with that surface.
        standing: what was found with another one.
        poses: (k, 4, 4) [m] of that, near to where the new surface fits.
    """
    surface = search.surface
    poses = refine_at_full_resolution(search.depth_map, surface, poses, search.tolerance)
    sightings = [search.look(pose) for pose in poses]
    fallen = {
        i: Objection.TOO_LITTLE
        for i, sighting in enumerate(sightings)
        if len(sighting.explained) < enough(sighting)
    }
    chosen = [
        replace(assessed, pose=pose, sighting=sighting)
        for assessed, pose, sighting in zip(standing.choice.chosen, poses, sightings, strict=True)
    ]
    ratios = tuple(ratio for i, ratio in enumerate(standing.ratios) if i not in fallen)
    return search, JudgedChoice(without(replace(standing.choice, chosen=chosen), fallen), ratios)

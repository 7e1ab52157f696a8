"""Balls of a known size in a cloud, and three of them as the reference plate.

Each point lies one radius in front of the centre of its ball, along its normal.  So every point
votes for the place one radius behind it: the votes of a ball fall together, those of planes and
edges do not (Hough's transform for spheres of one size).
"""

from itertools import permutations
from typing import Any

import numpy as np
import open3d as o3d
from scipy.spatial import cKDTree  # pyright: ignore[reportAttributeAccessIssue]

from workbench.model.calibration import BallPlate, PlateObservation
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, sampled
from workbench.model.scan import Scan

GRAIN = 0.12
"""Distance of the points that vote, over the radius."""

SAME_BALL_WITHIN = 0.2
"""Votes this near to each other, over the radius, are for one ball."""

FEWEST_POINTS = 25
"""Points on a ball that is believed."""

MOST_BALLS = 24
"""Balls that are checked, those with the most votes."""

BALL_SURFACE_SHARE = 0.08
"""Distance from a ball's surface, over the radius, within which points belong to it."""

LEAST_VARIANCE = 0.015
"""Least variance of the normals on a ball; some 0.04 on the half that is seen."""

DISTANCE_TOLERANCE = 0.003
"""[m] By which distances between balls may differ from those of the plate."""

FARTHEST_POINT = 20.0
"""[m] Points further from the scanner along one of its axes are outliers."""

MOST_KEPT = 15_000
"""Points of a scan that an observation stores."""


def find_balls(points: Floats, radius: float) -> tuple[Floats, Floats]:
    """Centres of all balls of a radius that a cloud shows.

    Args:
        points: (n, 3) [m], scanner frame, the scanner at 0.
        radius: [m].

    Returns:
        Centres (k, 3) [m], those with the most points first, and the RMS distance of their points
        from the surface (k,) [m].
    """
    points = points[np.abs(points).max(axis=1) <= FARTHEST_POINT]
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud = cloud.voxel_down_sample(GRAIN * radius)
    seen = np.asarray(cloud.points)
    if len(seen) < FEWEST_POINTS:
        return np.empty((0, 3)), np.empty(0)
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(0.5 * radius, 30))
    cloud.orient_normals_towards_camera_location(np.zeros(3))
    normals = np.asarray(cloud.normals)
    votes = seen - radius * normals
    tree, votes_tree = cKDTree(seen), cKDTree(votes)
    counts = votes_tree.query_ball_point(votes, SAME_BALL_WITHIN * radius, return_length=True)
    centres: list[Floats] = []
    spreads: list[float] = []
    numbers: list[int] = []
    for number in np.argsort(-counts, kind="stable"):
        if counts[number] < FEWEST_POINTS or len(centres) >= MOST_BALLS:
            break
        start = np.median(
            votes[votes_tree.query_ball_point(votes[number], SAME_BALL_WITHIN * radius)], axis=0
        )
        if any(np.linalg.norm(start - centre) < radius for centre in centres):
            continue
        fit = _fit(tree, normals, start, radius)
        if fit is not None and all(np.linalg.norm(fit[0] - c) > radius for c in centres):
            centres.append(fit[0])
            spreads.append(fit[1])
            numbers.append(fit[2])
    order = np.argsort([-n for n in numbers], kind="stable")
    return np.array(centres).reshape(-1, 3)[order], np.array(spreads)[order]


def _fit(
    tree: Any, normals: Floats, centre: Floats, radius: float
) -> tuple[Floats, float, int] | None:
    """The centre by least squares, the spread [m] and the number of its points, if it is a ball."""
    for gate in (
        4 * BALL_SURFACE_SHARE,
        2 * BALL_SURFACE_SHARE,
        BALL_SURFACE_SHARE,
        BALL_SURFACE_SHARE,
    ):
        shell = np.array(tree.query_ball_point(centre, (1 + gate) * radius), dtype=np.int64)
        offsets = tree.data[shell] - centre
        lengths = np.linalg.norm(offsets, axis=1)
        # What is further from the scanner than the centre is no part of the surface it sees.
        facing = -offsets @ centre > 0.1 * radius * np.linalg.norm(centre)
        on = (np.abs(lengths - radius) < gate * radius) & facing
        if np.count_nonzero(on) < FEWEST_POINTS:
            return None
        rows = -offsets[on] / lengths[on, None]
        move = np.linalg.lstsq(rows, radius - lengths[on], rcond=1e-6)[0]
        if not np.linalg.norm(move) < radius:
            return None
        centre = centre + move
    # Normals of a ball differ in all directions, those of a cylinder are across its axis.
    if np.linalg.eigvalsh(np.cov(normals[shell[on]].T))[0] < LEAST_VARIANCE:
        return None
    left = lengths[on] - radius
    return centre, float(np.sqrt(np.mean(left**2))), len(rows)


def choose_balls(centres: Floats, lengths: Floats, count: int) -> tuple[float, tuple[int, ...]]:
    """Those balls whose distances fit best.

    Args:
        centres: (k, 3) [m] of all balls found.
        lengths: (1,) or (3,) [m] from each to the next, and from the last to the first.
        count: how many balls there should be.

    Returns:
        By how much the worst distance is off [m], and the balls in order; infinite and none where
        there are too few.
    """
    best: tuple[float, tuple[int, ...]] = np.inf, ()
    for chosen in permutations(range(len(centres)), count):
        balls = centres[list(chosen)]
        apart = np.linalg.norm(balls - np.roll(balls, -1, axis=0), axis=1)
        off = float(np.abs(apart - lengths).max())
        if off < best[0]:
            best = off, chosen
    return best


def sight_plate(scan: Scan, plate: BallPlate, name: str, arm: str, q: Floats) -> PlateObservation:
    """The plate in a scan.

    Args:
        scan: organised or not; the robot, the bin and anything else may be in it.
        plate: what to look for.
        name: of the observation, for people.
        arm: that holds the plate, at `q` (n,) [rad].
        q: see there.

    Raises:
        InputError: fewer than three balls are seen, or none that are as far from each other.
    """
    centres, spreads = find_balls(scan.points, plate.radius)
    off, chosen = choose_balls(centres, plate.sides, 3)
    if off > DISTANCE_TOLERANCE:
        near = f"; the nearest three are {off * 1000:.1f} mm off" if chosen else ""
        raise InputError(
            f"{name}: the plate is not seen: {len(centres)} balls of {plate.radius * 2000:g} mm "
            f"are found, three at distances of "
            f"{', '.join(f'{side * 1000:g}' for side in plate.sides)} mm are needed{near}"
        )
    three = list(chosen)
    spread = float(np.sqrt(np.mean(spreads[three] ** 2)))
    points = sampled(scan.points, MOST_KEPT)
    return PlateObservation(name, arm, q, plate, centres[three], spread, points)

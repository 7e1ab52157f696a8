"""Finding the parts in a scan: hypotheses by voting, fits, and verification by ray-casting."""

from collections.abc import Callable
from itertools import count

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled
from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.scan import Detection, Scan
from workbench.perception.assessment import Assessment, assess
from workbench.perception.choice import Hypothesis, choose, is_in_bin
from workbench.perception.hypotheses import fitted_poses, variants, voted_poses
from workbench.perception.maps import DepthMap, make_map
from workbench.perception.part_surface import PartSurface, prepare
from workbench.perception.sightings import look

PIXELS_ACROSS = 70
"""Pixels of the working map over the part's diameter, if the scan is dense enough."""

TOLERANCE = 0.015
"""Distance from the predicted surface within which a point is explained, over the diameter."""

TOLERANCE_OVER_NOISE = 4.0
"""But not less than this many standard deviations of the scanner's noise."""


def _silent(done: float, note: str) -> None:
    pass


def localize(
    scan: Scan,
    part: Part,
    cell: Cell,
    *,
    seed: int,
    report: Callable[[float, str], None] = _silent,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Detection, ...]:
    """All instances of a part in the cell's bin, as far as the scan shows them.

    Point-pair features of the scan inside the bin vote for poses; they are fitted by
    projective ICP, collapsed and expanded again under the near-symmetries of the mesh, and
    verified by casting the scanner's rays onto the mesh: what the scan measures must lie where
    the pose predicts it, and the scan must not look through the part.  The best are taken one
    after the other.

    Args:
        scan: organised or not.
        part: what to look for.
        cell: its bin says where; its scanner how noisy the points are.
        seed: of the choice of points that vote.
        report: is told the share done, 0..1, and what is being done.
        cancelled: is asked now and then whether to give up.

    Returns:
        The detections, best score first; empty when nothing is found.

    Raises:
        JobCancelled: `cancelled` said so.
        InputError: the part's mesh has no surface.
    """

    def step(done: float, note: str) -> None:
        if cancelled():
            raise JobCancelled("the search for parts was cancelled")
        report(done, note)

    step(0.0, f"prepare {part.name}")
    surface = prepare(part)
    step(0.2, "map the scan")
    maps = make_map(scan, cell.bin, size=surface.diameter, pitch=surface.diameter / PIXELS_ACROSS)
    if maps is None:
        return ()
    tolerance = _tolerance(surface, cell, scan)
    step(0.3, "vote")
    poses = voted_poses(maps, surface, tolerance, seed=seed)
    step(0.5, "fit")
    poses = fitted_poses(maps, surface, poses, tolerance)
    T_scanner_bin = scan.T_world_scanner.inverse() * cell.bin.T_world_bin
    poses = np.array([p for p in poses if is_in_bin(surface, p, T_scanner_bin, cell.bin)])
    step(0.6, "verify")
    hypotheses = _hypotheses(maps, surface, poses, tolerance)
    looks = count(1)

    def assess_next(pose: Floats) -> Assessment:
        number = next(looks)
        step(1.0 - 0.3 * 0.8**number, f"look closely at place {number}")
        return assess(maps, surface, pose, tolerance)

    found = choose(maps, surface, hypotheses, assess_next)
    detections = (_detection(part, scan, assessed) for assessed in found)
    return tuple(sorted(detections, key=lambda detection: -detection.score))


def _tolerance(surface: PartSurface, cell: Cell, scan: Scan) -> float:
    distance = np.linalg.norm(scan.T_world_scanner.translation - cell.bin.T_world_bin.translation)
    noise = cell.scanner.depth_noise * float(distance) ** 2
    return max(TOLERANCE * surface.diameter, TOLERANCE_OVER_NOISE * noise)


def _hypotheses(
    maps: DepthMap, surface: PartSurface, poses: np.ndarray, tolerance: float
) -> list[Hypothesis]:
    """The poses' near-symmetric variants with their sightings."""
    if len(poses) == 0:
        return []
    fitted = np.concatenate([variants(maps, surface, pose, tolerance) for pose in poses])
    sightings = look(maps, surface, fitted, tolerance)
    return [Hypothesis(pose, seen) for pose, seen in zip(fitted, sightings, strict=True)]


def _detection(part: Part, scan: Scan, assessed: Assessment) -> Detection:
    sighting = assessed.sighting
    return Detection(
        part=part.name,
        T_world_part=scan.T_world_scanner * pin.SE3(assessed.pose),
        score=sighting.score,
        visible=sighting.visible,
        gap=assessed.gap,
        residual=float(np.sqrt(np.mean(sighting.off**2))),
        roll_known=assessed.roll_known,
    )

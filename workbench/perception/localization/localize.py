"""Finding the parts in a scan: hypotheses by voting, fits, and verification by drawing them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.ndimage import binary_dilation

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled
from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.scan import Detection, Discarded, LocalizationResult, Objection, Scan
from workbench.perception.localization.assessment import Assessment, assess
from workbench.perception.localization.choice import (
    LEAST_PIXELS,
    Choice,
    Hypothesis,
    Rejection,
    are_in_bin,
    choose,
)
from workbench.perception.localization.hypotheses import (
    EFFORTS,
    SAME_ANGLE,
    SAME_DISTANCE,
    hypotheses,
)
from workbench.perception.localization.maps import DepthMap, make_map
from workbench.perception.localization.outline import ends_there
from workbench.perception.localization.part_surface import PartSurface, prepare
from workbench.perception.localization.poses import distinct
from workbench.perception.localization.sightings import look
from workbench.perception.scene.scene_model import SceneModel, scene_model

PIXELS_ACROSS = 70
"""Pixels of the working map over the part's diameter, if the scan is dense enough."""

FEWEST_ACROSS = 20
"""Pixels over the diameter with which a glance can be taken."""

TOLERANCE = 0.015
"""Distance from the predicted surface within which a point is explained, over the diameter."""

TOLERANCE_OVER_NOISE = 4.0
"""But not less than this many standard deviations of the noise that the scan shows."""

RIM = 2
"""Pixels around a part found that do not vote for others: edges, where normals are mixed."""

MOST_DISCARDED = 20
"""Discarded hypotheses that are told of, the best first."""


@dataclass(frozen=True, slots=True, eq=False)
class Searched:
    """What the search for one part brought.

    `gains` [m2]: for each detection the area seen that speaks for it, less what speaks against.
    """

    findings: LocalizationResult
    surface: PartSurface
    gains: tuple[float, ...]


def _silent(done: float, note: str) -> None:
    pass


def localize(
    scan: Scan,
    part: Part,
    cell: Cell,
    *,
    seed: int,
    detail: float = 1.0,
    report: Callable[[float, str], None] = _silent,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Detection, ...]:
    """The detections of `searched`: all instances of a part in the cell's bin."""
    brought = searched(
        scan, part, cell, seed=seed, detail=detail, report=report, cancelled=cancelled
    )
    return brought.findings.detections


def searched(
    scan: Scan,
    part: Part,
    cell: Cell,
    *,
    seed: int,
    detail: float = 1.0,
    scene: SceneModel | None = None,
    report: Callable[[float, str], None] = _silent,
    cancelled: Callable[[], bool] = lambda: False,
) -> Searched:
    """All instances of a part in the cell's bin, as far as the scan shows them.

    Point-pair features of the scan inside the bin vote for poses; they are fitted by projective
    ICP, and verified by drawing the mesh: what the scan measures must lie where the pose predicts
    it, and the scan must not look through the part.  The best are taken one after the other, each
    after a close look at the poses that its near-symmetries could be mistaken for.  Then what is
    left of the scan votes again, more thoroughly, until nothing more is found.

    Args:
        scan: organised or not.
        part: what to look for.
        cell: its bin says where; its scanner how noisy the points are, if the scan does not.
        seed: of the choice of points that vote.
        detail: how fine the scan is looked at; 1 is usual.
        scene: what surrounds the parts, if that is known already.
        report: is told the share done, 0..1, and what is being done.
        cancelled: is asked now and then whether to give up.

    Returns:
        The detections, best score first, none when nothing is found; the `MOST_DISCARDED` best
        of the poses that were looked at and not taken; and how much speaks for each detection.

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
    scene = scene or scene_model(scan, cell)
    pitch = surface.diameter / (PIXELS_ACROSS * detail)
    maps = make_map(scan, cell.bin, scene.bin, size=surface.diameter, pitch=pitch)
    if maps is None:
        return Searched(LocalizationResult(()), surface, ())
    glance, tolerance = _coarser(maps, surface), _tolerance(surface, cell, scan, scene)
    T_scanner_bin = scan.T_world_scanner.inverse() * cell.bin.T_world_bin
    steps = count()

    def next_step(note: str) -> None:
        step(1.0 - 0.7 * 0.9 ** next(steps), note)

    def assess_next(pose: Floats) -> Assessment:
        next_step("look closely")
        return assess(maps, glance, surface, pose, tolerance)

    def seen(pose: Floats) -> Hypothesis:
        return Hypothesis(pose, look(maps, surface, pose, tolerance))

    def are_possible(poses: Floats) -> np.ndarray:
        return are_in_bin(surface, poses, T_scanner_bin, cell.bin, scene.bin)

    choice = Choice(np.full(maps.depth.size, -1), [], [])
    for number, effort in enumerate(EFFORTS):
        next_step("vote")
        free = _without_claimed(maps, choice)
        if np.count_nonzero(free.foreground) < LEAST_PIXELS:
            break
        poses, outside = hypotheses(
            free,
            _coarser(free, surface),
            surface,
            tolerance,
            are_possible,
            effort,
            seed=(seed, number),
        )
        choose(choice, surface, [seen(pose) for pose in poses], assess_next)
        choice.rejected += [
            Rejection(one.pose, one.sighting, Objection.OUTSIDE) for one in map(seen, outside)
        ]
    choice = _ending(choice, maps, surface, tolerance)
    order = sorted(range(len(choice.chosen)), key=lambda k: -choice.chosen[k].sighting.score)
    gains = tuple(choice.chosen[k].sighting.gain * maps.pitch**2 for k in order)
    return Searched(_findings(part, surface, scan, choice, order), surface, gains)


def _coarser(maps: DepthMap, surface: PartSurface) -> DepthMap:
    """What a glance is taken at: half the map's resolution, where that still shows the part."""
    return maps.halved() if surface.diameter / maps.pitch >= 2 * FEWEST_ACROSS else maps


def _without_claimed(maps: DepthMap, choice: Choice) -> DepthMap:
    """The scan without what the chosen parts explain, and without the rims around it."""
    claimed = (choice.claimed >= 0).reshape(maps.depth.shape)
    if not claimed.any():
        return maps
    rims: Any = binary_dilation(claimed, iterations=RIM)
    return replace(maps, foreground=maps.foreground & ~rims)


def _ending(choice: Choice, maps: DepthMap, surface: PartSurface, tolerance: float) -> Choice:
    """The choice without those that do not end where they should: pieces of something else."""
    others = choice.claimed
    kept = [
        ends_there(maps, surface, one.pose, tolerance, (others >= 0) & (others != k))
        for k, one in enumerate(choice.chosen)
    ]
    place = np.where(kept, np.cumsum(kept) - 1, -1)
    rejected = [
        one if one.rival is None else replace(one, rival=int(place[one.rival]))
        for one in choice.rejected
        if one.rival is None or kept[one.rival]
    ]
    rejected += [
        Rejection(one.pose, one.sighting, Objection.GOES_ON)
        for one, is_kept in zip(choice.chosen, kept, strict=True)
        if not is_kept
    ]
    chosen = [one for one, is_kept in zip(choice.chosen, kept, strict=True) if is_kept]
    claimed = np.where(others >= 0, np.append(place, -1)[others], -1)
    return Choice(claimed, chosen, rejected)


def _tolerance(surface: PartSurface, cell: Cell, scan: Scan, scene: SceneModel) -> float:
    distance = np.linalg.norm(scan.T_world_scanner.translation - cell.bin.T_world_bin.translation)
    noise = scene.sensor.deviation(float(distance), otherwise=cell.scanner.depth_noise)
    return max(TOLERANCE * surface.diameter, TOLERANCE_OVER_NOISE * noise)


def _findings(
    part: Part, surface: PartSurface, scan: Scan, choice: Choice, order: Sequence[int]
) -> LocalizationResult:
    """The chosen ones as detections in that order, and the best of those rejected."""
    rank = {k: place for place, k in enumerate(order)}
    rejected = _different(surface, choice)[:MOST_DISCARDED]
    return LocalizationResult(
        tuple(_detection(part, scan, choice.chosen[k]) for k in order),
        tuple(
            Discarded(
                part=part.name,
                T_world_part=scan.T_world_scanner * pin.SE3(one.pose),
                score=one.sighting.score,
                reason=one.reason,
                rival=None if one.rival is None else rank[one.rival],
            )
            for one in rejected
        ),
    )


def _different(surface: PartSurface, choice: Choice) -> list[Rejection]:
    """What was rejected, best score first, without what is the same as better ones or chosen."""
    ranked = sorted(choice.rejected, key=lambda one: -one.sighting.score)
    poses = [one.pose for one in choice.chosen] + [one.pose for one in ranked]
    if not poses:
        return []
    kept = distinct(
        np.array(poses),
        np.arange(len(poses)),
        surface.stated,
        surface.fixed,
        distance=SAME_DISTANCE * surface.diameter,
        angle=np.pi if surface.is_ball else SAME_ANGLE,
        most=len(poses),
    )
    return [ranked[k - len(choice.chosen)] for k in kept if k >= len(choice.chosen)]


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

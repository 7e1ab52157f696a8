"""Finding the parts in a scan: hypotheses by voting, fits, and verification by drawing them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.ndimage import binary_dilation

from workbench.model.cell import Cell
from workbench.model.geometry import Bools, Floats
from workbench.model.messages.message import Message
from workbench.model.messages.work import ProgressText
from workbench.model.part import Part
from workbench.model.scan import (
    Detection,
    LocalizationResult,
    Objection,
    RejectedHypothesis,
    Scan,
)
from workbench.model.symmetry import ROUND
from workbench.perception.bins.bin_fit import above_floor
from workbench.perception.localization.alternatives import (
    share_nearby,
    share_of_turns,
    with_turn_error,
)
from workbench.perception.localization.assessment import Assessment
from workbench.perception.localization.cad_shape import report_shape
from workbench.perception.localization.certainty import (
    covariance,
    loose_probability_of,
    probability_of,
)
from workbench.perception.localization.choice import (
    LEAST_PIXELS,
    Choice,
    Hypothesis,
    PartSearch,
    Rejection,
    are_in_bin,
)
from workbench.perception.localization.hypotheses import (
    EFFORTS,
    find_hypotheses,
    select_distinct,
)
from workbench.perception.localization.judging import JudgedChoice, judge_choices
from workbench.perception.localization.loosening import measure_explained
from workbench.perception.matching.likelihood import LEAST_SPREAD, SPREAD_OVER_NOISE
from workbench.perception.matching.maps import MIXED, POINTS_A_PIXEL, DepthMap, make_map
from workbench.perception.parts.part_surface import PartSurface, prepare
from workbench.perception.scene.scene_model import SceneModel

PIXELS_ACROSS = 70
"""Pixels of the working map over the part's diameter, if the scan is dense enough."""

FEWEST_ACROSS = 20
"""Pixels over the diameter with which a glance can be taken."""

EXPLAINED_SHARE = 0.015
"""Distance from the predicted surface within which a point is explained, over the diameter."""

TOLERANCE_OVER_NOISE = 4.0
"""But not less than this many standard deviations of the noise that the scan shows."""

RIM = 2
"""Pixels around a part found that do not vote for others: edges, where normals are mixed."""

MOST_REJECTED = 20
"""Rejected hypotheses that are reported, the best first."""


@dataclass(frozen=True, slots=True, eq=False)
class PartSearchResult:
    """The result of the search for one part.

    `gains` [m2]: for each detection the area seen that speaks for it, less what speaks against.
    """

    findings: LocalizationResult
    surface: PartSurface
    gains: tuple[float, ...]


def together(scan: Scan, searches: Sequence[PartSearch | PartSurface]) -> list[PartSearchResult]:
    """The results for several parts in one scan, of those accepted parts that stand together."""
    found = [search for search in searches if isinstance(search, PartSearch)]
    judged = judge_choices(found)
    explained = measure_explained(found, judged)
    standing = iter(judged)
    return [
        _conclude(scan, search, next(standing), explained)
        if isinstance(search, PartSearch)
        else PartSearchResult(LocalizationResult(()), search, ())
        for search in searches
    ]


def _conclude(
    scan: Scan, search: PartSearch, standing: JudgedChoice, explained: float
) -> PartSearchResult:
    search, standing, scales, offsets = report_shape(search, standing)
    choice = standing.choice
    order = sorted(range(len(choice.chosen)), key=lambda k: -choice.chosen[k].sighting.score)
    gains = tuple(choice.chosen[k].sighting.gain * search.depth_map.pitch**2 for k in order)
    detections = tuple(
        _detection(scan, search, choice.chosen[k], standing.ratios[k], explained) for k in order
    )
    rejected = _list_rejected(scan, search, choice, order)
    result = LocalizationResult(detections, rejected, scales, offsets)
    return PartSearchResult(result, search.surface, gains)


def begin_search(
    scan: Scan, part: Part, cell: Cell, *, detail: float, scene: SceneModel
) -> PartSearch | PartSurface:
    """The search for a part before anything is found; see `proposals`.

    Args:
        scan: organised or not.
        part: what to look for.
        cell: its bin says where; its scanner how noisy the points are, if the scan does not.
        detail: how fine the scan is searched; 1 is usual.
        scene: what surrounds the parts, and how good the scan is.

    Returns:
        What `proposals` looks in; of a scan with nothing in the bin, the part alone.

    Raises:
        InputError: the part's mesh has no surface.
    """
    surface = prepare(part)
    pitch = surface.diameter / (PIXELS_ACROSS * detail)
    bin = scene.place
    depth_map = make_map(scene.scan, bin, scene.bin, size=surface.diameter, pitch=pitch)
    if depth_map is None:
        return surface
    if scene.filled > 1.0:
        # A surface ends anywhere between its last point and the next one.
        between = np.sqrt(scene.filled * POINTS_A_PIXEL) / POINTS_A_PIXEL
        depth_map = replace(depth_map, mixed=MIXED + round(float(between)))
    noise = _noise(cell, scan, scene)
    tolerance = max(EXPLAINED_SHARE * surface.diameter, TOLERANCE_OVER_NOISE * noise)
    spread = max(SPREAD_OVER_NOISE * noise, LEAST_SPREAD * tolerance)
    T_scanner_bin = scan.T_world_scanner.actInv(bin.T_world_bin)

    def are_inside(surface: PartSurface, poses: Floats, *, tolerance: float) -> Bools:
        return are_in_bin(surface, poses, T_scanner_bin, bin, scene.bin, tolerance=tolerance)

    def heights(points: Floats) -> Floats:
        T = T_scanner_bin.inverse()
        p_bin = points @ T.rotation.T + T.translation
        return above_floor(scene.bin, bin.size, p_bin)

    choice, coarse_map = Choice.empty(depth_map), _coarser(depth_map, surface)
    return PartSearch(
        part, surface, depth_map, coarse_map, tolerance, spread, are_inside, choice,
        filled=scene.filled, heights=heights if scene.bin.is_floor_seen else None,
    )  # fmt: skip


def proposals(
    search: PartSearch, number: int, taken: Bools, *, seed: int, step: Callable[[Message], None]
) -> list[Hypothesis]:
    """Where a part may lie in what is left of the scan, checked with an effort of that number.

    Point-pair features of the scan inside the bin vote for poses; they are fitted by projective
    ICP, and verified by drawing the mesh: what the scan measures must lie where the pose predicts
    it, and the scan must not look through the part.

    Args:
        search: what was taken before; what is outside the bin is added to what was rejected.
        number: from 0, of the effort in `hypotheses.EFFORTS`.
        taken: (pixels,) no unit, those of its maps in which parts of other kinds are known to lie.
        seed: of the choice of points that vote.
        step: called with what is being done; it may raise to give up.

    Returns:
        What `kinds.compete` takes.
    """
    step(ProgressText.VOTE())
    free = _without(search.depth_map, (search.choice.claimed >= 0) | taken)
    if np.count_nonzero(free.foreground) < LEAST_PIXELS:
        return []
    poses, outside = find_hypotheses(
        free,
        _coarser(free, search.surface),
        search.surface,
        search.tolerance,
        search.are_possible,
        EFFORTS[number],
        seed=(seed, number),
    )
    search.choice.rejected += [
        Rejection(pose, search.look(pose), Objection.OUTSIDE) for pose in outside
    ]
    return [search.hypothesis(pose) for pose in poses]


def _coarser(depth_map: DepthMap, surface: PartSurface) -> DepthMap:
    """What a glance is taken at: half the map's resolution, where that still shows the part."""
    return (
        depth_map.halved() if surface.diameter / depth_map.pitch >= 2 * FEWEST_ACROSS else depth_map
    )


def _without(depth_map: DepthMap, claimed: Bools) -> DepthMap:
    """The scan without the pixels (pixels,) that parts explain, and without the rims around."""
    if not claimed.any():
        return depth_map
    rims: Any = binary_dilation(claimed.reshape(depth_map.depth.shape), iterations=RIM)
    return replace(depth_map, foreground=depth_map.foreground & ~rims)


def _noise(cell: Cell, scan: Scan, scene: SceneModel) -> float:
    """Deviation [m] of the scan's points at the bin."""
    distance = np.linalg.norm(scan.T_world_scanner.translation - cell.bin.T_world_bin.translation)
    return scene.sensor.deviation(float(distance), otherwise=cell.scanner.depth_noise)


def _list_rejected(
    scan: Scan, search: PartSearch, choice: Choice, order: Sequence[int]
) -> tuple[RejectedHypothesis, ...]:
    """The best rejected hypotheses; `order` is that of the accepted parts as detections."""
    rank = {k: place for place, k in enumerate(order)}
    return tuple(
        RejectedHypothesis(
            part=search.part.name,
            T_world_part=scan.T_world_scanner * pin.SE3(rejected.pose),
            score=rejected.sighting.score,
            reason=rejected.reason,
            rival=None if rejected.rival is None else rank[rejected.rival],
        )
        for rejected in _different(search.surface, choice)[:MOST_REJECTED]
    )


def _different(surface: PartSurface, choice: Choice) -> list[Rejection]:
    """Rejected hypotheses, best score first, that differ from better and from accepted poses."""
    ranked = sorted(choice.rejected, key=lambda rejection: -rejection.sighting.score)
    poses = [assessment.pose for assessment in choice.chosen] + [
        rejection.pose for rejection in ranked
    ]
    if not poses:
        return []
    kept = select_distinct(surface, np.array(poses), np.arange(len(poses)))
    return [ranked[k - len(choice.chosen)] for k in kept if k >= len(choice.chosen)]


def _detection(
    scan: Scan, sought: PartSearch, assessed: Assessment, ratio: float, explained: float
) -> Detection:
    sighting = assessed.sighting
    axes = np.kron(np.eye(2), scan.T_world_scanner.rotation)
    chance = (
        loose_probability_of(ratio, sighting.visible)
        if sought.is_loose
        else probability_of(ratio, explained)
    )
    known = covariance(
        sought.depth_map,
        sought.surface,
        assessed.pose,
        sighting,
        sought.tolerance,
        filled=sought.filled,
    )
    known = with_turn_error(known, sought.surface, assessed.pose, assessed.outline_error)
    chance *= share_of_turns(assessed.outline_error)
    if not sought.is_loose:
        # With more tolerance the scan says little of small turns, and `chance` is of the place.
        chance *= share_nearby(
            sought.depth_map,
            sought.surface,
            assessed.pose,
            known,
            sought.tolerance,
            is_roll_free=not assessed.roll_known
            or assessed.outline_error > 0.0
            or sought.part.symmetry.form == ROUND,
        )
    return Detection(
        part=sought.part.name,
        T_world_part=scan.T_world_scanner * pin.SE3(assessed.pose),
        score=sighting.score,
        visible=sighting.visible,
        gap=assessed.gap,
        residual=float(np.sqrt(np.mean(sighting.off**2))),
        roll_known=assessed.roll_known,
        covariance=axes @ known @ axes.T,
        probability=chance * assessed.share,
        roll_axis=None if assessed.roll_known else sought.surface.symmetry.axis,
        by_colour=assessed.by_colour,
    )

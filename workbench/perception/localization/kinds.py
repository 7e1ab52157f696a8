"""Several kinds of parts in one scan: their hypotheses compete, the largest first.

A bolt fits on the side of a cylinder, and a small plate on every face.  Where a part of another
kind explains the same and much more of the scan, nobody needs to look closely.  Should that part
fall when all are held together (`judging`), its surface is searched again with the next effort.
What two kinds are thought to explain in the end is one of them.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from heapq import heapify, heappop, heappush
from itertools import count

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.scan import Detection, LocalizationResult, Objection, RejectedHypothesis, Scan
from workbench.perception.localization.assessment import Assessment, assess
from workbench.perception.localization.cad_shape import allow_changes
from workbench.perception.localization.choice import (
    Choice,
    Hypothesis,
    PartSearch,
    Rejection,
    enough,
    gain,
    reaches_into,
    take,
)
from workbench.perception.localization.eaten import allow_eaten_outlines
from workbench.perception.localization.hypotheses import EFFORTS, find_coarse_poses
from workbench.perception.localization.judging import doubted_apart, taken_by_others
from workbench.perception.localization.localize import (
    MOST_REJECTED,
    PartSearchResult,
    begin_search,
    proposals,
    together,
)
from workbench.perception.localization.loosening import relax_tolerance
from workbench.perception.matching.sightings import look
from workbench.perception.parts.part_surface import PartSurface, prepare
from workbench.perception.scene.scene_model import scene_model
from workbench.plugins.progress import Cancelled, Report

OUTDONE = 1.5
"""A part speaks for so much more area than one of another kind that lies in it: what it leaves is
all that counts of the other."""

FEW_KINDS = 5
"""This many are all searched for at once; to glance at more before costs less than it saves."""


@dataclass(slots=True, eq=False)
class KindHypotheses:
    """The hypotheses of one kind that are left.

    `gains` (k,) [m^2] is the area that speaks for each of them; `largest` (pixels,) [m^2] that of
    the largest part of another kind that explains a pixel of this kind's maps, 0 where none does.
    """

    search: PartSearch
    left: list[Hypothesis]
    gains: Floats
    largest: Floats

    @property
    def best_gain(self) -> float:
        """The gain [m^2] of the best hypothesis that is left."""
        return float(self.gains.max())

    def weigh(self) -> None:
        """The gains anew, when something was taken."""
        claimed, area = self.search.choice.claimed, self.search.depth_map.pitch**2
        self.gains = np.array([area * gain(each.sighting, claimed) for each in self.left])

    def pop_best(self) -> Hypothesis:
        """The hypothesis that gains most, which is left no more."""
        best = int(self.gains.argmax())
        self.gains = np.delete(self.gains, best)
        return self.left.pop(best)


ResolveByColour = Callable[[Scan, Sequence[PartSearch]], list[PartSearch]]
"""Decides kinds and rotations that shape leaves open; returns the searches with new choices."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchedView:
    """What one view shows, and the searches as they ended: sizes and tolerances may have changed.

    There is no search for a kind where the view shows nothing in the bin.
    """

    result: LocalizationResult
    searches: tuple[PartSearch, ...]


def localize_parts(
    scan: Scan,
    cell: Cell,
    *,
    seed: int,
    detail: float,
    report: Report,
    cancelled: Cancelled,
    resolve_by_colour: ResolveByColour = lambda _, searches: list(searches),
) -> SearchedView:
    """All parts of all kinds that a cell picks; see `plugins.localizer.Localizer.find`."""
    steps = count()

    def step(note: Message) -> None:
        if cancelled():
            raise JobCancelled(CancelText.SEARCH())
        report(1.0 - 0.88 ** (next(steps) / len(cell.parts)), note)

    sizes = [prepare(part).diameter for part in cell.parts]
    scene = scene_model(scan, cell, smallest=min(sizes, default=0.0))
    searches: list[PartSearch | PartSurface] = []
    for part in cell.parts:
        step(ProgressText.PREPARE(part=part.name))
        searches.append(begin_search(scan, part, cell, detail=detail, scene=scene))
    found = [search for search in searches if isinstance(search, PartSearch)]
    closely = partial(look_closely, step)
    for number, turns in _rounds(found, seed, step):
        if number == 1 or (number > 1 and not any(search.choice.chosen for search in found)):
            found = allow_changes(found, partial(compete, closely=closely))
        if number == 1:
            found = allow_eaten_outlines(found, partial(compete, closely=closely))
            found = relax_tolerance(found, partial(compete, closely=closely))
        elif number > 1 and any(search.is_loose for search in found):
            # Such a scan hardly shows hidden parts, and this round takes most of the time.
            break
        # What is in doubt competes once more with what a greater effort finds in its place.
        apart = [doubted_apart(search) for search in found]
        found = [search for search, _ in apart]
        # At first nothing is taken, and each kind looks everywhere.
        taken = taken_by_others(found)
        proposed = [
            doubted
            + (proposals(search, number, pixels, seed=seed, step=step) if is_its_turn else [])
            for (search, doubted), pixels, is_its_turn in zip(apart, taken, turns, strict=True)
        ]
        compete(found, proposed, closely)
    found = resolve_by_colour(scan, found)
    ended = iter(found)
    results = together(
        scan, [next(ended) if isinstance(search, PartSearch) else search for search in searches]
    )
    return SearchedView(merged(results), tuple(found))


def _rounds(
    found: Sequence[PartSearch], seed: int, step: Callable[[Message], None]
) -> Iterator[tuple[int, Sequence[bool]]]:
    """The number of the effort of each round, and for each kind whether it is its turn.

    Of many kinds those come first of which a glance shows some: the others are searched for in what
    these leave, which is little if they are not there.
    """
    everyone = [True] * len(found)
    rounds = [(number, everyone) for number in range(len(EFFORTS))]
    if len(found) > FEW_KINDS:
        likely = _likely(found, seed, step)
        rounds[:1] = [(0, likely), (0, [not is_likely for is_likely in likely])]
    yield from rounds


def _likely(found: Sequence[PartSearch], seed: int, step: Callable[[Message], None]) -> list[bool]:
    """For each kind whether poses of it stand that a few votes propose, among those of all kinds.

    Nothing is checked closely, so twice as much is tolerated.
    """
    glances = [
        replace(
            search,
            depth_map=search.coarse_map,
            tolerance=2 * search.tolerance,
            spread=2 * search.spread,
            choice=Choice.empty(search.coarse_map),
        )
        for search in found
    ]
    proposed: list[list[Hypothesis]] = []
    for search, glance in zip(found, glances, strict=True):
        step(ProgressText.GLANCE())
        poses = find_coarse_poses(
            search.coarse_map, search.surface, search.tolerance, search.are_possible, seed=seed
        )
        proposed.append([glance.hypothesis(pose) for pose in poses])
    compete(glances, proposed, _as_it_is)
    return [bool(glance.choice.chosen) for glance in glances]


Closely = Callable[[PartSearch, Hypothesis], Assessment]
"""Looks closely at a hypothesis of a kind, and returns a better pose."""


def look_closely(
    step: Callable[[Message], None], search: PartSearch, hypothesis: Hypothesis
) -> Assessment:
    """The best pose near one that was fitted roughly."""
    step(ProgressText.LOOK_CLOSELY())
    return assess(
        search.depth_map, search.coarse_map, search.surface, hypothesis.pose, search.tolerance
    )


def _as_it_is(search: PartSearch, hypothesis: Hypothesis) -> Assessment:
    """The assessment of a pose without further checks."""
    return Assessment(
        hypothesis.pose,
        hypothesis.sighting,
        None,
        roll_known=True,
        is_constrained=True,
        share=1.0,
    )


def compete(
    searches: Sequence[PartSearch], found: Sequence[list[Hypothesis]], closely: Closely
) -> None:
    """Take the hypotheses that hold together after a close look, those that gain most first.

    Args:
        searches: the kinds; what is taken and what is not is added to their choices.
        found: the possible poses of each, fitted roughly.
        closely: see there.
    """
    entries = [
        KindHypotheses(search, list(poses), np.empty(0), np.zeros(search.depth_map.depth.size))
        for search, poses in zip(searches, found, strict=True)
        if poses
    ]
    for entry in entries:
        entry.weigh()
    # Of many kinds only the one that was tried has another best hypothesis than before.
    queue = [(-entry.best_gain, k) for k, entry in enumerate(entries)]
    heapify(queue)
    while queue:
        _, k = heappop(queue)
        entry = entries[k]
        taken = _try_to_take(entry, entry.pop_best(), closely)
        if taken is not None:
            entry.weigh()
            for other in entries:
                if other is not entry and other.left:
                    _cover(other, entry.search, taken)
        if entry.left:
            heappush(queue, (-entry.best_gain, k))


def _try_to_take(
    entry: KindHypotheses, hypothesis: Hypothesis, closely: Closely
) -> Assessment | None:
    search = entry.search
    if _is_outdone(entry, hypothesis):
        search.choice.rejected.append(
            Rejection(hypothesis.pose, hypothesis.sighting, Objection.OUTDONE)
        )
        return None
    return take(search, hypothesis, partial(closely, search))


def _is_outdone(entry: KindHypotheses, hypothesis: Hypothesis) -> bool:
    """Whether much larger parts of other kinds leave too little of what it explains."""
    seen = hypothesis.sighting
    area = max(seen.gain, 0.0) * entry.search.depth_map.pitch**2
    outdone = entry.largest[seen.explained] > OUTDONE * area
    left = len(outdone) - int(np.count_nonzero(outdone))
    return left < len(outdone) and left < enough(seen)


def _cover(entry: KindHypotheses, kind: PartSearch, taken: Assessment) -> None:
    """What a part of another kind that was taken explains in this kind's maps."""
    area = taken.sighting.gain * kind.depth_map.pitch**2
    explained = look(entry.search.depth_map, kind.surface, taken.pose, kind.tolerance).explained
    entry.largest[explained] = np.maximum(entry.largest[explained], area)


def merged(results: Sequence[PartSearchResult]) -> LocalizationResult:
    """The results for several kinds as one.

    A bolt fits on the side of a cylinder: each kind by itself would be found there.  Where a
    detection reaches into one of another kind, that stands for which more surface speaks.

    Returns:
        All detections that stand, best score first, and the best of all that was rejected.
    """
    claims = [
        (gain, k, detection)
        for k, each in enumerate(results)
        for gain, detection in zip(each.gains, each.findings.detections, strict=True)
    ]
    claims.sort(key=lambda claim: -claim[0])
    standing: list[tuple[int, Detection]] = []
    lost: list[tuple[Detection, Detection]] = []
    for _, k, detection in claims:
        rival = next(
            (r for j, r in standing if j != k and _overlap(results, j, r, k, detection)), None
        )
        if rival is None:
            standing.append((k, detection))
        else:
            lost.append((detection, rival))
    found = sorted((part for _, part in standing), key=lambda part: -part.score)
    place = {id(detection): number for number, detection in enumerate(found)}
    place |= {id(detection): place[id(rival)] for detection, rival in lost}
    rejected = [
        replace(
            hypothesis,
            rival=None
            if hypothesis.rival is None
            else place[id(each.detections[hypothesis.rival])],
        )
        for each in (result.findings for result in results)
        for hypothesis in each.rejected
    ]
    rejected += [
        RejectedHypothesis(
            detection.part,
            detection.T_world_part,
            detection.score,
            Objection.REACHES_INTO,
            place[id(detection)],
        )
        for detection, _ in lost
    ]
    rejected.sort(key=lambda hypothesis: -hypothesis.score)
    scales = tuple(scale for result in results for scale in result.findings.scales)
    offsets = tuple(offset for result in results for offset in result.findings.offsets)
    return LocalizationResult(tuple(found), tuple(rejected[:MOST_REJECTED]), scales, offsets)


def _overlap(
    results: Sequence[PartSearchResult], j: int, first: Detection, k: int, second: Detection
) -> bool:
    """Whether a part of kind `j` and one of kind `k` would share room."""

    def is_in(surface: PartSurface, T_one: pin.SE3, host: PartSurface, T_host: pin.SE3) -> bool:
        return reaches_into(surface, host, T_host.actInv(T_one).homogeneous)

    first_surface, other = results[j].surface, results[k].surface
    T_one, T_other = first.T_world_part, second.T_world_part
    return is_in(first_surface, T_one, other, T_other) or is_in(
        other, T_other, first_surface, T_one
    )

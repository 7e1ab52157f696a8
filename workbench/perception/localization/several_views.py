"""Parts in a scan that is merged from several views: each is searched along its own rays.

A view knows what it has seen and what it has looked through.  So each is searched by itself, and
what one has found is held against all others: none of them may look through it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.cell import Cell
from workbench.model.derived.by_view import scans_by_view
from workbench.model.scan import (
    Detection,
    LocalizationResult,
    Objection,
    RejectedHypothesis,
    Scan,
)
from workbench.perception.localization.choice import (
    LEAST_PIXELS,
    PLAUSIBLE,
    SAME_PLACE,
    reaches_into,
)
from workbench.perception.localization.judging import PartSearch
from workbench.perception.localization.localize import MOST_REJECTED, begin_search
from workbench.perception.matching.sightings import Sighting, look
from workbench.perception.parts.part_surface import prepare
from workbench.perception.scene.scene_model import scene_model
from workbench.plugins.progress import Report

Localize = Callable[[Scan, Report], LocalizationResult]
"""The search in one view, which reports how far it is."""


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """A detection, how all views see it, and the area [m^2] that speaks for it in all of them."""

    detection: Detection
    sightings: tuple[Sighting, ...]
    gain: float

    @property
    def is_looked_through(self) -> bool:
        """Whether any view sees too much behind it."""
        return any(
            len(seen.violated) >= LEAST_PIXELS
            and len(seen.explained) < PLAUSIBLE * (len(seen.explained) + len(seen.violated))
            for seen in self.sightings
        )


def localize_in_views(
    scan: Scan, cell: Cell, localize: Localize, *, detail: float, report: Report
) -> LocalizationResult:
    """All parts that the views of a scan show; see `plugins.localizer.Localizer.find`.

    Args:
        scan: merged from several views, or of one.
        cell: its parts say what to look for.
        localize: searches one view.
        detail: how fine it searches; 1 is usual.
        report: progress.
    """
    scans = scans_by_view(scan)
    if len(scans) == 1:
        return localize(scan, report)
    results = [
        localize(
            each,
            lambda done, note, number=number: report((number + done) / len(scans), note),
        )
        for number, each in enumerate(scans)
    ]
    searches = _searches(scans, cell, detail)
    every = [
        _held_against(detection, scans, searches)
        for result in results
        for detection in result.detections
    ]
    every.sort(key=lambda found: -found.gain)
    kept: list[_Found] = []
    rejected: list[tuple[_Found, Objection, _Found | None]] = []
    for found in every:
        if found.is_looked_through:
            rejected.append((found, Objection.FREE_SPACE, None))
        elif rival := next((other for other in kept if _is_one_place(cell, other, found)), None):
            rejected.append((found, Objection.TWIN, rival))
        else:
            kept.append(found)
    order = sorted(kept, key=lambda found: -found.detection.score)
    others = (replace(each, rival=None) for result in results for each in result.rejected)
    return replace(
        # The sizes of parts are those that the last view shows.
        results[-1],
        detections=tuple(found.detection for found in order),
        rejected=(*(_reject(*each, order) for each in rejected), *others)[:MOST_REJECTED],
    )


def _reject(
    found: _Found, why: Objection, rival: _Found | None, order: Sequence[_Found]
) -> RejectedHypothesis:
    detection = found.detection
    place = None if rival is None else order.index(rival)
    return RejectedHypothesis(detection.part, detection.T_world_part, detection.score, why, place)


def _searches(scans: Sequence[Scan], cell: Cell, detail: float) -> list[dict[str, PartSearch]]:
    """The maps of each view for each kind of part, as far as it shows anything in the bin."""
    smallest = min((prepare(part).diameter for part in cell.parts), default=0.0)
    found: list[dict[str, PartSearch]] = []
    for scan in scans:
        scene = scene_model(scan, cell, smallest=smallest)
        begun = {
            part.name: begin_search(scan, part, cell, detail=detail, scene=scene)
            for part in cell.parts
        }
        found.append({name: of for name, of in begun.items() if isinstance(of, PartSearch)})
    return found


def _held_against(
    detection: Detection, scans: Sequence[Scan], searches: Sequence[dict[str, PartSearch]]
) -> _Found:
    """A detection as each view sees it, whichever has found it."""
    sightings: list[Sighting] = []
    gain = 0.0
    for scan, by_part in zip(scans, searches, strict=True):
        search = by_part.get(detection.part)
        if search is not None:
            pose = scan.T_world_scanner.actInv(detection.T_world_part).homogeneous
            seen = look(search.depth_map, search.surface, pose, search.tolerance)
            sightings.append(seen)
            gain += seen.gain * search.depth_map.pitch**2
    return _Found(detection, tuple(sightings), gain)


def _is_one_place(cell: Cell, first: _Found, other: _Found) -> bool:
    """Whether two parts are at one place, as no two parts can be."""
    one, two = (prepare(cell.part(found.detection.part)) for found in (first, other))
    T_one_two = first.detection.T_world_part.actInv(other.detection.T_world_part)
    apart = float(np.linalg.norm(T_one_two.act(two.middle) - one.middle))
    if apart < SAME_PLACE * min(one.diameter, two.diameter):
        return True
    return reaches_into(two, one, T_one_two.homogeneous) or reaches_into(
        one, two, T_one_two.inverse().homogeneous
    )

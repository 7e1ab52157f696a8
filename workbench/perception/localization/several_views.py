"""Parts in a scan that is merged from several views: each is searched along its own rays.

A view knows what it has seen and what it has looked through.  So each is searched by itself, and
what one has found is held against all others: none of them may look through it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from workbench.model.derived.by_view import scans_by_view
from workbench.model.scan import (
    Detection,
    LocalizationResult,
    Objection,
    OffsetCheck,
    RejectedHypothesis,
    ScaleCheck,
    Scan,
)
from workbench.perception.localization.choice import (
    LEAST_PIXELS,
    PLAUSIBLE,
    SAME_PLACE,
    PartSearch,
    reaches_into,
)
from workbench.perception.localization.kinds import SearchedView
from workbench.perception.localization.localize import MOST_REJECTED
from workbench.perception.matching.sightings import Sighting, look
from workbench.perception.parts.part_surface import PartSurface
from workbench.plugins.progress import Report

Localize = Callable[[Scan, Report], SearchedView]
"""The search in one view, which reports how far it is."""

Check = TypeVar("Check", ScaleCheck, OffsetCheck)


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """A detection, its surface, how all views see it, and the area [m^2] that speaks for it."""

    detection: Detection
    surface: PartSurface
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


def localize_in_views(scan: Scan, localize: Localize, report: Report) -> LocalizationResult:
    """All parts that the views of a scan show; see `plugins.localizer.Localizer.find`.

    Args:
        scan: merged from several views, or of one.
        localize: searches one view.
        report: progress.
    """
    scans = scans_by_view(scan)
    if len(scans) == 1:
        return localize(scan, report).result
    views = [
        localize(
            each,
            lambda done, note, number=number: report((number + done) / len(scans), note),
        )
        for number, each in enumerate(scans)
    ]
    shapes = _shapes(views)
    every = [
        _held_against(detection, scans, views, shapes[detection.part])
        for view in views
        for detection in view.result.detections
    ]
    every.sort(key=lambda found: -found.gain)
    kept: list[_Found] = []
    rejected: list[tuple[_Found, Objection, _Found | None]] = []
    for found in every:
        if found.is_looked_through:
            rejected.append((found, Objection.FREE_SPACE, None))
        elif rival := next((other for other in kept if _is_one_place(other, found)), None):
            rejected.append((found, Objection.TWIN, rival))
        else:
            kept.append(found)
    order = sorted(kept, key=lambda found: -found.detection.score)
    others = (replace(each, rival=None) for view in views for each in view.result.rejected)
    return LocalizationResult(
        detections=tuple(found.detection for found in order),
        rejected=(*(_reject(*each, order) for each in rejected), *others)[:MOST_REJECTED],
        scales=_by_most([scale for view in views for scale in view.result.scales]),
        offsets=_by_most([offset for view in views for offset in view.result.offsets]),
    )


def _by_most(checks: Sequence[Check]) -> tuple[Check, ...]:
    """For each kind of part the check of the view in which most parts show it."""
    best: dict[str, Check] = {}
    for check in checks:
        if check.part not in best or check.count > best[check.part].count:
            best[check.part] = check
    return tuple(best.values())


def _reject(
    found: _Found, why: Objection, rival: _Found | None, order: Sequence[_Found]
) -> RejectedHypothesis:
    detection = found.detection
    place = None if rival is None else order.index(rival)
    return RejectedHypothesis(detection.part, detection.T_world_part, detection.score, why, place)


def _shapes(views: Sequence[SearchedView]) -> dict[str, PartSearch]:
    """For each kind the search of the view that has found most of it: its size and tolerance."""
    best: dict[str, PartSearch] = {}
    for search in (search for view in views for search in view.searches):
        name = search.part.name
        if name not in best or len(search.choice.chosen) > len(best[name].choice.chosen):
            best[name] = search
    return best


def _held_against(
    detection: Detection, scans: Sequence[Scan], views: Sequence[SearchedView], shape: PartSearch
) -> _Found:
    """A detection as each view sees it, whichever has found it."""
    sightings: list[Sighting] = []
    gain = 0.0
    for scan, view in zip(scans, views, strict=True):
        for search in view.searches:
            if search.part.name == detection.part:
                pose = scan.T_world_scanner.actInv(detection.T_world_part).homogeneous
                seen = look(search.depth_map, shape.surface, pose, shape.tolerance)
                sightings.append(seen)
                gain += seen.gain * search.depth_map.pitch**2
    return _Found(detection, shape.surface, tuple(sightings), gain)


def _is_one_place(first: _Found, other: _Found) -> bool:
    """Whether two parts are at one place, as no two parts can be."""
    one, two = first.surface, other.surface
    T_one_two = first.detection.T_world_part.actInv(other.detection.T_world_part)
    apart = float(np.linalg.norm(T_one_two.act(two.middle) - one.middle))
    if apart < SAME_PLACE * min(one.diameter, two.diameter):
        return True
    return reaches_into(two, one, T_one_two.homogeneous) or reaches_into(
        one, two, T_one_two.inverse().homogeneous
    )

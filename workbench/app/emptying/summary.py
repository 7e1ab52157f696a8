"""All piles together: how much was taken, how fast, and what stayed."""

from collections import Counter
from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

import numpy as np

from workbench.model.prediction import FAILURES, EmptiedPile

MS = 1000.0


def summary(
    scenes: Sequence[EmptiedPile], *, scan_seconds: float, approval_seconds: float
) -> dict[str, Any]:
    """The summary of all piles that is printed as JSON.

    Picks per hour count the planned motion, `scan_seconds` for each scan, the measured time of
    search and planning, and `approval_seconds` for each approval.  Scans, searches and plannings
    that run during a motion count only as far as they outlast it.  Missing values are None.

    Args:
        scenes: the emptied piles, in order.
        scan_seconds: duration of a scan [s].
        approval_seconds: time that a person needs to check and approve a plan [s].
    """
    parts, taken = sum(scene.parts for scene in scenes), sum(scene.taken for scene in scenes)
    counts = zip_longest(*(scene.failed for scene in scenes), fillvalue=0)
    kinds = dict.fromkeys(FAILURES[:3], 0) | dict(zip(FAILURES, map(sum, counts), strict=False))
    planning = [seconds for scene in scenes for seconds in scene.planning]
    stages: Counter[str] = Counter()
    for scene in scenes:
        stages.update(dict(scene.stages))
    scans = sum(scene.scans for scene in scenes)
    seconds = sum(
        scene.motion_seconds
        + scene.finding
        + sum(scene.planning)
        + scene.scans * scan_seconds
        + scene.cycles * approval_seconds
        - sum(min(moves, scan_seconds + took) for moves, took in scene.beside)
        for scene in scenes
    )
    return {
        "parts": parts,
        "taken": taken,
        "taken_share": taken / parts if parts else None,
        "taken_rolled": sum(scene.rolled for scene in scenes),
        "estimate_share": _estimate(scenes, taken, parts),
        "bound_share": _bound_share(scenes, taken, parts),
        **_kits(scenes),
        "picks": taken + sum(kinds.values()),
        "failed_picks": sum(kinds.values()),
        "failed_by_kind": kinds,
        "touches": sum(scene.touches for scene in scenes),
        "warned_picks": sum(scene.warned_picks for scene in scenes),
        "warned_touches": sum(scene.warned_touches for scene in scenes),
        "knocked_out": sum(scene.knocked_out for scene in scenes),
        "stirs": sum(scene.stirs for scene in scenes),
        "cycles": sum(scene.cycles for scene in scenes),
        "scans": scans,
        "motion_seconds": sum(scene.motion_seconds for scene in scenes),
        "parts_per_hour": 3600 * taken / seconds if seconds else None,
        "planning_ms": _percentiles(planning),
        "planning_ms_by_stage": {
            stage: MS * total / len(planning) for stage, total in stages.items()
        },
        "finding_ms": MS * sum(scene.finding for scene in scenes) / max(1, scans),
        "left_by_reason": dict(_reasons(scenes).most_common()),
        "scenes": [_scene(scene) for scene in scenes],
    }


def _kits(scenes: Sequence[EmptiedPile]) -> dict[str, int | None]:
    """Kits that were completed, and that the parts of the piles make; None where none is filled."""
    counts = [pile.kits for pile in scenes if pile.kits is not None]
    if not counts:
        return {"kits": None, "kits_possible": None, "kits_unmated": None}
    complete, possible = map(sum, zip(*counts, strict=True))
    unmated = sum(pile.unmated for pile in scenes)
    return {"kits": complete, "kits_possible": possible, "kits_unmated": unmated}


def _by_kind(pile: EmptiedPile) -> dict[str, int]:
    """Failed picks by kind, those that were counted."""
    return dict(zip(FAILURES, pile.failed, strict=False))


def _percentiles(seconds: Sequence[float]) -> dict[str, float] | None:
    """Median and 95th percentile [ms]; None where there are no times."""
    if not seconds:
        return None
    median, p95 = np.percentile(seconds, (50, 95)) * MS
    return {"median": float(median), "p95": float(p95)}


def _bound_share(scenes: Sequence[EmptiedPile], taken: int, parts: int) -> float | None:
    """The share that any grasps of the tool take, None when nobody asked."""
    more = [scene.more for scene in scenes if scene.more is not None]
    return (taken + sum(more)) / parts if parts and len(more) == len(scenes) else None


def _estimate(scenes: Sequence[EmptiedPile], taken: int, parts: int) -> float | None:
    """The share that was taken, or that some hand could hold as it stays; None where unknown."""
    more = [scene.holdable for scene in scenes if scene.holdable is not None]
    return (taken + sum(more)) / parts if parts and len(more) == len(scenes) else None


def _reasons(scenes: Sequence[EmptiedPile]) -> Counter[str]:
    return Counter(left.kind for scene in scenes for left in scene.left)


def _scene(pile: EmptiedPile) -> dict[str, Any]:
    return {
        "seed": pile.task.seed,
        "parts": pile.parts,
        "taken": pile.taken,
        "cycles": pile.cycles,
        "scans": pile.scans,
        "failed_picks": sum(pile.failed),
        "failed_by_kind": _by_kind(pile),
        "touches": pile.touches,
        "warned_picks": pile.warned_picks,
        "warned_touches": pile.warned_touches,
        "knocked_out": pile.knocked_out,
        "stirs": pile.stirs,
        "motion_seconds": pile.motion_seconds,
        "left": [left.form for left in pile.left],
    }

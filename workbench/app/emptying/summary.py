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
    """What is printed as JSON.

    An hour is made of the motion as planned, `scan_seconds` [s] for each look, the time that
    finding and planning took here, and `approval_seconds` [s] of a person for each plan, or row of
    plans, carried out.  Looks that can be taken beside a motion, and finding and planning for them,
    count for what is longer than what is left of that.  Shares and times of which there are none
    are None.

    Args:
        scenes: of all piles, in their order.
        scan_seconds: [s] that a scan takes.
        approval_seconds: [s] that a person needs to look at a plan and approve it.
    """
    parts, taken = sum(one.parts for one in scenes), sum(one.taken for one in scenes)
    counts = zip_longest(*(one.failed for one in scenes), fillvalue=0)
    kinds = dict.fromkeys(FAILURES[:3], 0) | dict(zip(FAILURES, map(sum, counts), strict=False))
    planning = [seconds for one in scenes for seconds in one.planning]
    stages: Counter[str] = Counter()
    for one in scenes:
        stages.update(dict(one.stages))
    scans = sum(one.scans for one in scenes)
    seconds = sum(
        one.motion_seconds
        + one.finding
        + sum(one.planning)
        + one.scans * scan_seconds
        + one.cycles * approval_seconds
        - sum(min(moves, scan_seconds + took) for moves, took in one.beside)
        for one in scenes
    )
    return {
        "parts": parts,
        "taken": taken,
        "taken_share": taken / parts if parts else None,
        "taken_rolled": sum(one.rolled for one in scenes),
        "estimate_share": _estimate(scenes, taken, parts),
        "bound_share": _bound(scenes, taken, parts),
        "picks": taken + sum(kinds.values()),
        "failed_picks": sum(kinds.values()),
        "failed_by_kind": kinds,
        "touches": sum(one.touches for one in scenes),
        "warned_picks": sum(one.warned_picks for one in scenes),
        "warned_touches": sum(one.warned_touches for one in scenes),
        "knocked_out": sum(one.knocked_out for one in scenes),
        "cycles": sum(one.cycles for one in scenes),
        "scans": scans,
        "motion_seconds": sum(one.motion_seconds for one in scenes),
        "parts_per_hour": 3600 * taken / seconds if seconds else None,
        "planning_ms": _percentiles(planning),
        "planning_ms_by_stage": {
            stage: MS * total / len(planning) for stage, total in stages.items()
        },
        "finding_ms": MS * sum(one.finding for one in scenes) / max(1, scans),
        "left_by_reason": dict(_reasons(scenes).most_common()),
        "scenes": [_scene(one) for one in scenes],
    }


def _by_kind(one: EmptiedPile) -> dict[str, int]:
    """Failed picks by kind, those that were counted."""
    return dict(zip(FAILURES, one.failed, strict=False))


def _percentiles(seconds: Sequence[float]) -> dict[str, float] | None:
    """Median and 95th percentile [ms]; None where there are no times."""
    if not seconds:
        return None
    median, p95 = np.percentile(seconds, (50, 95)) * MS
    return {"median": float(median), "p95": float(p95)}


def _bound(scenes: Sequence[EmptiedPile], taken: int, parts: int) -> float | None:
    """The share that any grasps of the tool take, None when nobody asked."""
    more = [one.more for one in scenes if one.more is not None]
    return (taken + sum(more)) / parts if parts and len(more) == len(scenes) else None


def _estimate(scenes: Sequence[EmptiedPile], taken: int, parts: int) -> float | None:
    """The share that was taken, or that some hand could hold as it stays; None where unknown."""
    more = [one.holdable for one in scenes if one.holdable is not None]
    return (taken + sum(more)) / parts if parts and len(more) == len(scenes) else None


def _reasons(scenes: Sequence[EmptiedPile]) -> Counter[str]:
    return Counter(left.kind for one in scenes for left in one.left)


def _scene(one: EmptiedPile) -> dict[str, Any]:
    return {
        "seed": one.task.seed,
        "parts": one.parts,
        "taken": one.taken,
        "cycles": one.cycles,
        "scans": one.scans,
        "failed_picks": sum(one.failed),
        "failed_by_kind": _by_kind(one),
        "touches": one.touches,
        "warned_picks": one.warned_picks,
        "warned_touches": one.warned_touches,
        "knocked_out": one.knocked_out,
        "motion_seconds": one.motion_seconds,
        "left": [left.form for left in one.left],
    }

"""Of pairs of parts: how many two arms take by one plan, how many one arm, and why not more."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from workbench.app.picking.pipeline import plan_pick
from workbench.model.cell import Cell
from workbench.model.plan import PlanResult
from workbench.model.scan import Detection
from workbench.planning.collision.world import World


@dataclass(frozen=True, slots=True)
class Taken:
    """How far the strategy `auto` comes with a pair.

    Its first plan takes `parts`: 2 with an arm each, 1, or 0, and `why` says why not 2.
    `is_whole`: together with a plan for what that one leaves, as it lies, it takes both; `left`
    says why not.
    """

    parts: int
    why: str
    is_whole: bool
    left: str


def taken_of(cell: Cell, detections: Sequence[Detection], first: PlanResult, seed: int) -> Taken:
    """What became of a pair.

    Args:
        cell: with two arms or more.
        detections: the two parts.
        first: what `auto` made of them, where distance forbids nothing.
        seed: of the plan for what it leaves.
    """
    if not first.is_proven or first.plan is None:
        why = f"neither: {_why_none(first)}"
        return Taken(0, why, False, why)
    if len(first.plan.arms) == len(detections):
        return Taken(len(detections), "", True, "")
    gone = {arm.detection for arm in first.plan.arms}
    rest = tuple(detection for number, detection in enumerate(detections) if number not in gone)
    second = plan_pick(cell, rest, "study", seed=seed)
    is_whole = second.is_proven
    left = "" if is_whole else f"one: {_why_none(second)}"
    return Taken(1, _why_one(cell, detections, first), is_whole, left)


def count_pairs(taken: Sequence[Taken]) -> dict[str, Any]:
    """How many pairs were taken by two arms, by one, not at all, and whole; and why not more."""
    return {
        "pairs": len(taken),
        "two_arms": sum(scene_pair.parts == 2 for scene_pair in taken),
        "one_arm": sum(scene_pair.parts == 1 for scene_pair in taken),
        "none": sum(scene_pair.parts == 0 for scene_pair in taken),
        "whole": sum(scene_pair.is_whole for scene_pair in taken),
        "why_one_arm": _most(scene_pair.why for scene_pair in taken if scene_pair.parts == 1),
        "why_none": _most(scene_pair.why for scene_pair in taken if scene_pair.parts == 0),
        "why_not_whole": _most(scene_pair.left for scene_pair in taken if not scene_pair.is_whole),
    }


def _most(reasons: Iterator[str]) -> dict[str, int]:
    """How often each comes, the most frequent first; the same for the same reasons in any order."""
    found = Counter(reasons)
    return dict(sorted(found.items(), key=lambda entry: (-entry[1], entry[0])))


def _why_none(result: PlanResult) -> str:
    """Why no part of a result was taken: the refusal that got furthest."""
    if result.plan is not None:
        return "the proof does not hold"
    if any(candidate.verdict.is_ok for candidate in result.candidates):
        return f"grasps work, {result.verdict.reason}"
    return _furthest(result, {candidate.detection for candidate in result.candidates})


def _why_one(cell: Cell, detections: Sequence[Detection], result: PlanResult) -> str:
    """Why a plan for a pair takes one part alone."""
    able = {
        (candidate.arm, candidate.detection)
        for candidate in result.candidates
        if candidate.verdict.is_ok
    }
    arms = {arm for arm, _ in able}
    unable = {candidate.detection for candidate in result.candidates} - {part for _, part in able}
    if unable:
        return f"the other part by no arm: {_furthest(result, unable)}"
    if len(arms) == 1:
        return "both parts by the same arm alone"
    world = World(cell, tuple(detections), ())
    if len(set(world.part_ways.heaps(cell.policy.pair_gap))) == 1:
        return "the parts are of one heap"
    return "no plan of two arms"


def _furthest(result: PlanResult, parts: set[int]) -> str:
    """The reason of the refusal that got furthest, of some parts."""
    verdicts = [
        candidate.verdict for candidate in result.candidates if candidate.detection in parts
    ]
    if not verdicts:
        return "no grasps"
    return str(max(verdicts, key=lambda verdict: verdict.progress).reason)

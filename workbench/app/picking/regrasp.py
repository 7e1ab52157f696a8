"""Regrasps a part that no grasp brings to its place: over a station."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from workbench.app.picking.pipeline import AS_THE_CELL, NO_MESSAGES, plan_pick
from workbench.app.picking.stations import Stand, StationSearch, cell_with
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Cell, PlanOverrides, Policy
from workbench.model.messages.message import Message, all_of
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.verdicts import StationNote, VerdictNote
from workbench.model.messages.work import ProgressText
from workbench.model.plan import Plan, PlanResult, Proven
from workbench.model.scan import Scene
from workbench.planning.placing.assembling import held_error
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.progress import Cancelled, Report, never, silent, within
from workbench.proof.claims.prove import prove, scene_after

MOST_PARTS = 4
"""Parts that are tried, in the order of their candidates."""

MOST_PLANNED = 4
"""Pairs of picks that are planned, the soonest done ones first."""


def plan_regrasp(  # noqa: PLR0913 - all that a request for a plan can say, by keyword
    cell: Cell,
    scene: Scene,
    refused: PlanResult,
    *,
    strategy: str = "auto",
    overrides: PlanOverrides = AS_THE_CELL,
    avoided: Mapping[int, Message] = NO_MESSAGES,
    seed: int = 0,
    report: Report = silent,
    cancelled: Cancelled = never,
    **asked: Any,
) -> PlanResult:
    """A plan that puts a part on a station, with one in a row that takes it from there to a place.

    The search chooses the pose on the station, and grasp and arm of each plan, by the least total
    time.  The second arm may differ from the first.

    Args:
        cell: with stations.
        scene: what is in the bin.
        refused: the result of planning without stations.
        strategy: see `plan_pick`; only one arm works at a time, so strategies for two do not help.
        overrides: see `plan_pick`, as for the following.
        avoided: see `plan_pick`.
        seed: see `plan_pick`.
        report: receives the progress.
        cancelled: called between steps; True ends the work.
        asked: further arguments of `plan_pick`.

    Returns:
        The two plans; where there are none, `refused` with a verdict that says so.

    Raises:
        JobCancelled: `cancelled` returned True.
    """
    arms = [arm.name for arm in cell.arms if strategy in ("auto", "single", arm.name)]
    numbers = _that_have_no_place(scene, refused, avoided)[:MOST_PARTS]
    if not arms or not numbers:
        return refused
    began, policy = working_time(), overrides.on(cell.policy)
    until = processor_time() + policy.seconds
    search = StationSearch(cell, scene, policy, arms, seed, until, cancelled)
    picks = dict(strategy=strategy, overrides=overrides, seed=seed, cancelled=cancelled, **asked)
    stands: dict[str, list[Stand]] = {}
    why = StationNote.NO_POSE()
    for count, number in enumerate(numbers):
        kind = scene.detections[number].part
        report_part = within(report, count / len(numbers), (count + 1) / len(numbers))
        if kind not in stands:
            stands[kind] = search.stands(kind, report_part)
        refusals: list[Verdict] = []
        pairs = search.pairs(number, stands[kind], refusals, report_part)
        if stands[kind] and not pairs:
            reason = _why_not(refusals) if processor_time() < search.until else Reason.OUT_OF_TIME
            why = StationNote.NO_GRASP(reason=reason.message)
        for stand in pairs[:MOST_PLANNED]:
            report_part(0.8, ProgressText.STATIONS())
            row = _plan_both(cell, scene, number, stand, policy, picks)
            if isinstance(row, Message):
                why = row
            else:
                first, second = row
                took = {**refused.seconds, "regrasp": working_time() - began}
                return replace(
                    refused,
                    plan=first.plan,
                    proof=first.proof,
                    verdict=Verdict(Reason.OK, Stage.ROUTE, note=all_of(first.plan.notes)),
                    seconds=took,
                    row=(second,),
                )
    return replace(refused, verdict=refused.verdict.with_note(StationNote.NOT_OVER(why=why)))


def _that_have_no_place(
    scene: Scene, refused: PlanResult, avoided: Mapping[int, Message]
) -> list[int]:
    """Parts that can be taken and not put down, in the order of their candidates."""
    numbers = [
        candidate.detection
        for candidate in refused.candidates
        if candidate.verdict.reason is Reason.NO_PLACE
    ]
    return [
        number
        for number in dict.fromkeys(numbers)
        if number not in avoided and scene.detections[number].roll_known
    ]


def _why_not(refusals: Sequence[Verdict]) -> Reason:
    """Why a part cannot go over a station with any grasp and any pose there.

    Placing is checked first: verdicts on grasps that can place the part count more.
    """
    later = Counter(refusal.reason for refusal in refusals if refusal.reason is not Reason.NO_PLACE)
    return later.most_common(1)[0][0] if later else Reason.NO_PLACE


def _plan_both(
    cell: Cell,
    scene: Scene,
    number: int,
    stand: Stand,
    policy: Policy,
    picks: Mapping[str, Any],
) -> tuple[Proven, Proven] | Message:
    """The two proven plans over a pose on the station, or why there are none."""
    kind, name = scene.detections[number].part, stand.station.name
    at = cell_with(cell, kind, stand, policy)
    result = plan_pick(
        at,
        scene.detections,
        scene.scan_digest,
        obstacles=scene.obstacles,
        avoided=_all_but(number, scene),
        **picks,
    )
    if result.plan is None:
        return StationNote.NO_PATH_TO(verdict=result.verdict.message)
    plan = _as_in(cell, result.plan, name, PlanNote.PUT_ON_STATION(station=name))
    first = Proven(plan, prove(cell, scene, plan))
    if not first.proof.holds:
        return StationNote.REFUSED_TO(violation=first.proof.violations[0].message)
    after = _as_put(cell, plan, scene_after(cell, plan))
    result = plan_pick(
        cell,
        after.detections,
        after.scan_digest,
        obstacles=after.obstacles,
        avoided=_all_but(len(after.detections) - 1, after),
        **picks,
    )
    if result.plan is None:
        return StationNote.NO_PATH_FROM(verdict=result.verdict.message)
    plan = _as_in(cell, result.plan, "", PlanNote.TAKEN_FROM_STATION(station=name))
    second = Proven(plan, prove(cell, after, plan))
    if not second.proof.holds:
        return StationNote.REFUSED_FROM(violation=second.proof.violations[0].message)
    return first, second


def _as_put(cell: Cell, plan: Plan, after: Scene) -> Scene:
    """The scene after a plan onto a station, with the possible error of the part there."""
    (arm_plan,), (*others, standing) = plan.arms, after.detections
    error = held_error(cell, plan.detections[arm_plan.detection], arm_plan)
    return replace(after, detections=(*others, replace(standing, placing=error)))


def _as_in(cell: Cell, plan: Plan, station: str, note: Message) -> Plan:
    """The plan as one of this cell, with where it puts its part."""
    return replace(
        plan,
        cell_digest=cell.digest,
        arms=tuple(replace(arm, station=station) for arm in plan.arms),
        notes=(note,),
    )


def _all_but(number: int, scene: Scene) -> dict[int, Message]:
    """Parts that are not picked while another goes over a station."""
    why = VerdictNote.AVOIDED_OTHERS()
    return {other: why for other in range(len(scene.detections)) if other != number}

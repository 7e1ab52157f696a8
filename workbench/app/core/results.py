"""Tasks of the worker, and what they and people have brought: parts found, a plan, or why not."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from workbench.app.core import commands
from workbench.app.core.commands import Entry, UseDetections
from workbench.app.core.effects import StartJob
from workbench.app.core.outcomes import after_one_more_scan, avoided_parts
from workbench.app.core.release import without_approval
from workbench.app.core.state import (
    Job,
    Outline,
    PartsState,
    Phase,
    PlanState,
    ScanState,
    State,
    begun,
    counted,
    stale_by,
)
from workbench.model.calibration import PlateObservation
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, JobCancelled, WorkbenchError
from workbench.model.messages.message import Message, all_of, as_message, plain
from workbench.model.messages.plans import strategy_message
from workbench.model.messages.states import StateText, task_message
from workbench.model.plan import PlanResult, Proven, count_taken
from workbench.model.prediction import Emptying
from workbench.model.scan import Remark, Scan, Search

FAILURES = (
    StateText.TASK_FAILED,
    StateText.NOTHING_FOUND,
    StateText.POSES_REFUSED,
    StateText.CELL_REFUSED,
    StateText.NO_PLAN,
    StateText.NOT_PROVEN,
    StateText.NO_PROOF,
)
"""Messages of a state that tell of something that has failed."""

Begun = tuple[State, tuple[StartJob, ...]]
"""The state, and the task that has begun with it, if one has."""

MOST_SEARCHES, MOST_REMARKS = 6, 30
"""In one scan, that are remembered."""

MOST_OUTLINES = 20
"""Plannings for the same parts that are remembered."""


def is_failure(message: Message | str) -> bool:
    """Whether a message of a state tells of something that has failed."""
    return isinstance(message, Message) and any(map(message.mentions, FAILURES))


def compared(state: State, search: Search) -> State:
    """The state after a search that takes nothing: what it found is listed beside the others."""
    searches = (*state.searches, search)[-MOST_SEARCHES:]
    found = counted(len(search.detections), "part")
    message = f"search {len(searches)} found {found}, to be compared; nothing was taken"
    return replace(state, searches=searches, message=message)


def with_detections(state: State, search: Search) -> State:
    """The state with what a search has found."""
    detections = search.detections
    return begun(
        state,
        PartsState,
        phase=Phase.LOCALIZED if detections else Phase.SCANNED,
        searches=(*state.searches, search)[-MOST_SEARCHES:],
        detections=detections,
        scene_digest=state.scan.digest if state.scan is not None else "",
        stale=stale_by(state, "parts were looked for again"),
        message=StateText.FOUND(count=len(detections)) if detections else StateText.NOTHING_FOUND(),
    )


def with_outside_detections(state: State, entry: Entry, command: UseDetections) -> State:
    """The state with parts from outside: a file, another matcher, or a person's correction."""
    detections = command.detections
    says = command.says or f"{counted(len(detections), 'pose')} taken from outside"
    remark = Remark(entry.at, entry.actor, says)
    # Poses from another matcher usually belong to this scan, but never to a picked bin.
    is_picked = state.phase is Phase.DONE
    before = state.parts_before
    if before and digest_of(before[0]) == digest_of(detections):
        # What was done last is undone.
        before = before[1:]
    elif state.detections:
        before = (state.detections, *before)
    return begun(
        replace(state, unscanned=None),
        ScanState if is_picked else PartsState,
        phase=Phase.LOCALIZED,
        remarks=(*(() if is_picked else state.remarks), remark)[-MOST_REMARKS:],
        parts_before=() if is_picked else before[:MOST_REMARKS],
        detections=detections,
        scene_digest=digest_of(detections),
        stale="" if is_picked else stale_by(state, "the parts are others"),
        message=f"{says}, by {entry.actor}",
    )


def with_plan(state: State, result: PlanResult, job: Job) -> State:
    """The state after a planning; what was said about an earlier plan goes.

    Args:
        state: before.
        result: what the planning brought; a plan whose proof does not hold is shown, too.
        job: that has ended with it.
    """
    if result.plan is None:
        phase = Phase.LOCALIZED
        message = StateText.NO_PLAN(verdict=result.verdict.message)
    elif result.proof is None or not result.proof.holds:
        phase = Phase.PLANNED
        message = StateText.NO_PROOF()
        if result.proof is not None:
            message = StateText.NOT_PROVEN(violation=result.proof.violations[0].message)
    else:
        phase = Phase.PLANNED
        message = StateText.PLAN_READY(
            strategy=strategy_message(result.plan.strategy),
            cycle=result.plan.cycle_seconds,
            clearance=result.proof.clearance,
        )
        more = StateText.MORE_PLANS(count=len(result.row)) if result.row else None
        remarks = result.plan.remarks if result.plan.stations else ()
        message = all_of((message, more, *remarks))
    return begun(
        state,
        PlanState,
        phase=phase,
        candidates=result.candidates,
        plan=result.plan,
        proof=result.proof,
        verdict=result.verdict,
        seconds=tuple(result.seconds.items()),
        obstacles=result.obstacles,
        bound=result.bound,
        row=result.row,
        row_ends=result.row_ends,
        outlines=_outlines(state, result, job),
        planned_threshold=job.threshold,
        wanted_threshold=state.wanted_threshold,
        message=message,
    )


def emptying_words(found: Emptying) -> str:
    """What came of piles emptied in simulation, in one sentence."""
    plain = found.plain
    taken, parts = sum(pile.taken for pile in plain), sum(pile.parts for pile in plain)
    words = f"{taken} of {counted(parts, 'part')} taken out of {counted(len(plain), 'pile')}"
    tried = len({pile.task.change for pile in found.piles} - {None})
    return f"{words} in simulation" + (f"; {counted(tried, 'change')} tried" if tried else "")


def _outlines(state: State, result: PlanResult, job: Job) -> tuple[Outline, ...]:
    """All outlines; a plan that was made before keeps its place, by which people know it."""
    found = list(state.outlines)
    for plan_result in (*result.beside, result):
        outline = _outline(plan_result, job)
        places = [k for k, known in enumerate(found) if known.digest == outline.digest != ""]
        if places:
            found[places[0]] = outline
        else:
            found.append(outline)
    return tuple(found[-MOST_OUTLINES:])


def _outline(result: PlanResult, job: Job) -> Outline:
    planning = sum(result.seconds.values())
    plan, proof = result.plan, result.proof
    if plan is None or proof is None:
        return Outline(result.planner, planning, verdict=result.verdict.message)
    every = [Proven(plan, proof), *result.row]
    distances = [
        float(d.min()) for proven_plan in every for _, _, d in proven_plan.proof.apart if len(d)
    ]
    return Outline(
        result.planner,
        planning,
        str(plan.strategy),
        str(plan.guarantee),
        count_taken(result.plans),
        sum(proven_plan.plan.cycle_seconds for proven_plan in every),
        min(proven_plan.proof.clearance for proven_plan in every),
        min(distances, default=None),
        plan.digest,
        None if proof.holds else proof.violations[0].message,
        str(plan.strategy) if job.strategy == "both" else job.strategy,
        job.threshold or 0.0,
        job.seed,
        job.planning,
        len(every),
    )


def begin_task(
    state: State,
    entry: Entry,
    name: str,
    arguments: Mapping[str, Any],
    message: str,
    **about: Any,
) -> Begun:
    """A job begins; `about` goes into the `Job`, for when it ends."""
    job = Job(state.number, name, entry.at, **about)
    after = replace(without_approval(state), job=job, message=message)
    return after, (StartJob(job.number, name, arguments),)


def take_scan(
    state: State,
    entry: Entry,
    command: commands.TakeScan,
    then: commands.GoOn | None = None,
) -> Begun:
    """The scanner is triggered; with `then` it is gone on as that says."""
    arguments = {"seed": command.seed, "parts": command.parts, "part": command.part}
    return begin_task(state, entry, "scan", arguments, "scanning", then=then)


def find_parts(
    state: State,
    entry: Entry,
    command: commands.FindParts,
    then: commands.GoOn | None = None,
) -> Begun:
    """Parts are looked for in the scan; with `then` it is gone on as that says.

    Raises:
        CommandRefused: there is no scan.
    """
    if state.scan is None:
        raise CommandRefused("there is no scan to find parts in")
    arguments = {"scan": state.scan, "seed": command.seed, "overrides": command.overrides}
    return begin_task(
        state,
        entry,
        "localize",
        arguments,
        "finding parts",
        seed=command.seed,
        overrides=command.overrides,
        is_compared=command.is_compared,
        then=then,
    )


def sight_plate(state: State, entry: Entry, command: commands.SightPlate) -> Begun:
    """The plate is looked at, held in one more pose."""
    numbers = (observation.name.rpartition(" ")[2] for observation in state.observations)
    last = max((int(number) for number in numbers if number.isdecimal()), default=0)
    arguments = {
        "name": f"pose {last + 1}",
        "arm": command.arm,
        "q": command.q,
        "plate": command.plate,
        "seed": command.seed,
    }
    return begin_task(state, entry, "sight", arguments, "looking at the plate")


def make_plan(state: State, entry: Entry, command: commands.MakePlan) -> Begun:
    """A plan is made for the parts found.

    Raises:
        CommandRefused: there are none.
    """
    if not state.detections:
        raise CommandRefused("there are no parts to plan for")
    arguments = {
        "detections": state.detections,
        "scan_digest": state.scene_digest,
        "scan": state.scan,
        "strategy": command.strategy,
        "threshold": command.threshold,
        "overrides": command.overrides,
        "placed": state.placed,
        "avoided": avoided_parts(state, entry.at),
        "seed": command.seed,
    }
    state = replace(state, wanted_threshold=command.threshold)
    about = {
        "strategy": command.strategy,
        "threshold": command.threshold,
        "seed": command.seed,
        "planning": command.overrides,
    }
    return begin_task(state, entry, "plan", arguments, "planning", **about)


def gone_on(before: State, after: State, entry: Entry) -> Begun:
    """What follows by itself when the task of `before` has ended, where that was asked for."""
    job = before.job
    if job is None or job.then is None or after.job is not None:
        return after, ()
    match job.name, after.phase:
        case "scan", Phase.SCANNED:
            return find_parts(after, entry, job.then.find, then=job.then)
        case "localize", Phase.LOCALIZED:
            return make_plan(after, entry, job.then.plan)
        case "scan" | "localize", _:
            return replace(
                after, message=all_of((as_message(after.message), StateText.ENDS_HERE()))
            ), ()
        case _:
            return after, ()


def with_result(state: State, ended: commands.JobEnded, at: float) -> State:
    """The state after the running task has ended, at [s since the epoch]; others change nothing."""
    job, result = state.job, ended.result
    if job is None or job.number != ended.number:
        return state
    state = replace(state, job=None)
    match (job.name, result):
        case (_, JobCancelled()):
            return replace(state, message=StateText.TASK_CANCELLED(task=task_message(job.name)))
        case (_, WorkbenchError()):
            return replace(state, message=_failure_message(job, str(result)))
        case ("scan", Scan()):
            return with_scan(state, result, at)
        case ("localize", tuple()):
            search = Search(job.number, job.seed, job.overrides, result, max(0.0, at - job.at))
            return (compared if job.is_compared else with_detections)(state, search)
        case ("sight", PlateObservation()):
            observations = (*state.observations, result)
            message = f"{result.name}: the plate is seen, {len(observations)} so far"
            return replace(state, observations=observations, message=message)
        case ("emptying", Emptying()):
            return replace(state, emptying=result, message=emptying_words(result))
        case ("plan", PlanResult()):
            return with_plan(state, result, job)
        case _:
            wrong = type(result).__name__
            return replace(state, message=_failure_message(job, f"it brought a {wrong}"))


def _failure_message(job: Job, why: str) -> Message:
    return StateText.TASK_FAILED(task=task_message(job.name), why=plain(why))


def with_scan(state: State, scan: Scan, at: float) -> State:
    """The state with a new scan, taken at [s since the epoch]."""
    return begun(
        replace(state, avoided=after_one_more_scan(state.avoided, at), unscanned=None),
        ScanState,
        phase=Phase.SCANNED,
        scan=scan,
        scene_digest=scan.digest,
        stale="" if state.phase is Phase.DONE else stale_by(state, "there is a newer scan"),
        message=f"scan with {len(scan.points):,} points",
    )

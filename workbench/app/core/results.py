"""What tasks and people have brought: the state with parts found, with a plan, or with why not."""

from dataclasses import replace

from workbench.app.core.commands import Entry, UseDetections
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
from workbench.model.digest import digest_of
from workbench.model.plan import PlanResult, Proven, count_taken
from workbench.model.prediction import Emptying
from workbench.model.scan import Remark, Search

MOST_SEARCHES, MOST_REMARKS = 6, 30
"""In one scan, that are remembered."""

MOST_OUTLINES = 20
"""Plannings for the same parts that are remembered."""


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
        message=f"{counted(len(detections), 'part')} found",
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
        state,
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
        phase, message = Phase.LOCALIZED, f"no plan: {result.verdict}"
    elif result.proof is None or not result.proof.holds:
        phase = Phase.PLANNED
        why = result.proof.violations[0] if result.proof is not None else "there is none"
        message = f"a plan was found, but its proof does not hold: {why}"
    else:
        phase = Phase.PLANNED
        message = (
            f"plan ready: {result.plan.strategy}, {result.plan.cycle_seconds:.1f} s, "
            f"smallest clearance {result.proof.clearance * 1000:.1f} mm"
        )
        if result.row:
            message += f"; {counted(len(result.row), 'more plan')} in a row after it"
        if result.plan.stations:
            message += f"; {result.plan.note}"
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
    taken, parts = sum(one.taken for one in plain), sum(one.parts for one in plain)
    words = f"{taken} of {counted(parts, 'part')} taken out of {counted(len(plain), 'pile')}"
    tried = len({one.task.change for one in found.piles} - {""})
    return f"{words} in simulation" + (f"; {counted(tried, 'change')} tried" if tried else "")


def _outlines(state: State, result: PlanResult, job: Job) -> tuple[Outline, ...]:
    """All outlines; a plan that was made before keeps its place, by which people know it."""
    found = list(state.outlines)
    for one in (*result.beside, result):
        outline = _outline(one, job)
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
        return Outline(result.planner, planning, verdict=str(result.verdict))
    every = [Proven(plan, proof), *result.row]
    distances = [float(d.min()) for one in every for _, _, d in one.proof.apart if len(d)]
    return Outline(
        result.planner,
        planning,
        str(plan.strategy),
        str(plan.guarantee),
        count_taken(result.plans),
        sum(one.plan.cycle_seconds for one in every),
        min(one.proof.clearance for one in every),
        min(distances, default=None),
        plan.digest,
        "" if proof.holds else str(proof.violations[0]),
        str(plan.strategy) if job.strategy == "both" else job.strategy,
        job.threshold or 0.0,
        job.seed,
        job.planning,
        len(every),
    )

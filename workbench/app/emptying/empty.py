"""One pile taken out of the bin, plan after plan, as far as it goes."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from workbench.app.core.cycle.outcomes import AVOID_SCANS, MOST_FAILURES
from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.emptying.assemblies import TRUE_POSES, kits_possible
from workbench.app.emptying.bound import bound_of, holdable
from workbench.app.emptying.carrying import carry_out_plan
from workbench.app.emptying.film import Shot, unseen
from workbench.app.emptying.looking import from_next_view, scan_pile
from workbench.app.emptying.remaining_parts import as_seen, left_alone, left_in, summarize
from workbench.app.emptying.stirring import stir_pile
from workbench.app.emptying.tally import Tally, counts_of
from workbench.app.picking.pallets import boxes_around
from workbench.app.picking.pile_check import kinds_in_turn
from workbench.app.picking.row import plan_row
from workbench.app.picking.sightlines import seconds_seen, sees_from
from workbench.model.candidate import Reason, Verdict
from workbench.model.cell import Cell
from workbench.model.derived.assembling import standing_parts
from workbench.model.derived.by_recipe import kit_of, wanted_parts
from workbench.model.derived.by_view import views_of
from workbench.model.errors import JobCancelled
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.plan import Plan, PlanResult
from workbench.model.prediction import EmptiedPile, PileTask
from workbench.model.scan import Detection, Scene, SearchOverrides, Unexplained
from workbench.perception.scene.unexplained import look_around
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.planners.clock import working_time
from workbench.plugins.localizer import find_parts
from workbench.plugins.progress import Cancelled, Report, never, silent

IDLE = 3
"""Scans in a row without a plan after which the emptying ends, or one for each view if more."""

SEEDS = 1000
"""Each pile has this many seeds for its looks; no bin takes as many."""


def empty_pile(
    cell: Cell,
    task: PileTask,
    pile: Sequence[Detection],
    *,
    report: Report = silent,
    cancelled: Cancelled = never,
    film: Callable[[Shot], None] = unseen,
    estimates: bool = False,
) -> EmptiedPile:
    """Simulate picking a pile until no part can be taken, or several picks in a row fail.

    The result depends only on the arguments, except for the measured times.

    Args:
        cell: the cell, to which the change of the task is applied; its parts are in the pile.
        task: how the bin is emptied, with the seed.
        pile: poses of the parts, from `fallen`.
        report: receives the progress.
        cancelled: called repeatedly; True ends the emptying.
        film: receives every plan that is carried out.
        estimates: whether to estimate which of the remaining parts other grasps could hold.

    Raises:
        JobCancelled: `cancelled` returned True.
    """
    lying = list(enumerate(pile))
    tally = Tally()
    refusal: Verdict | None = None
    result: PlanResult | None = None
    avoided: list[tuple[Detection, int]] = []
    idle = failures = stirs = 0
    seen_for = 0.0
    most_idle = max(IDLE, len(views_of(cell)))
    most_stirs = cell.policy.stirs if task.stirs is None else task.stirs
    while lying and idle < most_idle and failures < MOST_FAILURES:
        if cancelled():
            raise JobCancelled(CancelText.EMPTYING())
        note = ProgressText.TAKEN(taken=tally.taken, count=task.count)
        report(tally.taken / max(task.count, 1), note)
        seed = (task.seed * SEEDS + tally.scans) % SEED_LIMIT
        tally.scans += 1
        avoided = [(detection, age - 1) for detection, age in avoided if age > 0]
        truth = [detection for _, detection in lying]
        finding, plannings = tally.finding, len(tally.planning)
        cell, result = _look_and_plan(
            cell, task, truth, avoided, tally, seed=seed, cancelled=cancelled
        )
        if seen_for:
            took = tally.finding - finding + sum(tally.planning[plannings:])
            tally.seen_in_motion.append((seen_for, took))
        seen_for = 0.0
        plan = None if result is None else result.plan
        if result is None or plan is None or result.proof is None or not result.proof.holds:
            has_pick = result is not None and any(
                candidate.verdict.is_ok for candidate in result.candidates
            )
            refusal = result.verdict if result is not None and has_pick else None
            # What is left alone for a while gets its turn before this counts as the end.
            idle += not avoided
            # As the rule of a cycle has it.
            is_late = result is not None and result.verdict.reason is Reason.OUT_OF_TIME
            may_stir = stirs < most_stirs and idle >= len(views_of(cell)) and not is_late
            if may_stir and _stir(cell, lying, tally, seed, film):
                stirs, idle = stirs + 1, 0
                continue
            cell, seconds = from_next_view(cell, seed=seed)
            tally.motion += seconds
            continue
        idle = stirs = 0
        tally.cycles += 1
        for plan in result.plans:
            shot, missed = carry_out_plan(cell, task, plan, lying, tally)
            film(shot)
            failures = _failures_in_a_row(failures, plan, missed)
            avoided += [(plan.detections[number], AVOID_SCANS) for number in missed]
            if missed:
                break
        else:
            last = result.plans[-1]
            seen_for = seconds_seen(last, sees_from(cell, last))
    end = _End(lying, refusal, result, failures >= MOST_FAILURES)
    return _record_pile(cell, task, tally, end, estimates=estimates)


def _failures_in_a_row(before: int, plan: Plan, missed: Sequence[int]) -> int:
    """Picks that have failed in a row; a part on a station has not come to its place yet."""
    if len(missed) == len(plan.arms):
        return before + len(missed)
    return before if plan.stations else 0


@dataclass(frozen=True, slots=True)
class _End:
    """How emptying ended: what lies there still, and what the last look brought."""

    lying: list[tuple[int, Detection]]
    refusal: Verdict | None
    result: PlanResult | None
    is_stopped: bool


def _record_pile(
    cell: Cell, task: PileTask, tally: Tally, end: _End, *, estimates: bool
) -> EmptiedPile:
    """The record of an emptied pile, with the reason why each part is left."""
    known = as_seen(end.lying, tally.seen)
    left = left_in(
        cell,
        known,
        refusal=end.refusal,
        looked=summarize(tally.seen, end.result),
        obstacles=boxes_around(cell, tally.assembled.placed),
        seed=task.seed,
        is_stopped=end.is_stopped,
        fixes=not task.change,
    )
    more = None
    rest = [detection for _, detection in end.lying]
    if task.bounds:
        bounds, more = bound_of(cell, rest, settles=task.settles, seed=task.seed)
        left = tuple(
            replace(left_part, any_grasp=found.message)
            for left_part, found in zip(left, bounds, strict=True)
        )
    return EmptiedPile(
        task,
        task.count,
        tally.taken,
        counts_of(tally.failed),
        tally.touches,
        tally.knocked_out,
        tally.cycles,
        tally.scans,
        tally.motion,
        left,
        tuple(tally.planning),
        tuple(tally.stages.items()),
        tally.finding,
        more,
        tally.rolled,
        tuple(tally.outcomes),
        tuple(tally.seen_in_motion),
        tally.warned_picks,
        tally.warned_touches,
        holdable(cell, rest, seed=task.seed) if estimates else None,
        (tally.assembled.complete, kits_possible(cell, task.count)) if kit_of(cell) else None,
        tally.stirs,
        tally.assembled.unmated,
    )


def fallen(plain: Cell, cell: Cell, task: PileTask) -> tuple[Detection, ...]:
    """The task's parts in the bin of `cell`, lying in it as they fall into that of `plain`.

    Raises:
        InputError: they do not fit.
    """
    pile = drop_parts(kinds_in_turn(plain, task.count), plain.bin, seed=task.seed)
    if not task.change:
        return pile
    step = cell.bin.T_world_bin * plain.bin.T_world_bin.inverse()
    return tuple(
        replace(detection, T_world_part=step * detection.T_world_part) for detection in pile
    )


def _look_and_plan(
    cell: Cell,
    task: PileTask,
    lying: Sequence[Detection],
    avoided: Sequence[tuple[Detection, int]],
    tally: Tally,
    *,
    seed: int,
    cancelled: Cancelled,
) -> tuple[Cell, PlanResult | None]:
    """A plan for what is seen, None when nothing is; and the cell by the view it begins at."""
    detections, digest = tuple(lying), TRUE_POSES
    around, assembled = Unexplained(), tally.assembled
    if task.seen == "scan":
        look = scan_pile(cell, (*lying, *assembled.truth), seed=seed)
        cell, scan = look.cell, look.scan
        tally.scans += look.scans - 1
        tally.motion += look.motion
        began = working_time()
        usual = SearchOverrides().detail
        found = find_parts(scan, cell, seed=seed, detail=usual, cancelled=cancelled)
        detections = found.detections
        boxes = assembled.boxes(cell, task, scan)
        around = look_around(cell, scan, detections, standing_parts(cell, boxes))
        tally.finding += look.merging + working_time() - began
        tally.seen = detections
        digest = scan.digest
    else:
        boxes = assembled.boxes(cell, task, None)
    obstacles = (*around.seen, *boxes)
    tally.known = Scene(digest, detections, obstacles)
    if not detections:
        return cell, None
    result = plan_row(
        cell,
        detections,
        digest,
        picks=task.picks,
        strategy=task.strategy,
        obstacles=obstacles,
        unseen=around.unseen,
        avoided=left_alone(detections, [detection for detection, _ in avoided]),
        wanted=wanted_parts(cell, Counter(assembled.kit)),
        seed=seed,
        cancelled=cancelled,
    )
    tally.planning.append(sum(result.seconds.values()))
    tally.stages.update(result.seconds)
    return cell, result


def _stir(
    cell: Cell,
    lying: list[tuple[int, Detection]],
    tally: Tally,
    seed: int,
    film: Callable[[Shot], None],
) -> bool:
    """Have a hand stir the parts; False where no plan for it is proven."""
    shot = stir_pile(cell, lying, tally.known, seed=seed)
    if shot is None:
        return False
    tally.cycles += 1
    tally.stirs += 1
    tally.motion += shot.plan.cycle_seconds
    tally.knocked_out += len(lying) - len(shot.after)
    lying[:] = shot.after
    film(shot)
    return True

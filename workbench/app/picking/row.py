"""Several plans after one scan, to be carried out one after the other."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

from workbench.app.picking.pipeline import NO_MESSAGES, best_of, plan_pick
from workbench.app.picking.proving import prove
from workbench.app.picking.regrasp import plan_regrasp
from workbench.app.picking.stations import put_down
from workbench.model.cell import MOST_PICKS, Cell
from workbench.model.derived.policies import picks_problem
from workbench.model.derived.row_parts import renumber, tool_change_in_row
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.message import Message
from workbench.model.messages.plans import PlanNote, RowEnd, strategy_message
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.messages.work import ProgressText
from workbench.model.plan import Plan, PlanResult, Proven
from workbench.model.recipes.joint import PlacingError
from workbench.model.recipes.kit import Wanted
from workbench.model.scan import Detection, Obstacle, Scan, Scene
from workbench.planning.collision.world import World
from workbench.planning.picking.assign import BOTH
from workbench.planning.placing.assembling import base_errors, mating_notes
from workbench.planning.placing.budget import NO_BASES
from workbench.planning.planners.clock import working_time
from workbench.plugins.progress import Report, rising, silent, within
from workbench.proof.claims.prove import may_have_moved, scene_after
from workbench.proof.claims.prove import prove as prove_in

USUALLY = 2 / 3
"""Share of the progress for a look that usually brings a plan, before one that is made else."""


def plan_row(  # noqa: PLR0913 - all that a request for a plan can say, by keyword
    cell: Cell,
    detections: tuple[Detection, ...],
    scan_digest: str,
    *,
    picks: int = 1,
    obstacles: tuple[Obstacle, ...] = (),
    unseen: tuple[Obstacle, ...] = (),
    avoided: Mapping[int, Message] = NO_MESSAGES,
    wanted: Wanted | None = None,
    strategy: str = "auto",
    report: Report = silent,
    **asked: Any,
) -> PlanResult:
    """As `plan_pick`, with further plans as long as the scan stays valid.

    Each plan is made and proven in the scene that the plans before leave (`scene_after`).  Every
    plan begins and ends at home.  Isolated parts go first, since a plan that takes a part of a heap
    ends the row.  With the strategy `both` each of the two has a row of its own; the better row is
    used, and either can be requested again.

    Args:
        cell: with its parts and policy.
        detections: the parts found, at least one.
        scan_digest: digest of the scan that shows them.
        picks: largest number of plans; a part that goes over a station takes two plans.
        obstacles: obstacles in the scan other than parts.
        unseen: space into which the obstacles may extend unseen.  Plans avoid it if possible;
            otherwise the note of the first plan states so.
        avoided: indices of parts that are not picked now, with the reason.
        wanted: how many parts of each kind the whole row may take; None: any number.
        strategy: as in `plan_pick`.
        report: receives the progress.
        asked: further arguments of `plan_pick`; and `bases`, see `mating_notes`.

    Raises:
        InputError: see `plan_pick`, or the cell does not state which parts may move.
        JobCancelled: see `plan_pick`.
    """
    check_picks(cell, picks)
    scene = Scene(scan_digest, detections, obstacles)
    report = rising(report)
    if unseen:
        clear = replace(scene, obstacles=(*obstacles, *unseen))
        first = within(report, 0.0, USUALLY)
        result = _rows(cell, clear, picks, avoided, strategy, first, wanted=wanted, **asked)
        if result.is_proven:
            return result
        report = within(report, USUALLY, 1.0)
    result = _rows(cell, scene, picks, avoided, strategy, report, wanted=wanted, **asked)
    return _add_note(result, PlanNote.GOES_UNSEEN()) if unseen and result.is_proven else result


def check_picks(cell: Cell, picks: int) -> None:
    """Check that a cell allows this many plans after one scan.

    Raises:
        InputError: they cannot.
    """
    if problem := picks_problem(replace(cell.policy, picks=picks)):
        raise InputError(ChangeRefusal.CELL(cell=cell.name, problem=problem))


def prove_row(
    cell: Cell,
    plans: Sequence[Plan],
    *,
    detections: Sequence[Detection] | None = None,
    scan: Scan | None = None,
) -> tuple[Proven, ...]:
    """Each plan with its proof in the scene that the plans before leave, while proofs hold.

    Args:
        cell: the present cell.
        plans: to be carried out in this order.
        detections: the parts known to be in the bin at first; see `proving.scene_of`.
        scan: in which they were found; see there.

    Raises:
        CommandRefused: a remaining part may have moved before a plan begins, or a plan of
            several changes a tool.
    """
    if problem := tool_change_in_row(plans):
        raise CommandRefused(problem)
    found = [Proven(plans[0], prove(cell, plans[0], detections=detections, scan=scan))]
    for number, (before, plan) in enumerate(pairwise(plans), 2):
        if not found[-1].proof.holds:
            break
        moved = may_have_moved(cell, before)
        if not before.stations and (moved is not None or cell.policy.pair_gap <= 0):
            why = ChangeRefusal.NO_PAIR_GAP() if moved is None else moved.message
            raise CommandRefused(ChangeRefusal.ROW_ORDER(number=number, before=number - 1, why=why))
        found.append(Proven(plan, prove_in(cell, scene_after(cell, before), plan)))
    return tuple(found)


def _rows(
    cell: Cell,
    scene: Scene,
    picks: int,
    avoided: Mapping[int, Message],
    strategy: str,
    report: Report,
    **asked: Any,
) -> PlanResult:
    """The row of a strategy, or the better one of those of `BOTH`."""
    if strategy != "both" or picks == 1:
        return _row(cell, scene, picks, avoided, report, strategy=strategy, **asked)
    rows = [
        _row(
            cell,
            scene,
            picks,
            avoided,
            _of_strategy(report, each_strategy, k, len(BOTH)),
            strategy=each_strategy,
            **asked,
        )
        for k, each_strategy in enumerate(BOTH)
    ]
    return best_of(cell, rows)


def _add_note(result: PlanResult, note: Message) -> PlanResult:
    """A result whose plan has one more remark."""
    assert result.plan is not None
    return replace(result, plan=replace(result.plan, notes=(*result.plan.notes, note)))


def _row(
    cell: Cell,
    scene: Scene,
    picks: int,
    avoided: Mapping[int, Message],
    report: Report,
    *,
    wanted: Wanted | None = None,
    bases: Mapping[str, PlacingError] = NO_BASES,
    **asked: Any,
) -> PlanResult:
    """A plan and those after it, all by one strategy."""
    left = dict(avoided)
    report_plan = within(report, 0.0, 1.0 / picks)
    first = _next(cell, scene, left, report_plan, is_last=picks == 1, wanted=wanted, **asked)
    first = _with_mating(cell, first, bases)
    if not first.is_proven or first.plan is None or picks == 1:
        return first
    row, done = list(first.row), 1
    began, latest = working_time(), first.plans
    ends: Message | None = None
    while ends is None and done < picks:
        for plan in latest:
            moved = may_have_moved(cell, plan)
            if moved is not None:
                ends = ends or renumber(moved.problem, first.plan, plan.detections)
            left, wanted = _carry_over(plan, left), _still_wanted(plan, wanted)
            bases = {**bases, **base_errors(cell, put_down(cell, plan))}
            scene = scene_after(cell, plan)
        if wanted is not None and not wanted.counts:
            ends = RowEnd.KIT_COMPLETE()
        if ends or not scene.detections:
            ends = ends or RowEnd.NO_PART()
            break
        done += 1
        report_plan = _of(report, done, picks)
        result = _next(
            cell, scene, left, report_plan, is_last=done == picks, wanted=wanted, **asked
        )
        result = _with_mating(cell, result, bases)
        if result.plan is None or result.proof is None:
            why = RowEnd.NO_PLAN(verdict=result.verdict.message)
            ends = renumber(why, first.plan, scene.detections)
        elif not result.proof.holds:
            why = RowEnd.REFUSED(violation=result.proof.violations[0].message)
            ends = renumber(why, first.plan, scene.detections)
        elif 1 + len(row) + len(result.plans) > MOST_PICKS:
            ends = RowEnd.MOST(count=MOST_PICKS)
        else:
            latest = result.plans
            row += [Proven(result.plan, result.proof), *result.row]
    seconds = {**first.seconds, "row": working_time() - began}
    return replace(first, row=tuple(row), row_ends=ends, seconds=seconds)


def _with_mating(cell: Cell, result: PlanResult, bases: Mapping[str, PlacingError]) -> PlanResult:
    """A result whose plans warn of parts with a low chance of mating with the assembly."""

    def warn(plan: Plan) -> Plan:
        notes = tuple(mating_notes(cell, plan, bases))
        return replace(plan, notes=(*plan.notes, *notes)) if notes else plan

    row = tuple(replace(proven, plan=warn(proven.plan)) for proven in result.row)
    return replace(result, plan=None if result.plan is None else warn(result.plan), row=row)


def _next(
    cell: Cell,
    scene: Scene,
    avoided: Mapping[int, Message],
    report: Report,
    *,
    is_last: bool,
    **asked: Any,
) -> PlanResult:
    """A plan for a scene, with isolated parts only if another plan is to follow.

    If no part can be brought to its place directly, there are two plans over a station.
    """

    def plan_once(left: Mapping[int, Message], begin: float, end: float) -> PlanResult:
        return plan_pick(
            cell,
            scene.detections,
            scene.scan_digest,
            obstacles=scene.obstacles,
            avoided=left,
            report=within(report, begin, end),
            **asked,
        )

    whole = USUALLY if cell.stations else 1.0
    world = World(cell, scene.detections, scene.obstacles)
    heaps = world.part_ways.heaps(cell.policy.pair_gap)
    heaped = {number for number, heap in enumerate(heaps) if heaps.count(heap) > 1}
    result: PlanResult | None = None
    if not is_last and heaped and len(heaped | set(avoided)) < len(heaps):
        lonely = {**dict.fromkeys(heaped, VerdictNote.TAKEN_LAST()), **avoided}
        result = plan_once(lonely, 0.0, USUALLY * whole)
    if result is None or not result.is_proven:
        result = plan_once(avoided, 0.0 if result is None else USUALLY * whole, whole)
    if result.is_proven or not cell.stations:
        return result
    report_rest = within(report, whole, 1.0)
    return plan_regrasp(cell, scene, result, avoided=avoided, report=report_rest, **asked)


def _carry_over(plan: Plan, avoided: Mapping[int, Message]) -> dict[int, Message]:
    """The avoided parts after a plan, by their indices among the remaining parts."""
    taken = {arm.detection for arm in plan.arms}
    stay = [number for number in range(len(plan.detections)) if number not in taken]
    return {stay.index(number): why for number, why in avoided.items() if number in stay}


def _still_wanted(plan: Plan, wanted: Wanted | None) -> Wanted | None:
    """The wanted parts after a plan; a part on a station continues with the next plan."""
    if wanted is None or plan.stations:
        return wanted
    return wanted.without([plan.detections[arm.detection].part for arm in plan.arms])


def _of_strategy(report: Report, strategy: str, number: int, count: int) -> Report:
    """Progress of the rows of one strategy, counted from 0, with its name before each note."""
    part, name = within(report, number / count, (number + 1) / count), strategy_message(strategy)
    return lambda done, note: part(done, ProgressText.OF_STRATEGY(strategy=name, step=note))


def _of(report: Report, number: int, count: int) -> Report:
    """Progress of one plan of a row, counted from 1, with its number before each note."""
    part = within(report, (number - 1) / count, number / count)
    return lambda done, note: part(
        done, ProgressText.PLAN_OF_ROW(number=number, count=count, step=note)
    )

"""The line from detections to a proven plan: one function for page, command line and studies."""

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from workbench.app.picking.judging import (
    JUDGED,
    Looked,
    count_hands,
    furthest_verdict,
    judge_candidates,
)
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import LIFT_NAMES, Cell, PlanOverrides, Policy
from workbench.model.derived.by_recipe import check_strategy
from workbench.model.derived.policies import widened
from workbench.model.derived.row_parts import count_taken
from workbench.model.errors import InputError
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.work import ProgressText
from workbench.model.plan import Plan, PlanResult, Proof
from workbench.model.recipes.kit import Wanted
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.planning.collision.world import World
from workbench.planning.picking.assign import BOTH, has_enough_picks, plan_first_feasible
from workbench.planning.picking.least_time import least_cycle
from workbench.planning.picking.propose import HandsLooked, levels_of, propose, search_candidates
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.misfit import misfit
from workbench.plugins.progress import Cancelled, Report, never, silent, within
from workbench.proof.claims.prove import prove

AS_THE_CELL = PlanOverrides()

FIRST, SEARCHED = 0.6, 0.8
"""Shares of the progress after which the libraries were tried, and grips searched."""

TIGHT = {Reason.TOOL_COLLISION, Reason.WITHIN_MARGIN, Reason.APPROACH_BLOCKED}
"""What fingers that arrive less open, or other lifts, may mend."""

TWO_ARMS = (*BOTH, "both")
"""Strategies that only two arms can follow."""

NOTHING: Mapping[int, Message] = MappingProxyType({})


def plan_pick(  # noqa: PLR0913 - all that a request for a plan can say, by keyword
    cell: Cell,
    detections: tuple[Detection, ...],
    scan_digest: str,
    *,
    strategy: str = "auto",
    threshold: float | None = None,
    overrides: PlanOverrides = AS_THE_CELL,
    obstacles: tuple[Obstacle, ...] = (),
    avoided: Mapping[int, Message] = NOTHING,
    wanted: Wanted | None = None,
    seed: int = 0,
    report: Report = silent,
    cancelled: Cancelled = never,
) -> PlanResult:
    """Judge candidates, choose, plan, and prove.

    Grasps of a priority below 0 are spares: they are checked, one priority after the other, only
    when no plan comes out of those before them, or one for fewer arms than could work; where one
    arm has work already, they get no more than half of the time.  Where no plan comes out of all,
    grips are searched for one part after the other, from the top, of those kinds whose library says
    so; and then the grasps are tried by `widened`, unless the policy says not to.

    Args:
        cell: with its parts and policy.
        detections: the parts found, at least one.
        scan_digest: what they were found in.
        strategy: see `check_strategy`.
        threshold: [m] distance between the parts; None takes the cell's policy.
        overrides: what this request changes of the cell's policy.
        obstacles: what the scan shows beside the parts.
        avoided: indices of parts that are left alone for now, and why; they stay obstacles.
        wanted: how many parts of each kind may be taken; None: any.  Where one alone is, an arm
            takes it whatever the strategy says of two.
        seed: of everything random.
        report: progress.
        cancelled: asked between candidates; True ends the work.

    Raises:
        InputError: no detections, or a strategy that is not known or not available.
        JobCancelled: `cancelled` said so.
    """
    if not detections:
        raise InputError(Refusal.NO_PARTS())
    check_strategy(cell, strategy)
    if wanted is not None:
        avoided = {**wanted.refusals([detection.part for detection in detections]), **avoided}
        is_last = sum(wanted.now.values()) == 1
        strategy = "auto" if is_last and strategy in TWO_ARMS else strategy
    policy = overrides.on(cell.policy)
    asked = _Asked(
        strategy,
        cell.policy.threshold if threshold is None else threshold,
        avoided,
        wanted,
        seed,
        within(report, 0.0, FIRST),
        cancelled,
        processor_time() + policy.seconds,
    )
    scene = Scene(scan_digest, detections, obstacles)
    world = World(cell, detections, obstacles, policy)
    result = _plan(world, scene, asked, _Stages(), _library_levels(cell))
    levels = _search_levels(cell, detections, avoided)
    if result.plan is None and levels:
        asked = replace(asked, report=within(report, FIRST, SEARCHED))
        world = World(cell, detections, obstacles, _widest(policy))
        found = _plan(world, scene, asked, _after(result), levels)
        if found.plan is not None or not result.candidates:
            result = replace(found, candidates=(*result.candidates, *found.candidates))
    if result.plan is None and _may_widen(cell, policy, result.candidates):
        asked = replace(asked, report=within(report, SEARCHED, 1.0))
        world = World(cell, detections, obstacles, widened(policy))
        wider = _plan(world, scene, asked, _after(result), _library_levels(cell))
        result = result if wider.plan is None else wider
    return result


@dataclass(frozen=True, slots=True)
class _Asked:
    """What a plan is asked for; `deadline` [s] of processor time ends the search."""

    strategy: str
    threshold: float
    avoided: Mapping[int, Message]
    wanted: Wanted | None
    seed: int
    report: Report
    cancelled: Cancelled
    deadline: float


def _may_widen(cell: Cell, policy: Policy, candidates: Sequence[Candidate]) -> bool:
    """Whether other lifts, or fingers less open, could take what was refused."""
    if not policy.as_needed:
        return False
    reasons = {candidate.verdict.reason for candidate in candidates}
    if policy.least_air is None and any(arm.tool.fingers for arm in cell.arms):
        return not reasons.isdisjoint({*TIGHT, Reason.EXTRACT_BLOCKED})
    return Reason.EXTRACT_BLOCKED in reasons and set(policy.lifts) != set(LIFT_NAMES)


Level = Callable[[World, HandsLooked], tuple[Candidate, ...]]
"""Proposes candidates in a world; see `propose` for what it reports to."""


def _widest(policy: Policy) -> Policy:
    """The policy by which grips are searched."""
    return widened(policy) if policy.as_needed else policy


def _library_levels(cell: Cell) -> list[Level]:
    """The grasps of the libraries, one level of priorities after the other."""
    return [
        lambda world, looked, level=level: propose(world, priorities=level, looked=looked)
        for level in levels_of(cell)
    ]


def _search_levels(
    cell: Cell, detections: Sequence[Detection], avoided: Container[int]
) -> list[Level]:
    """Grips of one part after the other, from the top, where libraries leave it to a search."""
    searching = {part.name for part in cell.parts if part.library.searches}
    lying = [
        (float(detection.T_world_part.translation[2]), number)
        for number, detection in enumerate(detections)
        if detection.part in searching and number not in avoided
    ]
    return [
        lambda world, looked, number=number: search_candidates(world, number, looked=looked)
        for _, number in sorted(lying, reverse=True)
    ]


def _plan(
    world: World,
    scene: Scene,
    asked: _Asked,
    stages: "_Stages",
    levels: Sequence[Level],
) -> PlanResult:
    """Search a plan in a world by one level of candidates after the other; see `plan_pick`."""
    world.deadline = asked.deadline
    half = processor_time() + (asked.deadline - processor_time()) / 2
    looked = Looked()
    results: list[PlanResult] = []
    for number, level in enumerate(levels):
        # The last tenth is for the proof.
        report = within(asked.report, 0.9 * number / len(levels), 0.9 * (number + 1) / len(levels))
        found = level(world, count_hands(report, asked.cancelled))
        stages.end("propose")
        # One arm alone would do: what is left of the time is for its plan.
        until = half if looked.picks and asked.strategy == "auto" else world.deadline
        judge_candidates(
            world,
            _without(asked.avoided, found),
            looked,
            seed=asked.seed,
            report=report,
            cancelled=asked.cancelled,
            until=until,
        )
        stages.end("resolve")
        is_last = number == len(levels) - 1 or processor_time() > until
        if not is_last and not has_enough_picks(
            world, looked.picks, asked.strategy, asked.threshold, asked.avoided, asked.wanted
        ):
            continue
        wanted = BOTH if asked.strategy == "both" else (asked.strategy,)
        if looked.picks:
            report(JUDGED, ProgressText.MOTION())
        results = [_attempt(world, scene, looked, asked, name, stages.branch()) for name in wanted]
        if any(result.plan is not None for result in results):
            break
        stages.began = working_time()
    return best_of(world.cell, results)


@dataclass(slots=True)
class _Stages:
    """The working time [s] of each stage of planning."""

    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("propose", "resolve"), 0.0)
    )
    began: float = field(default_factory=working_time)

    def end(self, stage: str) -> None:
        """Count the time since the last stage ended as that of this stage."""
        now = working_time()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self.began
        self.began = now

    def branch(self) -> "_Stages":
        """The same times up to now, to go on with separately."""
        return _Stages(dict(self.seconds))


def _after(result: PlanResult) -> _Stages:
    """The times of what was searched before, to go on with."""
    return _Stages(dict(result.seconds))


def _attempt(
    world: World,
    scene: Scene,
    looked: Looked,
    asked: _Asked,
    strategy: str,
    stages: _Stages,
) -> PlanResult:
    """Plan by one strategy, prove, and bound the cycle from below."""
    is_searched = any(part.library.searches for part in world.cell.parts)
    verdict = furthest_verdict(looked.candidates, is_searched=is_searched)
    plan, proof, bound = None, None, 0.0
    plans: tuple[Plan, ...] = ()
    if looked.picks:
        plans, verdict = plan_first_feasible(
            world,
            looked.picks,
            strategy,
            asked.threshold,
            scene.scan_digest,
            wanted=asked.wanted,
            seed=asked.seed,
            cancelled=asked.cancelled,
        )
        stages.end("route")
    if plans:
        asked.report(0.9, ProgressText.PROOF())
        plan, proof = _proven(world.cell, scene, plans)
        stages.end("prove")
        bound = least_cycle(world, plan, looked.picks)
        stages.end("route")
        plan = replace(plan, seconds=stages.seconds, notes=(*plan.notes, *_found_grips(plan)))
    return PlanResult(
        tuple(looked.candidates),
        plan,
        proof,
        verdict,
        stages.seconds,
        scene.obstacles,
        world.policy.planner,
        bound=bound,
    )


def _found_grips(plan: Plan) -> list[Message]:
    return [
        PlanNote.FOUND_GRIP(part=FoundPart(arm_plan.detection))
        for arm_plan in plan.arms
        if arm_plan.found is not None
    ]


def _proven(cell: Cell, scene: Scene, plans: Sequence[Plan]) -> tuple[Plan, Proof]:
    """The first of some plans whose proof holds, with that; where none does, the first of all.

    Of another than the first the note says why that was refused.
    """
    first = prove(cell, scene, plans[0])
    for plan in plans[1:] if not first.holds else ():
        proof = prove(cell, scene, plan)
        if proof.holds:
            why = PlanNote.QUICKER_REFUSED(violation=first.violations[0].message)
            return replace(plan, notes=(*plan.notes, why)), proof
    return plans[0], first


def _without(
    avoided: Mapping[int, Message], candidates: tuple[Candidate, ...]
) -> tuple[Candidate, ...]:
    """The candidates, those of avoided parts refused."""
    return tuple(
        replace(
            candidate,
            verdict=Verdict(Reason.DISABLED, Stage.PROPOSE, note=avoided[candidate.detection]),
        )
        if candidate.detection in avoided
        else candidate
        for candidate in candidates
    )


def best_of(cell: Cell, results: Sequence[PlanResult]) -> PlanResult:
    """Of several strategies what holds, can be sent, takes most and is quickest; others beside."""

    def rank(result: PlanResult) -> tuple[bool, bool, int, float]:
        plan, proof, plans = result.plan, result.proof, result.plans
        if plan is None or proof is None:
            return (True, True, 0, math.inf)
        is_misfit = any(misfit(each_plan, cell) for each_plan in plans)
        seconds = sum(each_plan.cycle_seconds for each_plan in plans)
        return (not proof.holds, is_misfit, -count_taken(plans), seconds)

    best, *others = sorted(results, key=rank)
    return replace(best, beside=tuple(others))


def judge(
    cell: Cell,
    detections: tuple[Detection, ...],
    *,
    obstacles: tuple[Obstacle, ...] = (),
    seed: int = 0,
    report: Report = silent,
    cancelled: Cancelled = never,
) -> tuple[Candidate, ...]:
    """Every candidate with its verdict, up to the place; see `plan_pick`."""
    count = count_hands(report, cancelled)

    def look(world: World, found: tuple[Candidate, ...], looked: Looked) -> None:
        judge_candidates(
            world,
            found,
            looked,
            seed=seed,
            report=report,
            cancelled=cancelled,
            until=world.deadline,
        )

    def looked_by(policy: Policy) -> Looked:
        world, looked = World(cell, detections, obstacles, policy), Looked()
        look(world, propose(world, looked=count), looked)
        return looked

    looked = looked_by(cell.policy)
    if not looked.picks and _may_widen(cell, cell.policy, looked.candidates):
        wider = looked_by(widened(cell.policy))
        looked = wider if wider.picks else looked
    world = World(cell, detections, obstacles, _widest(cell.policy))
    taken = {pick.candidate.detection for pick in looked.picks}
    for number, detection in enumerate(detections):
        if number not in taken and cell.part(detection.part).library.searches:
            look(world, search_candidates(world, number, looked=count), looked)
    return tuple(looked.candidates)

"""The steps from detections to a proven plan: one function for page, command line and studies."""

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from workbench.app.picking.judging import (
    ALL_JUDGED,
    Judged,
    count_hands,
    furthest_verdict,
    judge_candidates,
    may_widen,
    searching_policy,
)
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import Cell, PlanOverrides, Policy
from workbench.model.derived.by_recipe import check_strategy
from workbench.model.derived.by_tcp import by_each_tcp
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
from workbench.planning.picking.propose import (
    SEARCH_ROUNDS,
    HandsLooked,
    levels_of,
    propose,
    search_candidates,
)
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.misfit import misfit
from workbench.plugins.progress import Cancelled, Report, never, silent, within
from workbench.proof.claims.prove import prove

AS_THE_CELL = PlanOverrides()

LIBRARIES_TRIED, GRIPS_SEARCHED = 0.6, 0.8
"""Progress shares at which the libraries were tried, and grips searched."""

TWO_ARMS = (*BOTH, "both")
"""Strategies that only two arms can follow."""

PROVEN_TRIES = 2
"""Plans with found grips that are proven before the next part is searched."""

NO_MESSAGES: Mapping[int, Message] = MappingProxyType({})


def plan_pick(  # noqa: PLR0913 - all that a request for a plan can say, by keyword
    cell: Cell,
    detections: tuple[Detection, ...],
    scan_digest: str,
    *,
    strategy: str = "auto",
    threshold: float | None = None,
    overrides: PlanOverrides = AS_THE_CELL,
    obstacles: tuple[Obstacle, ...] = (),
    avoided: Mapping[int, Message] = NO_MESSAGES,
    wanted: Wanted | None = None,
    seed: int = 0,
    report: Report = silent,
    cancelled: Cancelled = never,
) -> PlanResult:
    """Check candidates, choose among them, plan, and prove.

    Planning stops at the first stage with a plan; each tries a tool's first TCP before the others:

    1. Grasps of priority 0 and above.
    2. Spare grasps (priority below 0), by priority.  They also serve when fewer arms have work than
       could; then they get at most half of the time.
    3. A grip search, part by part from the top, for kinds whose library allows it.
    4. Grasps as `widened` changes them, unless the policy forbids it.

    Args:
        cell: with its parts and policy.
        detections: the parts found, at least one.
        scan_digest: digest of the scan that shows them.
        strategy: see `check_strategy`.
        threshold: [m] distance between the parts; None takes the cell's policy.
        overrides: what this request changes of the cell's policy.
        obstacles: obstacles in the scan other than parts.
        avoided: indices of parts that are not picked now, with the reason; they stay obstacles.
        wanted: how many parts of each kind may be taken; None: any number.  If only one part is
            wanted, one arm takes it, even with a strategy for two.
        seed: of all random numbers.
        report: receives the progress.
        cancelled: called between candidates; True ends the work.

    Raises:
        InputError: no detections, or a strategy that is not known or not available.
        JobCancelled: `cancelled` returned True.
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
        within(report, 0.0, LIBRARIES_TRIED),
        cancelled,
        processor_time() + policy.seconds,
    )
    scene = Scene(scan_digest, detections, obstacles)
    result = _plan_by_each(cell, policy, scene, asked, _Stages(), _library_levels(cell))
    levels = _search_levels(cell, detections, avoided)
    if levels and not result.is_proven:
        asked = replace(asked, report=within(report, LIBRARIES_TRIED, GRIPS_SEARCHED))
        by, stages = searching_policy(policy), _after(result)
        found = _plan_by_each(cell, by, scene, asked, stages, levels, tries=PROVEN_TRIES)
        found = replace(found, candidates=(*result.candidates, *found.candidates))
        result = _better(result, found)
    if result.plan is None and may_widen(cell, policy, result.candidates):
        asked = replace(asked, report=within(report, GRIPS_SEARCHED, 1.0))
        by, stages = widened(policy), _after(result)
        wider = _plan_by_each(cell, by, scene, asked, stages, _library_levels(cell))
        result = result if wider.plan is None else _better(result, wider)
    return result


@dataclass(frozen=True, slots=True)
class _Asked:
    """The request of a plan; `deadline` [s] of processor time ends the search."""

    strategy: str
    threshold: float
    avoided: Mapping[int, Message]
    wanted: Wanted | None
    seed: int
    report: Report
    cancelled: Cancelled
    deadline: float


Level = Callable[[World, HandsLooked], tuple[Candidate, ...]]
"""Proposes candidates in a world; see `propose` for what it reports to."""


def _library_levels(cell: Cell) -> list[Level]:
    """The grasps of the libraries, one level of priorities after the other."""
    return [
        lambda world, looked, level=level: propose(world, priorities=level, looked=looked)
        for level in levels_of(cell)
    ]


def _search_levels(
    cell: Cell, detections: Sequence[Detection], avoided: Container[int]
) -> list[Level]:
    """Grips of one part after the other, from the top, in rounds; for parts that permit it."""
    searching = {part.name for part in cell.parts if part.library.searches}
    lying = [
        (float(detection.T_world_part.translation[2]), number)
        for number, detection in enumerate(detections)
        if detection.part in searching and number not in avoided
    ]
    return [
        lambda world, looked, number=number, round=round: search_candidates(
            world, number, round, looked=looked
        )
        for round in range(len(SEARCH_ROUNDS))
        for _, number in sorted(lying, reverse=True)
    ]


def _plan_by_each(
    cell: Cell,
    policy: Policy,
    scene: Scene,
    asked: _Asked,
    stages: "_Stages",
    levels: Sequence[Level],
    *,
    tries: int = 1,
) -> PlanResult:
    """As `_plan`, for one TCP after the other until a proof holds; with all candidates tried."""
    best: PlanResult | None = None
    judged: tuple[Candidate, ...] = ()
    cells, report = by_each_tcp(cell), asked.report
    share = 1 / len(cells)
    for number, each_cell in enumerate(cells):
        world = World(each_cell, scene.detections, scene.obstacles, policy)
        asked = replace(asked, report=within(report, number * share, (number + 1) * share))
        found = _plan(world, scene, asked, stages, levels, tries=tries)
        judged, stages = (*judged, *found.candidates), _after(found)
        best = found if best is None else _further(best, found)
        if best.is_proven or processor_time() > asked.deadline:
            break
    assert best is not None
    return replace(best, candidates=judged, seconds=stages.seconds)


def _further(result: PlanResult, later: PlanResult) -> PlanResult:
    """The better result; without plans the result whose verdict got further."""
    if result.plan is None and later.plan is None:
        return max(result, later, key=lambda each: list(Stage).index(each.verdict.stage))
    return _better(result, later)


def _plan(
    world: World,
    scene: Scene,
    asked: _Asked,
    stages: "_Stages",
    levels: Sequence[Level],
    *,
    tries: int = 1,
) -> PlanResult:
    """Search a plan in a world by one level of candidates after the other; see `plan_pick`.

    If a proof does not hold, up to `tries` plans of other candidates are proven.
    """
    world.deadline = asked.deadline
    half = processor_time() + (asked.deadline - processor_time()) / 2
    judged = Judged()
    best: PlanResult | None = None
    for number, level in enumerate(levels):
        # The last tenth is for the proof.
        report = within(asked.report, 0.9 * number / len(levels), 0.9 * (number + 1) / len(levels))
        proposed = level(world, count_hands(report, asked.cancelled))
        stages.end("propose")
        # One arm alone would do: what is left of the time is for its plan.
        until = half if judged.picks and asked.strategy == "auto" else world.deadline
        judge_candidates(
            world,
            _without(asked.avoided, proposed),
            judged,
            seed=asked.seed,
            report=report,
            cancelled=asked.cancelled,
            until=until,
        )
        stages.end("resolve")
        is_last = number == len(levels) - 1 or processor_time() > until
        if not is_last and not has_enough_picks(
            world, judged.picks, asked.strategy, asked.threshold, asked.avoided, asked.wanted
        ):
            continue
        wanted = BOTH if asked.strategy == "both" else (asked.strategy,)
        if judged.picks:
            report(ALL_JUDGED, ProgressText.MOTION())
        for _ in range(tries):
            found = best_of(
                world.cell,
                [_attempt(world, scene, judged, asked, name, stages.branch()) for name in wanted],
            )
            best = found if best is None else _better(best, found)
            if found.plan is None or found.is_proven:
                break
            judged.drop(found.plan)
        if best is not None and best.is_proven:
            break
        stages.began = working_time()
    assert best is not None
    return best


def _better(result: PlanResult, later: PlanResult) -> PlanResult:
    """A result whose proof holds, else the first with a plan, else the last."""
    return later if result.plan is None or (later.is_proven and not result.is_proven) else result


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
    """The times of the searches before, to continue with."""
    return _Stages(dict(result.seconds))


def _attempt(
    world: World,
    scene: Scene,
    judged: Judged,
    asked: _Asked,
    strategy: str,
    stages: _Stages,
) -> PlanResult:
    """Plan by one strategy, prove, and bound the cycle from below."""
    is_searched = any(part.library.searches for part in world.cell.parts)
    verdict = furthest_verdict(judged.candidates, is_searched=is_searched)
    plan, proof, bound = None, None, 0.0
    plans: tuple[Plan, ...] = ()
    if judged.picks:
        plans, verdict = plan_first_feasible(
            world,
            judged.picks,
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
        bound = least_cycle(world, plan, judged.picks)
        stages.end("route")
        plan = replace(plan, seconds=stages.seconds, notes=(*plan.notes, *_found_grips(plan)))
    return PlanResult(
        tuple(judged.candidates),
        plan,
        proof,
        verdict,
        stages.seconds,
        scene.obstacles,
        world.policy.planner,
        bound=bound,
    )


def _found_grips(plan: Plan) -> list[Message]:
    found = [FoundPart(arm.detection) for arm in plan.arms if arm.found is not None]
    return [PlanNote.FOUND_GRIP(parts=found)] if found else []


def _proven(cell: Cell, scene: Scene, plans: Sequence[Plan]) -> tuple[Plan, Proof]:
    """The first plan whose proof holds, with the proof; if none does, the first plan.

    If it is not the first plan, its note states why the first was refused.
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
    """The best result: proof holds, can be sent, most parts, then quickest; others in `beside`."""

    def rank(result: PlanResult) -> tuple[bool, bool, int, float]:
        plan, proof, plans = result.plan, result.proof, result.plans
        if plan is None or proof is None:
            return (True, True, 0, math.inf)
        is_misfit = any(misfit(each_plan, cell) for each_plan in plans)
        seconds = sum(each_plan.cycle_seconds for each_plan in plans)
        return (not proof.holds, is_misfit, -count_taken(plans), seconds)

    best, *others = sorted(results, key=rank)
    return replace(best, beside=tuple(others))

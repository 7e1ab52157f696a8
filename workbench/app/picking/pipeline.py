"""The line from detections to a proven plan: one function for page, command line and studies."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from workbench.model.candidate import Candidate, Pick, Reason, Stage, Verdict
from workbench.model.cell import LIFT_NAMES, Cell, PlanOverrides, Policy
from workbench.model.derived.by_recipe import check_strategy
from workbench.model.derived.policies import widened
from workbench.model.derived.row_parts import count_taken
from workbench.model.errors import InputError, JobCancelled
from workbench.model.messages.message import Message
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.plan import Plan, PlanResult, Proof
from workbench.model.recipes.kit import Wanted
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.planning.collision.world import World
from workbench.planning.picking.assign import BOTH, has_enough_picks, plan_first_feasible
from workbench.planning.picking.least_time import least_cycle
from workbench.planning.picking.lifts import lift_message
from workbench.planning.picking.propose import is_spare, levels_of, propose
from workbench.planning.picking.resolve import resolve
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.misfit import misfit
from workbench.plugins.progress import Cancelled, Report, never, silent, within
from workbench.proof.claims.prove import prove

AS_THE_CELL = PlanOverrides()

FIRST_SEARCH = 0.7
"""Share of the progress for the search by the policy itself, before that by the widened one."""

TIGHT = {Reason.TOOL_COLLISION, Reason.WITHIN_MARGIN, Reason.APPROACH_BLOCKED}
"""What fingers that arrive less open, or other lifts, may mend."""

TWO_ARMS = (*BOTH, "both")
"""Strategies that only two arms can follow."""

NOTHING: Mapping[int, Message] = MappingProxyType({})

TRIED, JUDGED = 0.2, 0.75
"""Shares of a look at candidates after which the hands were tried, and all candidates judged."""


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
    one is searched by `widened`, unless the policy says not to.

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
        within(report, 0.0, FIRST_SEARCH),
        cancelled,
        processor_time() + policy.seconds,
    )
    scene = Scene(scan_digest, detections, obstacles)
    stages = _Stages()
    result = _plan(World(cell, detections, obstacles, policy), scene, asked, stages)
    if not _may_widen(cell, policy, result.candidates) or result.plan is not None:
        return result
    asked = replace(asked, report=within(report, FIRST_SEARCH, 1.0))
    stages = _Stages(dict(result.seconds))
    wider = _plan(World(cell, detections, obstacles, widened(policy)), scene, asked, stages)
    return result if wider.plan is None else wider


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


def _plan(world: World, scene: Scene, asked: _Asked, stages: "_Stages") -> PlanResult:
    """Search a plan in a world, one level of priorities after the other; see `plan_pick`."""
    world.deadline = asked.deadline
    half = processor_time() + (asked.deadline - processor_time()) / 2
    looked = _Looked()
    results: list[PlanResult] = []
    levels = levels_of(world.cell)
    for number, level in enumerate(levels):
        # The last tenth is for the proof.
        report = within(asked.report, 0.9 * number / len(levels), 0.9 * (number + 1) / len(levels))
        found = propose(world, priorities=level, looked=_counting(report, asked.cancelled))
        stages.end("propose")
        # One arm alone would do: what is left of the time is for its plan.
        until = half if looked.picks and asked.strategy == "auto" else world.deadline
        _judge(
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


def _attempt(
    world: World,
    scene: Scene,
    looked: "_Looked",
    asked: _Asked,
    strategy: str,
    stages: _Stages,
) -> PlanResult:
    """Plan by one strategy, prove, and bound the cycle from below."""
    plan, proof, bound, verdict = None, None, 0.0, _summary(looked.candidates)
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
        plan = replace(plan, seconds=stages.seconds)
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

    def looked_by(policy: Policy) -> _Looked:
        world, looked = World(cell, detections, obstacles, policy), _Looked()
        found = propose(world, looked=_counting(report, cancelled))
        _judge(
            world,
            found,
            looked,
            seed=seed,
            report=report,
            cancelled=cancelled,
            until=world.deadline,
        )
        return looked

    looked = looked_by(cell.policy)
    if not looked.picks and _may_widen(cell, cell.policy, looked.candidates):
        wider = looked_by(widened(cell.policy))
        looked = wider if wider.picks else looked
    return tuple(looked.candidates)


@dataclass(slots=True)
class _Looked:
    """What was checked so far: candidates with their final verdicts, picks of those that work."""

    candidates: list[Candidate] = field(default_factory=list[Candidate])
    picks: list[Pick] = field(default_factory=list[Pick])
    working: dict[tuple[str, int], list[Candidate]] = field(
        default_factory=dict[tuple[str, int], list[Candidate]]
    )


def _counting(report: Report, cancelled: Cancelled) -> Callable[[int, int], None]:
    """Tells how many hands were tried, of how many, until `cancelled` ends that."""

    def count_hands(count: int, of: int) -> None:
        if cancelled():
            raise JobCancelled(CancelText.PLANNING())
        report(TRIED * count / of, ProgressText.HAND_CHECKS(number=count, count=of))

    return count_hands


def _judge(
    world: World,
    candidates: tuple[Candidate, ...],
    looked: _Looked,
    *,
    seed: int,
    report: Report,
    cancelled: Cancelled,
    until: float,
) -> None:
    """Give every candidate its final verdict; after `until` [s] of processor time: out of time."""
    for number, candidate in enumerate(candidates):
        if cancelled():
            raise JobCancelled(CancelText.PLANNING())
        done = TRIED + (JUDGED - TRIED) * number / len(candidates)
        report(done, ProgressText.CANDIDATES(number=number + 1, count=len(candidates)))
        verdict = candidate.verdict
        if verdict.is_ok:
            others = looked.working.setdefault((candidate.arm, candidate.detection), [])
            if processor_time() > until:
                verdict = Verdict(Reason.OUT_OF_TIME, verdict.stage)
            elif is_spare(candidate, others):
                note = VerdictNote.SPARE(grasp=others[0].grasp.name)
                verdict = Verdict(Reason.DISABLED, verdict.stage, note=note)
            else:
                result = resolve(world, candidate, seed=seed)
                if isinstance(result, Pick):
                    looked.picks.append(result)
                    others.append(candidate)
                    verdict = Verdict(Reason.OK, Stage.PLACE, note=_describe(world, result))
                else:
                    verdict = result
        if verdict is not candidate.verdict:
            candidate = replace(candidate, verdict=verdict)
        looked.candidates.append(candidate)


def _describe(world: World, pick: Pick) -> Message:
    """What to know of a candidate that works: how far it goes, its lift and its opening."""
    candidate = pick.candidate
    facts = [VerdictNote.DURATION(seconds=pick.seconds)]
    if len(world.policy.lifts) > 1:
        facts.append(VerdictNote.LIFT(lift=lift_message(pick.lift)))
    if world.policy.least_air is not None and world.arm(candidate.arm).tool.fingers:
        facts.append(VerdictNote.FINGERS(opening=candidate.grasp.opening))
    return VerdictNote.WORKS(facts=facts)


def _summary(candidates: Sequence[Candidate]) -> Verdict:
    """Why nothing works: the refusal of the candidate that got furthest."""
    if not candidates:
        note = VerdictNote.NO_GRASP()
        return Verdict(Reason.DISABLED, Stage.PROPOSE, note=note)
    stages = list(Stage)
    late = next((c.verdict for c in candidates if c.verdict.reason is Reason.OUT_OF_TIME), None)
    return late or max((c.verdict for c in candidates), key=lambda v: stages.index(v.stage))

"""Checks candidates in order, up to the place: whether each is feasible, or why not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from workbench.model.candidate import Candidate, Pick, Reason, Stage, Verdict
from workbench.model.cell import LIFT_NAMES, Cell, Policy
from workbench.model.derived.by_tcp import by_each_tcp
from workbench.model.derived.policies import widened
from workbench.model.errors import JobCancelled
from workbench.model.messages.message import Message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.plan import Plan
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.world import World
from workbench.planning.picking.lifts import lift_message
from workbench.planning.picking.propose import SEARCH_ROUNDS, is_spare, propose, search_candidates
from workbench.planning.picking.resolve import resolve
from workbench.planning.planners.clock import processor_time
from workbench.plugins.progress import Cancelled, Report, never, silent

HANDS_TRIED, ALL_JUDGED = 0.2, 0.75
"""Progress shares at which all hands were tried, and all candidates checked."""

TIGHT = {Reason.TOOL_COLLISION, Reason.APPROACH_BLOCKED}
"""Reasons that a smaller opening on arrival, or another lift, may resolve."""

SPARE_MARGIN = 0.0001
"""[m] Extra margin of found grips beyond the near margin: the proof is stricter than planning."""


@dataclass(slots=True)
class Judged:
    """Result of the check: candidates with final verdicts, and picks of the feasible ones."""

    candidates: list[Candidate] = field(default_factory=list[Candidate])
    picks: list[Pick] = field(default_factory=list[Pick])
    working: dict[tuple[str, int], list[Candidate]] = field(
        default_factory=dict[tuple[str, int], list[Candidate]]
    )

    def drop(self, plan: Plan) -> None:
        """Leave out the picks of a plan whose proof does not hold."""
        refused = {(arm.arm, arm.detection, arm.grasp) for arm in plan.arms}
        self.picks = [
            pick
            for pick in self.picks
            if (pick.candidate.arm, pick.candidate.detection, pick.candidate.grasp.name)
            not in refused
        ]


def count_hands(report: Report, cancelled: Cancelled) -> Callable[[int, int], None]:
    """Reports the number of tried hands and the total, until `cancelled` ends that."""

    def counted(count: int, of: int) -> None:
        if cancelled():
            raise JobCancelled(CancelText.PLANNING())
        report(HANDS_TRIED * count / of, ProgressText.HAND_CHECKS(number=count, count=of))

    return counted


def judge_candidates(
    world: World,
    candidates: tuple[Candidate, ...],
    judged: Judged,
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
        done = HANDS_TRIED + (ALL_JUDGED - HANDS_TRIED) * number / len(candidates)
        report(done, ProgressText.CANDIDATES(number=number + 1, count=len(candidates)))
        verdict = candidate.verdict
        if verdict.is_ok:
            others = judged.working.setdefault((candidate.arm, candidate.detection), [])
            if processor_time() > until:
                verdict = Verdict(Reason.OUT_OF_TIME, verdict.stage)
            elif is_spare(candidate, others):
                note = VerdictNote.SPARE(grasp=others[0].grasp.name)
                verdict = Verdict(Reason.DISABLED, verdict.stage, note=note)
            else:
                result = resolve(world, candidate, seed=seed)
                if isinstance(result, Pick):
                    judged.picks.append(result)
                    others.append(candidate)
                    verdict = Verdict(Reason.OK, Stage.PLACE, note=_describe(world, result))
                else:
                    verdict = result
        if verdict is not candidate.verdict:
            candidate = replace(candidate, verdict=verdict)
        judged.candidates.append(candidate)


def _describe(world: World, pick: Pick) -> Message:
    """Facts of a feasible candidate: its distance, its lift and its opening."""
    candidate = pick.candidate
    facts = [VerdictNote.DURATION(seconds=pick.seconds)]
    if len(world.policy.lifts) > 1:
        facts.append(VerdictNote.LIFT(lift=lift_message(pick.lift)))
    if world.policy.least_air is not None and world.arm(candidate.arm).tool.fingers:
        facts.append(VerdictNote.FINGERS(opening=candidate.grasp.opening))
    return VerdictNote.WORKS(facts=facts)


def furthest_verdict(candidates: Sequence[Candidate], *, is_searched: bool) -> Verdict:
    """Why no candidate is feasible: the refusal of the candidate that got furthest.

    Args:
        candidates: refused ones; there may be none.
        is_searched: whether grips were searched, and not only those of libraries tried.
    """
    if not candidates and is_searched:
        return Verdict(Reason.NO_GRIP, Stage.PROPOSE, note=VerdictNote.NO_GRIP())
    if not candidates:
        return Verdict(Reason.NO_GRASP, Stage.PROPOSE, note=VerdictNote.NO_GRASP())
    stages = list(Stage)
    late = next((c.verdict for c in candidates if c.verdict.reason is Reason.OUT_OF_TIME), None)
    return late or max((c.verdict for c in candidates), key=lambda v: stages.index(v.stage))


def may_widen(cell: Cell, policy: Policy, candidates: Sequence[Candidate]) -> bool:
    """Whether other lifts, or a smaller opening, could take what was refused."""
    if not policy.as_needed:
        return False
    reasons = {candidate.verdict.reason for candidate in candidates}
    if policy.least_air is None and any(arm.tool.fingers for arm in cell.arms):
        return not reasons.isdisjoint({*TIGHT, Reason.EXTRACT_BLOCKED})
    return Reason.EXTRACT_BLOCKED in reasons and set(policy.lifts) != set(LIFT_NAMES)


def searching_policy(policy: Policy) -> Policy:
    """The policy by which grips are searched."""
    wide = widened(policy) if policy.as_needed else policy
    return replace(wide, near_margin=wide.near_margin + SPARE_MARGIN)


def judge(
    cell: Cell,
    detections: tuple[Detection, ...],
    *,
    obstacles: tuple[Obstacle, ...] = (),
    seed: int = 0,
    report: Report = silent,
    cancelled: Cancelled = never,
) -> tuple[Candidate, ...]:
    """Every candidate with its verdict, up to the place; see `pipeline.plan_pick`."""
    count = count_hands(report, cancelled)

    def look(world: World, found: tuple[Candidate, ...], judged: Judged) -> None:
        judge_candidates(
            world,
            found,
            judged,
            seed=seed,
            report=report,
            cancelled=cancelled,
            until=world.deadline,
        )

    def judged_by(policy: Policy) -> Judged:
        judged = Judged()
        for each_cell in by_each_tcp(cell):
            world = World(each_cell, detections, obstacles, policy)
            look(world, propose(world, looked=count), judged)
        return judged

    judged = judged_by(cell.policy)
    if not judged.picks and may_widen(cell, cell.policy, judged.candidates):
        wider = judged_by(widened(cell.policy))
        judged = wider if wider.picks else judged
    taken = {pick.candidate.detection for pick in judged.picks}
    for each_cell in by_each_tcp(cell):
        world = World(each_cell, detections, obstacles, searching_policy(cell.policy))
        for number, detection in enumerate(detections):
            if number not in taken and cell.part(detection.part).library.searches:
                for round in range(len(SEARCH_ROUNDS)):
                    look(world, search_candidates(world, number, round, looked=count), judged)
    return tuple(judged.candidates)

"""Candidates judged one after the other, up to the place: whether each works, or why not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from workbench.model.candidate import Candidate, Pick, Reason, Stage, Verdict
from workbench.model.errors import JobCancelled
from workbench.model.messages.message import Message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.messages.work import CancelText, ProgressText
from workbench.planning.collision.world import World
from workbench.planning.picking.lifts import lift_message
from workbench.planning.picking.propose import is_spare
from workbench.planning.picking.resolve import resolve
from workbench.planning.planners.clock import processor_time
from workbench.plugins.progress import Cancelled, Report

TRIED, JUDGED = 0.2, 0.75
"""Shares of a look at candidates after which the hands were tried, and all candidates judged."""


@dataclass(slots=True)
class Looked:
    """What was checked so far: candidates with their final verdicts, picks of those that work."""

    candidates: list[Candidate] = field(default_factory=list[Candidate])
    picks: list[Pick] = field(default_factory=list[Pick])
    working: dict[tuple[str, int], list[Candidate]] = field(
        default_factory=dict[tuple[str, int], list[Candidate]]
    )


def count_hands(report: Report, cancelled: Cancelled) -> Callable[[int, int], None]:
    """Reports how many hands were tried, of how many, until `cancelled` ends that."""

    def counted(count: int, of: int) -> None:
        if cancelled():
            raise JobCancelled(CancelText.PLANNING())
        report(TRIED * count / of, ProgressText.HAND_CHECKS(number=count, count=of))

    return counted


def judge_candidates(
    world: World,
    candidates: tuple[Candidate, ...],
    looked: Looked,
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


def furthest_verdict(candidates: Sequence[Candidate], *, is_searched: bool) -> Verdict:
    """Why nothing works: the refusal of the candidate that got furthest.

    Args:
        candidates: refused ones; there may be none.
        is_searched: whether grips were searched, and not only those of libraries tried.
    """
    if not candidates and is_searched:
        return Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE, note=VerdictNote.NO_GRIP())
    if not candidates:
        return Verdict(Reason.DISABLED, Stage.PROPOSE, note=VerdictNote.NO_GRASP())
    stages = list(Stage)
    late = next((c.verdict for c in candidates if c.verdict.reason is Reason.OUT_OF_TIME), None)
    return late or max((c.verdict for c in candidates), key=lambda v: stages.index(v.stage))

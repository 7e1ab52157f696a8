"""Candidates, plans and proofs as JSON and in words; millimetres for people."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from workbench.cli.terminal import milliseconds, print_table
from workbench.model.candidate import Candidate, Verdict, label_grasp
from workbench.model.derived.row_parts import parts_taken, renumber
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.plans import cycle_words
from workbench.model.plan import Plan, Proof, Violation


def verdict_form(verdict: Verdict) -> dict[str, Any]:
    """A verdict with its evidence, without the configuration."""
    return {
        "reason": verdict.reason.name,
        "stage": str(verdict.stage),
        "pair": None if verdict.pair is None else list(verdict.pair),
        "distance_mm": _mm(verdict.distance),
        "note": "" if verdict.note is None else str(verdict.note),
        "said": verdict.message.program_form,
    }


def candidate_form(candidate: Candidate) -> dict[str, Any]:
    """A candidate with its verdict; parts are counted from 0, as in the plan."""
    return {
        "detection": candidate.detection,
        "grasp": candidate.grasp.name,
        "arm": candidate.arm,
        **({"tcp": candidate.tcp} if candidate.tcp else {}),
        **verdict_form(candidate.verdict),
    }


def plan_form(plan: Plan, bound: float) -> dict[str, Any]:
    """What a plan does, without its configurations, and what none can be quicker than [s]."""
    return {
        "digest": plan.digest,
        "strategy": str(plan.strategy),
        "guarantee": str(plan.guarantee),
        "arms": [
            {"arm": arm.arm, "detection": arm.detection, "grasp": arm.grasp}
            | ({"tcp": arm.tcp} if arm.tcp else {})
            for arm in plan.picks
        ],
        "cycle_s": round(plan.cycle_seconds, 3),
        "bound_s": round(bound, 3),
        "note": "; ".join(map(str, plan.remarks)),
        "notes": [remark.program_form for remark in plan.remarks],
    }


def proof_form(proof: Proof) -> dict[str, Any]:
    """What a proof says, without the clearance of every waypoint."""
    return {
        "holds": proof.holds,
        "checks": proof.checks,
        "resolution_mm": _mm(proof.resolution),
        "clearance_mm": _mm(proof.clearance),
        "nearest": None if proof.nearest is None else _place_form(proof.nearest),
        "violations": [_place_form(violation) for violation in proof.violations],
        "speeds": [
            {
                "arm": fast.arm,
                "leg": fast.leg,
                "tcp_mm": _mm(fast.tcp),
                "point_mm": _mm(fast.point),
                "mass_kg": fast.mass,
                "energy_j": fast.energy,
            }
            for fast in proof.speeds
        ],
    }


def plan_words(plan: Plan, bound: float, first: Plan | None = None) -> str:
    """A plan in a sentence, beside what none can be quicker than [s].

    Parts are called as in the `first` plan of its row.
    """
    first = first or plan
    taken = ", ".join(
        f"{arm.arm} {FoundPart(part)} by {label_grasp(arm.grasp, arm.tcp)}"
        for part, arm in zip(parts_taken(first, plan), plan.picks, strict=True)
    )
    if not taken:
        taken = "scanner between home and view"
        if plan.is_drop_plan:
            taken = f"drops back what it holds ({plan.arms[0].held})"
        elif plan.is_stir_plan or plan.is_tool_plan:
            taken = f"to {plan.arms[0].tool}" if plan.is_tool_plan else "stirs the parts"
    motion = f"motion of {cycle_words(plan.cycle_seconds, bound)}"
    words = f"{plan.strategy}, {plan.guarantee}: {taken}; {motion}"
    remarks = [str(renumber(remark, first, plan.detections)) for remark in plan.remarks]
    return f"{words} ({'; '.join(remarks)})" if remarks else words


def proof_words(proof: Proof, plan: Plan | None = None, first: Plan | None = None) -> str:
    """A proof in a sentence, or a line for each place; see `plan_words`."""

    def renumber_parts(violation: Violation) -> Message:
        said = violation.message
        return said if plan is None or first is None else renumber(said, first, plan.detections)

    if not proof.holds:
        problems = map(str, map(renumber_parts, proof.violations))
        return "\n  ".join(["the proof does not hold:", *problems])
    holds = f"the proof holds, {proof.checks} states checked"
    if proof.nearest is None or proof.nearest.pair is None:
        return holds
    return f"{holds}; {renumber_parts(proof.nearest)}"


def print_candidates(title: str, candidates: Sequence[Candidate]) -> None:
    """Every candidate with its verdict."""
    rows = (
        (
            f"part-{candidate.detection + 1}",
            candidate.grasp_label,
            candidate.arm,
            str(candidate.verdict.stage.message),
            str(candidate.verdict),
        )
        for candidate in candidates
    )
    print_table(title, ("part", "grasp", "arm", "stage", "verdict"), rows)


def reasons_words(candidates: Sequence[Candidate]) -> str:
    """How many candidates got which verdict, the most frequent first."""
    counts = Counter(str(candidate.verdict.kind.message) for candidate in candidates)
    return ", ".join(f"{count} {reason}" for reason, count in counts.most_common())


def stages_words(seconds: dict[str, float]) -> str:
    """Computing time of each stage."""
    return ", ".join(f"{stage} {milliseconds(s)} ms" for stage, s in seconds.items())


def _place_form(place: Violation) -> dict[str, Any]:
    return {
        "problem": str(place.problem),
        "said": place.message.program_form,
        "arm": place.arm,
        "leg": place.leg,
        "waypoint": place.waypoint,
        "pair": None if place.pair is None else list(place.pair),
        "distance_mm": _mm(place.distance),
    }


def _mm(metres: float | None) -> float | None:
    return None if metres is None else round(metres * 1000, 3)

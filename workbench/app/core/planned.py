"""What a planning has brought: the state with its plan, or with why there is none."""

from workbench.app.core.state import Outline, Phase, PlanState, State, begun
from workbench.model.plan import PlanResult

MOST_OUTLINES = 20
"""Plannings for the same parts that are remembered."""


def with_plan(state: State, result: PlanResult, threshold: float | None) -> State:
    """The state after a planning; what was said about an earlier plan goes.

    Args:
        state: before.
        result: what the planning brought; a plan whose proof does not hold is shown, too.
        threshold: [m] that it was asked for with.
    """
    if result.plan is None:
        phase, message = Phase.LOCALIZED, f"no plan: {result.verdict}"
    elif result.proof is None or not result.proof.holds:
        phase = Phase.PLANNED
        finding = result.proof.findings[0] if result.proof is not None else "there is none"
        message = f"a plan was found, but its proof does not hold: {finding}"
    else:
        phase = Phase.PLANNED
        message = (
            f"plan ready: {result.plan.strategy}, {result.plan.cycle_seconds:.1f} s, "
            f"smallest clearance {result.proof.clearance * 1000:.1f} mm"
        )
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
        outlines=(*state.outlines, *map(_outline, (*result.beside, result)))[-MOST_OUTLINES:],
        planned_threshold=threshold,
        wanted_threshold=state.wanted_threshold,
        message=message,
    )


def _outline(result: PlanResult) -> Outline:
    planning = sum(result.seconds.values())
    plan, proof = result.plan, result.proof
    if plan is None or proof is None:
        return Outline(result.planner, planning, verdict=str(result.verdict))
    distances = [float(d.min()) for _, _, d in proof.apart if len(d)]
    return Outline(
        result.planner,
        planning,
        str(plan.strategy),
        str(plan.guarantee),
        len(plan.arms),
        plan.cycle_seconds,
        proof.clearance,
        min(distances, default=None),
        plan.digest,
        "" if proof.holds else str(proof.findings[0]),
    )

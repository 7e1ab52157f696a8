"""What the plans do with each part that was found: which arm takes it, or why it is left."""

from collections.abc import Sequence

from workbench.app.core.state import State
from workbench.gui.texts.parts import PartsText
from workbench.model.candidate import Verdict
from workbench.model.derived.row_parts import PartFate, fates_of
from workbench.model.messages.message import Message


def part_fates(state: State) -> tuple[Message | None, ...]:
    """What the plans do with each part found, in its order; None where nothing is planned yet."""
    count = len(state.detections or ())
    is_planned = state.verdict is not None or any(plan.picks for plan in state.plans)
    if state.candidates is None or not is_planned:
        return (None,) * count
    # Of a plan that only stirs, the verdict is no reason to leave a part.
    why = state.verdict if state.plan is None else None
    is_stirred = any(plan.is_stir_plan for plan in state.plans)
    return tuple(
        _taken(fate.taken_by) if fate.taken_by else _left(fate, why, is_stirred=is_stirred)
        for fate in fates_of(state.plans, state.candidates, count)
    )


def _taken(arms: Sequence[str]) -> Message:
    """That a part is taken; from a station it is taken once more."""
    if len(set(arms)) > 1:
        return PartsText.TAKEN_BY_BOTH(arms=arms)
    return PartsText.TAKEN(arm=arms[0])


def _left(fate: PartFate, why: Verdict | None, *, is_stirred: bool) -> Message:
    """Why a part is left: the verdict of the candidate that got farthest.

    `why`: the verdict of the planning that found no plan, None with a plan; `is_stirred`: whether
    the plan stirs the parts, which no earlier candidate fits afterwards.
    """
    if fate.feasible:
        if why is not None:
            return PartsText.LEFT_WITHOUT_PLAN(verdict=why.message, count=fate.feasible)
        text = PartsText.LEFT_STIRRED if is_stirred else PartsText.LEFT_FOR_LATER
        return text(count=fate.feasible)
    best = fate.refused
    if best is None:
        return PartsText.LEFT_UNTRIED()
    return PartsText.LEFT(
        verdict=best.verdict.message, grasp=best.grasp_label, arm=best.arm, count=len(fate.tried)
    )

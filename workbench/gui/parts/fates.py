"""What the plans do with each part that was found: which arm takes it, or why it is left."""

from collections.abc import Sequence

from workbench.app.core.state import State
from workbench.gui.texts.parts import PartsText
from workbench.model.candidate import Candidate, Verdict
from workbench.model.derived.row_parts import parts_taken
from workbench.model.messages.message import Message


def part_fates(state: State) -> tuple[Message | None, ...]:
    """What the plans do with each part found, in its order; None where nothing is planned yet."""
    found = state.detections or ()
    plans = tuple(plan for plan in state.plans if plan.picks)
    if state.candidates is None or not (plans or state.verdict is not None):
        return (None,) * len(found)
    arms: dict[int, list[str]] = {}
    for plan in plans:
        for number, pick in zip(parts_taken(plans[0], plan), plan.picks, strict=True):
            arms.setdefault(number, []).append(pick.arm)
    tried: dict[int, list[Candidate]] = {}
    for candidate in state.candidates:
        tried.setdefault(candidate.detection, []).append(candidate)
    # Of a plan that only stirs, the verdict is no reason to leave a part.
    why = state.verdict if state.plan is None else None
    return tuple(
        _taken(arms[number]) if number in arms else _left(tried.get(number, []), why)
        for number in range(len(found))
    )


def _taken(arms: Sequence[str]) -> Message:
    """That a part is taken; from a station it is taken once more."""
    if len(set(arms)) > 1:
        return PartsText.TAKEN_BY_BOTH(arms=arms)
    return PartsText.TAKEN(arm=arms[0])


def _left(candidates: Sequence[Candidate], why: Verdict | None) -> Message:
    """Why a part is left: the verdict of the candidate that got farthest.

    `why`: the verdict of the planning that found no plan, None with a plan.
    """
    if not candidates:
        return PartsText.LEFT_UNTRIED()
    working = sum(candidate.verdict.is_ok for candidate in candidates)
    if working and why is not None:
        return PartsText.LEFT_WITHOUT_PLAN(verdict=why.message, count=working)
    if working:
        return PartsText.LEFT_FOR_LATER(count=working)
    best = max(candidates, key=lambda candidate: candidate.verdict.progress)
    return PartsText.LEFT(
        verdict=best.verdict.message, grasp=best.grasp_label, arm=best.arm, count=len(candidates)
    )

"""Which hands may hold a part that they should not, by the last sending and its outcome."""

from collections.abc import Iterator

from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import Outcome
from workbench.app.core.state import Phase, State, is_remembered, sent_for
from workbench.model.derived.row_parts import count_taken, parts_taken
from workbench.model.plan import Plan
from workbench.model.release import PickResult


def last_sent(state: State) -> tuple[Plan, ...]:
    """The plans that were sent last, the last one first; none where nothing was sent."""
    sent = sent_for(state)
    return () if sent is None else sent.plans[::-1]


def may_hold(state: State) -> bool:
    """Whether a hand may hold something that it should not, by the last sending.

    This is so after a fault, and after a pick of two parts, until a drop back or the next sending
    of a pick.
    """
    if state.hands_open and state.phase not in (Phase.SENDING, Phase.FAULT):
        return True
    has_ended = state.phase in (Phase.IDLE, Phase.DONE)
    results = (outcome for _, outcome in _parts_sent_for(state) if outcome is not None)
    is_odd = any(outcome.became is not PickResult.PICKED for outcome in results)
    return is_drop_next(state) or (has_ended and is_odd)


def is_drop_next(state: State) -> bool:
    """Whether a drop back comes next: after a fault, and after a pick of two parts."""
    if state.phase not in (Phase.IDLE, Phase.DONE):
        return False
    outcomes = [outcome for _, outcome in _parts_sent_for(state)]
    # A fault that was acknowledged leaves what was sent behind, and no word of its parts.
    is_open = state.phase is Phase.IDLE and any(outcome is None for outcome in outcomes)
    return is_open or any(
        outcome is not None and outcome.became is PickResult.DOUBLE for outcome in outcomes
    )


def _parts_sent_for(state: State) -> Iterator[tuple[str, Outcome | None]]:
    """The arm of each part of the last sending, and the outcome of the pick, if stated.

    Arms that have since dropped their part back are left out.
    """
    sent = sent_for(state)
    has_moved = state.phase in (Phase.SENDING, Phase.DONE, Phase.FAULT)
    if sent is None or not sent.plans or not (has_moved or is_remembered(state)):
        return
    outcomes = {outcome.detection: outcome for outcome in sent.outcomes}
    for plan in sent.plans:
        for number, arm in zip(parts_taken(sent.plans[0], plan), plan.picks, strict=True):
            if arm.arm not in state.hands_emptied:
                yield arm.arm, outcomes.get(number)


def arms_that_may_hold(state: State) -> frozenset[str]:
    """The arms that may still hold a part, since nobody has stated that it left the hand.

    A gripper's report of a part does not show that the part was placed.
    """
    plans = last_sent(state)
    has_ended = state.phase is Phase.DONE and not is_remembered(state)
    are_placed = has_ended and bool(plans) and state.parts_placed >= count_taken(plans[::-1])

    def may_still_hold(outcome: Outcome | None) -> bool:
        if outcome is not None and outcome.became is PickResult.DOUBLE:
            return True
        if outcome is None or are_placed:
            return not are_placed
        lost = (PickResult.FAILED, PickResult.DROPPED)
        return outcome.became not in lost and outcome.by == ROBOT_LINK

    held = (arm for arm, outcome in _parts_sent_for(state) if may_still_hold(outcome))
    return frozenset((*state.hands_open, *held))

"""Which hands may hold a part that they should not, by what was sent last and what came of it."""

from collections.abc import Iterator, Mapping

from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import Outcome
from workbench.app.core.state import Phase, State, is_remembered, sent_for
from workbench.model.derived.row_parts import count_taken, parts_taken
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.states import StateText
from workbench.model.plan import Plan
from workbench.model.release import PickResult


def last_sent(state: State) -> tuple[Plan, ...]:
    """The plans that were sent last, the last one first; none where nothing was sent."""
    sent = sent_for(state)
    return () if sent is None else sent.plans[::-1]


def may_hold(state: State) -> bool:
    """Whether a hand may hold something that it should not, by what was sent last.

    So it is after a fault, and where a part was not picked alone, until it was dropped back or
    parts were sent for anew.
    """
    if state.hands_open and state.phase not in (Phase.SENDING, Phase.FAULT):
        return True
    has_ended = state.phase in (Phase.IDLE, Phase.DONE)
    results = (outcome for _, _, outcome in _parts_sent_for(state) if outcome is not None)
    is_odd = any(outcome.became is not PickResult.PICKED for outcome in results)
    return is_drop_next(state) or (has_ended and is_odd)


def is_drop_next(state: State) -> bool:
    """Whether a drop back is what comes next: after a fault, and where a second part came."""
    if state.phase not in (Phase.IDLE, Phase.DONE):
        return False
    outcomes = [outcome for _, _, outcome in _parts_sent_for(state)]
    # A fault that was acknowledged leaves what was sent behind, and no word of its parts.
    is_open = state.phase is Phase.IDLE and any(outcome is None for outcome in outcomes)
    return is_open or any(
        outcome is not None and outcome.became is PickResult.DOUBLE for outcome in outcomes
    )


def _parts_sent_for(state: State) -> Iterator[tuple[str, int, Outcome | None]]:
    """The arm of each part that was sent for last, its index, and its outcome, as far as stated.

    Arms that have dropped back what they held since are left out.
    """
    sent = sent_for(state)
    has_moved = state.phase in (Phase.SENDING, Phase.DONE, Phase.FAULT)
    if sent is None or not sent.plans or not (has_moved or is_remembered(state)):
        return
    outcomes = {outcome.detection: outcome for outcome in sent.outcomes}
    for plan in sent.plans:
        for number, arm in zip(parts_taken(sent.plans[0], plan), plan.picks, strict=True):
            if arm.arm not in state.hands_emptied:
                yield arm.arm, number, outcomes.get(number)


def arms_that_may_hold(state: State) -> frozenset[str]:
    """The arms that have taken a part of which nobody has stated that it left the hand.

    A gripper that has felt a part says nothing of its place.
    """
    return frozenset(parts_in_hands(state))


def hands_message(state: State) -> Message | None:
    """Which hands may hold which parts, for people; None where no hand may hold any."""
    hands = [
        StateText.HAND_PARTS(arm=arm, parts=[FoundPart(number) for number in numbers])
        if numbers
        else StateText.HAND(arm=arm)
        for arm, numbers in sorted(parts_in_hands(state).items())
    ]
    return StateText.MAY_HOLD(hands=hands) if hands else None


def parts_in_hands(state: State) -> Mapping[str, tuple[int, ...]]:
    """By the arms that may hold a part: the parts' indices in what was sent for last.

    No index where a scan has come since.
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

    held: dict[str, tuple[int, ...]] = {arm: () for arm in state.hands_open}
    for arm, number, outcome in _parts_sent_for(state):
        if may_still_hold(outcome):
            held[arm] = (*held.get(arm, ()), number)
    return held

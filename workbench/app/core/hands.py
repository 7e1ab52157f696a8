"""Which hands may hold a part that they should not, by the last sending and its outcome."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import Outcome
from workbench.app.core.state import Phase, State, is_remembered, sent_for
from workbench.model.derived.row_parts import parts_taken
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import StateText
from workbench.model.plan import Plan
from workbench.model.release import PickResult


@dataclass(frozen=True, slots=True)
class Taken:
    """A part of the last sending.

    Attributes:
        number: index of the part in the first plan.
        arm: name of the arm that picks it.
        is_over: whether its plan has ended without a fault.
        outcome: outcome of the pick, if stated.
    """

    number: int
    arm: str
    is_over: bool
    outcome: Outcome | None


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
    outcomes = (taken.outcome for taken in _parts_not_let_go(state))
    is_odd = any(outcome and outcome.became is not PickResult.PICKED for outcome in outcomes)
    return is_drop_next(state) or (has_ended and is_odd)


def is_drop_next(state: State) -> bool:
    """Whether a drop back comes next: after a fault, and after a pick of two parts."""
    if state.phase not in (Phase.IDLE, Phase.DONE):
        return False
    # A fault that was acknowledged leaves what was sent behind.
    is_open = state.phase is Phase.IDLE and any(_still_holding(state))
    outcomes = (taken.outcome for taken in _parts_not_let_go(state))
    return is_open or any(out and out.became is PickResult.DOUBLE for out in outcomes)


def arms_that_may_hold(state: State) -> frozenset[str]:
    """The arms that may still hold a part, since nobody has stated that it left the hand."""
    return frozenset(parts_in_hands(state))


def full_hand_problem(state: State) -> Message | None:
    """Why the plans of the row may not be let out: a hand that takes a part may hold one still."""
    picking = {arm.arm for proven in state.whole_row for arm in proven.plan.picks}
    full = sorted(picking & arms_that_may_hold(state))
    return Refusal.HAND_MAY_HOLD(arms=full) if full else None


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
    """By the name of each arm that may hold a part: indices of its parts in the last sending.

    Without indices where a scan has come since.
    """
    held: dict[str, tuple[int, ...]] = {arm: () for arm in state.hands_open}
    for taken in _still_holding(state):
        held[taken.arm] = (*held.get(taken.arm, ()), taken.number)
    return held


def _still_holding(state: State) -> Iterator[Taken]:
    """The parts of the last sending that may still be in a hand.

    A gripper's report of a part does not show that the part was placed, nor does a person's report
    during the motion.  A plan that has ended without a fault has let go of its parts.
    """
    sent = sent_for(state)
    if sent is None or not sent.plans:
        return
    for taken in _parts_not_let_go(state):
        outcome = taken.outcome
        became = None if outcome is None else outcome.became
        is_felt = outcome is not None and (outcome.is_early or outcome.by == ROBOT_LINK)
        may_stay = became is None or (became is PickResult.PICKED and is_felt)
        if became is PickResult.DOUBLE or (may_stay and not taken.is_over):
            yield taken


def parts_taken_last(state: State) -> Iterator[Taken]:
    """Each part of the last sending."""
    sent = sent_for(state)
    has_moved = state.phase in (Phase.SENDING, Phase.DONE, Phase.FAULT)
    if sent is None or not sent.plans or not (has_moved or is_remembered(state)):
        return
    outcomes = {outcome.detection: outcome for outcome in sent.outcomes}
    for plan in sent.plans:
        is_over = sent.is_over or plan is not sent.plans[-1]
        for number, arm in zip(parts_taken(sent.plans[0], plan), plan.picks, strict=True):
            yield Taken(number, arm.arm, is_over, outcomes.get(number))


def _parts_not_let_go(state: State) -> Iterator[Taken]:
    """The parts whose arm has not dropped them back since, nor was confirmed to be empty."""
    return (taken for taken in parts_taken_last(state) if taken.arm not in state.hands_emptied)

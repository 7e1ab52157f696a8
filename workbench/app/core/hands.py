"""Which hands may hold a part that they should not, by what was sent last and what came of it."""

from collections.abc import Iterator
from dataclasses import dataclass

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
    """Whether a hand may hold something that it should not, by what was sent last.

    So it is after a fault, and where a part was not picked alone, until it was dropped back or
    parts were sent for anew.
    """
    if state.hands_open and state.phase not in (Phase.SENDING, Phase.FAULT):
        return True
    has_ended = state.phase in (Phase.IDLE, Phase.DONE)
    outcomes = (taken.outcome for taken in _parts_not_let_go(state))
    is_odd = any(outcome and outcome.became is not PickResult.PICKED for outcome in outcomes)
    return is_drop_next(state) or (has_ended and is_odd)


def is_drop_next(state: State) -> bool:
    """Whether a drop back is what comes next: after a fault, and where a second part came."""
    if state.phase not in (Phase.IDLE, Phase.DONE):
        return False
    # A fault that was acknowledged leaves what was sent behind.
    is_open = state.phase is Phase.IDLE and any(_still_holding(state))
    outcomes = (taken.outcome for taken in _parts_not_let_go(state))
    return is_open or any(out and out.became is PickResult.DOUBLE for out in outcomes)


def arms_that_may_hold(state: State) -> frozenset[str]:
    """The arms that have taken a part of which nobody has stated that it left the hand."""
    return frozenset((*state.hands_open, *_still_holding(state)))


def _still_holding(state: State) -> Iterator[str]:
    """Those of them that were sent for parts last.

    A gripper that has felt a part says nothing of its place, nor does who saw it picked while the
    robot moved.  A plan that has ended without a fault has let go of its parts.
    """
    sent = sent_for(state)
    if sent is None or not sent.plans:
        return
    are_placed = sent.is_over and sent.placed >= count_taken(sent.plans)
    for taken in _parts_not_let_go(state):
        outcome = taken.outcome
        became = None if outcome is None else outcome.became
        is_felt = outcome is not None and (outcome.is_early or outcome.by == ROBOT_LINK)
        if (
            became is PickResult.DOUBLE
            or (became is None and not are_placed)
            or (became is PickResult.PICKED and is_felt and not taken.is_over)
        ):
            yield taken.arm


@dataclass(frozen=True, slots=True)
class Taken:
    """A part that was sent for last, by its index in the first plan, and the arm for it.

    `is_over`: its plan has ended without a fault.  `outcome`: as far as somebody has stated one.
    """

    number: int
    arm: str
    is_over: bool
    outcome: Outcome | None


def parts_taken_last(state: State) -> Iterator[Taken]:
    """Each part that was sent for last."""
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
    """Those of them whose arm has not dropped back what it held since, nor was seen empty."""
    return (taken for taken in parts_taken_last(state) if taken.arm not in state.hands_emptied)

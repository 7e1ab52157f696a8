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
    results = (outcome for _, outcome in _parts_sent_for(state) if outcome is not None)
    is_odd = any(outcome.became is not PickResult.PICKED for outcome in results)
    return is_drop_next(state) or (has_ended and is_odd)


def is_drop_next(state: State) -> bool:
    """Whether a drop back is what comes next: after a fault, and where a second part came."""
    if state.phase not in (Phase.IDLE, Phase.DONE):
        return False
    # A fault that was acknowledged leaves what was sent behind.
    is_open = state.phase is Phase.IDLE and any(_still_holding(state))
    return is_open or any(
        outcome is not None and outcome.became is PickResult.DOUBLE
        for _, outcome in _parts_sent_for(state)
    )


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
    for taken, outcome in _parts_sent_for(state):
        became = None if outcome is None else outcome.became
        is_felt = outcome is not None and (outcome.is_early or outcome.by == ROBOT_LINK)
        if (
            became is PickResult.DOUBLE
            or (became is None and not are_placed)
            or (became is PickResult.PICKED and is_felt and not taken.is_over)
        ):
            yield taken.arm


@dataclass(frozen=True, slots=True)
class _Taken:
    """The arm that was sent for a part, and whether its plan has ended without a fault."""

    arm: str
    is_over: bool


def _parts_sent_for(state: State) -> Iterator[tuple[_Taken, Outcome | None]]:
    """Each part that was sent for last, and what became of it, as far as stated.

    Arms that have dropped back what they held since are left out.
    """
    sent = sent_for(state)
    has_moved = state.phase in (Phase.SENDING, Phase.DONE, Phase.FAULT)
    if sent is None or not sent.plans or not (has_moved or is_remembered(state)):
        return
    outcomes = {outcome.detection: outcome for outcome in sent.outcomes}
    for plan in sent.plans:
        is_over = sent.is_over or plan is not sent.plans[-1]
        for number, arm in zip(parts_taken(sent.plans[0], plan), plan.picks, strict=True):
            if arm.arm not in state.hands_emptied:
                yield _Taken(arm.arm, is_over), outcomes.get(number)

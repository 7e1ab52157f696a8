"""What a sending brings: the messages that went out, and how it ended."""

from dataclasses import replace

from workbench.app.core.commands import LinkEnded, ReportPick
from workbench.app.core.outcomes import escalated, outcome_problem, with_outcome
from workbench.app.core.rights import ROBOT_LINK
from workbench.app.core.state import Phase, State, counted
from workbench.model.release import Receipt


def with_receipt(state: State, receipt: Receipt) -> State:
    """The state after one more message went out."""
    message = f"{receipt.done} of {receipt.total} messages sent"
    return replace(state, receipts=(*state.receipts, receipt), message=message)


def after_sending(state: State, ended: LinkEnded, at: float) -> State:
    """The state after the robot link was closed.

    Args:
        state: while something was sent.
        ended: what the link says.
        at: when [s since the epoch].
    """
    # After a fault nobody knows: no other part is put where one may lie.
    state = replace(state, placed=(*state.placed, *(ended.placed or ())))
    for part in ended.parts:
        if part.is_picked is not None:
            said = ReportPick(part.detection, part.is_picked, part.why)
            # What somebody has reported meanwhile is not counted a second time.
            if not outcome_problem(state, said):
                state = with_outcome(state, said, ROBOT_LINK, at)
    state = replace(state, parts_placed=ended.parts_placed, part_reports=ended.parts)
    if ended.fault:
        message = f"fault while sending: {ended.fault}"
        return replace(state, phase=Phase.FAULT, fault=ended.fault, message=message)
    expected = len(state.plan.arms) if state.plan is not None else 0
    message = f"cycle finished, {ended.parts_placed} of {counted(expected, 'part')} reported placed"
    for part in ended.parts:
        if part.is_picked is False:
            message += f"; {part.arm} arm failed: {part.why}"
    return escalated(replace(state, phase=Phase.DONE, message=message))

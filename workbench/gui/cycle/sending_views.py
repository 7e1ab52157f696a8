"""How far a sending is: by the steps that the robot reports, not by the messages that went out."""

from workbench.app.core.cycle.sending import step_reported
from workbench.app.core.state import Phase, State
from workbench.gui.shared.views import line, message_text
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.messages.message import Message
from workbench.words.words import IN_ENGLISH, Words


def share_sent(state: State) -> float:
    """How much of all that is sent has been carried out, 0..1; 1 only once all has ended.

    Where a link reports no steps, a message that went out is carried out when the next one does.
    """
    plans, before = len(state.plans), len(state.sent_before)
    if not state.receipts or state.plan is None:
        return before / plans if plans else 0.0
    if state.phase is Phase.DONE:
        return (before + 1) / plans
    done, total = state.receipts[-1].done, state.receipts[-1].total
    if state.cell.controller.motion.reports_progress:
        done, total = step_reported(state), len(state.plan.sequence)
    return (before + max(done - 1, 0) / max(total, 1)) / plans


def send_line(state: State, words: Words = IN_ENGLISH) -> str:
    """How far the plan has gone out, and the robot with it."""
    purpose = "Sends the approved plan to the robot controller."
    if not state.receipts:
        text = "Nothing sent." if state.phase is Phase.APPROVED else ""
        return line(text, kind="hint", span=1, tip=purpose)
    last, step = state.receipts[-1], step_reported(state)
    sent = CyclePageText.MESSAGES_SENT(count=last.done, total=last.total)
    if step and state.plan is not None:
        sent = _step_message(state, step, len(state.plan.sequence))
    if len(state.plans) > 1:
        # They are counted anew for each plan of a row.
        sent = CyclePageText.SENT_OF_PLAN(sent=sent, number=len(state.sent_before) + 1)
    return line(message_text(sent, words), span=1, tip=purpose)


def _step_message(state: State, step: int, steps: int) -> Message:
    match state.phase:
        case Phase.FAULT:
            return CyclePageText.ENDED_IN_STEP(number=step, total=steps)
        case Phase.DONE:
            if steps == 1:
                return CyclePageText.STEP_DONE()
            return CyclePageText.STEPS_DONE(total=steps)
        case _:
            return CyclePageText.STEP(number=step, total=steps)

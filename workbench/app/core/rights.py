"""Whether a kind of command is allowed now, and to whom; the page asks this for every button."""

from collections.abc import Mapping

from workbench.app.core.command import Command
from workbench.app.core.people import MACHINES, Role
from workbench.app.core.state import Phase, State
from workbench.model.messages.cells import RecipeText, SlotText
from workbench.model.messages.message import Message, all_of, as_message, plain
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import NextText, task_message
from workbench.model.recipes.recipe import NO_RECIPE

MOST_SAID = 3
"""Largest number of changes in a sentence; the page has the whole list."""

NEXT: Mapping[Phase, NextText] = {
    Phase.IDLE: NextText.SCAN,
    Phase.SCANNED: NextText.FIND,
    Phase.LOCALIZED: NextText.PLAN,
    Phase.PLANNED: NextText.APPROVE,
    Phase.APPROVED: NextText.SEND,
    Phase.SENDING: NextText.WAIT,
    Phase.DONE: NextText.SCAN_AGAIN,
    Phase.FAULT: NextText.ACKNOWLEDGE,
}


def obstacle(state: State, command: type[Command]) -> Message | None:
    """Why a command of this type is not allowed now; None when it is.

    It checks only phase, running job and unacknowledged changes, so the page can ask it for every
    button.
    """
    right = command.right
    # What runs while something is sent is of the next cycle, and holds up nothing of this one.
    if state.job is not None and not right.beside_job and state.phase is not Phase.SENDING:
        return Refusal.TASK_RUNS(command=right.says(), task=task_message(state.job.name))
    if right.changes_cell and state.whole is not None and state.cell.recipe != NO_RECIPE:
        return RecipeText.CELL_FIXED(command=right.says(), number=state.cell.recipe)
    if right.plans and state.tools_unknown:
        return SlotText.UNKNOWN(arm=state.tools_unknown[0])
    if problem := command.obstacle(state):
        return problem
    missing = what_is_missing(state, command)
    if missing is None:
        return None
    return Refusal.NOT_NOW(command=right.says(), missing=missing)


def changes_said(state: State) -> Message:
    """The changes since the start before that nobody has acknowledged, in one sentence."""
    first, more = state.changed[:MOST_SAID], len(state.changed) - MOST_SAID
    changes = all_of(map(as_message, first)) or plain("")
    if more > 0:
        return Refusal.CHANGED_MORE(since=state.changed_since, changes=changes, count=more)
    return Refusal.CHANGED(since=state.changed_since, changes=changes)


def what_is_missing(state: State, command: type[Command]) -> Message | None:
    """What must happen before a command of this type is allowed; None when nothing."""
    right = command.right
    if command.is_in_phase(state):
        return None
    missing = (right.otherwise or NEXT[state.phase])()
    if state.phase is Phase.FAULT and state.fault:
        return Refusal.FAULT_FIRST(missing=missing, fault=state.fault)
    return missing


def lacks_right(state: State, command: type[Command], actor: str, role: Role) -> Message | None:
    """Why this person may not give a command of this type now; None when they may.

    Like `obstacle` it depends only on the type, so the page can ask it for every button.

    Args:
        state: says who is in control.
        command: its type.
        actor: the person's name; machines are not asked for a role, nor for control.
        role: the person's.
    """
    if actor in MACHINES:
        return None
    right = command.right
    if problem := lacks_role(command, role):
        return problem
    if state.control in ("", actor) or right.without_control:
        return None
    return Refusal.IN_CONTROL(person=state.control)


def lacks_role(command: type[Command], role: Role) -> Message | None:
    """Why a command of this type is for people of another role; None when it is not."""
    right = command.right
    if role.covers(right.role):
        return None
    return Refusal.OTHER_ROLE(command=right.says(), role=right.role.several(), yours=role.said())

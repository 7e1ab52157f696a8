"""Whether a kind of command is in order now, and whose it is; the page asks it for every button."""

from collections.abc import Mapping

from workbench.app.core.command import Command
from workbench.app.core.people import MACHINES, Role
from workbench.app.core.state import Phase, State
from workbench.model.messages.states import task_message

MOST_SAID = 3
"""So many changes are told in a sentence; the page has the whole list."""

NEXT: Mapping[Phase, str] = {
    Phase.IDLE: "take a scan first",
    Phase.SCANNED: "find the parts first",
    Phase.LOCALIZED: "make a plan first",
    Phase.PLANNED: "have the plan approved first",
    Phase.APPROVED: "send the plan, or make a new one",
    Phase.SENDING: "the plan is on its way to the robot; stop it or wait for the end",
    Phase.DONE: "the cycle is done and the bin has changed; take a new scan first",
    Phase.FAULT: "acknowledge the fault first",
}


def obstacle(state: State, command: type[Command]) -> str:
    """Why a command of this type is not in order now; empty when it is.

    It looks at phase, running task and changes since the start before only, so the page can ask
    it for every button.
    """
    right = command.right
    # What runs while something is sent is of the next cycle, and holds up nothing of this one.
    if state.job is not None and not right.beside_job and state.phase is not Phase.SENDING:
        job = task_message(state.job.name)
        return f"{right.says} has to wait until {job} ends or is cancelled"
    if problem := command.obstacle(state):
        return problem
    missing = what_is_missing(state, command)
    return f"{right.says} is not possible now: {missing}" if missing else ""


def changes_said(state: State) -> str:
    """What has changed since the start before and nobody has acknowledged, in one sentence."""
    first, more = state.changed[:MOST_SAID], len(state.changed) - MOST_SAID
    rest = f"; and {more} more" if more > 0 else ""
    return f"this has changed since {state.changed_since}: {'; '.join(first)}{rest}"


def what_is_missing(state: State, command: type[Command]) -> str:
    """What has to be done before a command of this type is in order; empty when nothing."""
    right = command.right
    if command.is_in_phase(state):
        return ""
    missing = right.otherwise or NEXT[state.phase]
    if state.phase is Phase.FAULT and state.fault:
        missing += f" ({state.fault})"
    return missing


def lacks_right(state: State, command: type[Command], actor: str, role: Role) -> str:
    """Why this person may not give a command of this type now; empty when they may.

    Like `obstacle` it looks at nothing but the type, so the page can ask it for every button.

    Args:
        state: says who is in control.
        command: its type.
        actor: the person's name; machines are not asked for a role, nor for control.
        role: the person's.
    """
    if actor in MACHINES:
        return ""
    right = command.right
    if problem := lacks_role(command, role):
        return problem
    if state.control in ("", actor) or right.without_control:
        return ""
    return f"{state.control} is in control; ask for control first"


def lacks_role(command: type[Command], role: Role) -> str:
    """Why a command of this type is for people of another role; empty when it is not."""
    right = command.right
    if role.covers(right.role):
        return ""
    return f"{right.says} is for {right.role}s; you are {role.said}"

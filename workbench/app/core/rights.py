"""When each command is in order, and whose it is: one table."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.app.core import commands
from workbench.app.core.people import FRONT_DOOR, MACHINES, POSES_FOLDER, Role
from workbench.app.core.state import Phase, State
from workbench.model.messages.states import task_message

MOST_SAID = 3
"""So many changes are told in a sentence; the page has the whole list."""

EVERY = frozenset(Phase)
SAFE = EVERY - {Phase.SENDING, Phase.FAULT}


@dataclass(frozen=True, slots=True)
class Right:
    """When a command is in order; `says` names it in refusals, `otherwise` what is missing.

    People give commands, except those `by_machine`; those `by_anybody` come from both.  `also_by`
    is the one machine that may give a command of people.  `role` is the least one that a person
    needs.  While somebody is in control, a command is theirs alone unless it passes
    `without_control`.
    """

    says: str
    phases: frozenset[Phase]
    otherwise: str = ""
    beside_job: bool = False
    by_machine: bool = False
    by_anybody: bool = False
    also_by: str | None = None
    role: Role = Role.OPERATOR
    without_control: bool = False


RIGHTS: Mapping[type, Right] = {
    commands.TakeScan: Right("a scan", SAFE),
    commands.UseScan: Right("using a scan from a file", SAFE),
    commands.FindParts: Right("finding parts", SAFE - {Phase.IDLE, Phase.DONE}),
    commands.UseDetections: Right("using poses from outside", SAFE, also_by=POSES_FOLDER),
    commands.MakePlan: Right(
        "planning", frozenset({Phase.LOCALIZED, Phase.PLANNED, Phase.APPROVED})
    ),
    commands.GoOn: Right("going on", frozenset({Phase.SENDING, Phase.DONE})),
    commands.WantThreshold: Right("another threshold", SAFE, beside_job=True),
    commands.ShortenRow: Right(
        "another length of the row", frozenset({Phase.PLANNED, Phase.APPROVED})
    ),
    # Several people may have to approve, each of whom has to see the plan: only one is in control.
    commands.WatchPlan: Right(
        "a preview", frozenset({Phase.PLANNED, Phase.APPROVED}), without_control=True
    ),
    commands.Approve: Right(
        "an approval", frozenset({Phase.PLANNED, Phase.APPROVED}), without_control=True
    ),
    commands.SendPlan: Right("sending", frozenset({Phase.APPROVED})),
    commands.NextStep: Right("a step", frozenset({Phase.SENDING}), "nothing is being sent"),
    # Nobody who sees that something goes wrong has to ask first.
    commands.Stop: Right(
        "a stop", frozenset({Phase.SENDING}), "nothing is being sent", without_control=True
    ),
    commands.ReportPick: Right(
        "the outcome of a pick",
        frozenset({Phase.SENDING, Phase.DONE, Phase.FAULT}),
        "nothing was sent",
        by_anybody=True,
        without_control=True,
    ),
    commands.ForgetAvoided: Right("forgetting what is avoided", SAFE),
    commands.CancelJob: Right("cancelling", EVERY, beside_job=True),
    commands.AcknowledgeFault: Right(
        "acknowledging", frozenset({Phase.FAULT}), "there is no fault"
    ),
    # While nothing moves, by whoever answers for the machine; a task that runs is not held up.
    commands.AcknowledgeChanges: Right(
        "acknowledging changes", SAFE, beside_job=True, role=Role.ENGINEER, without_control=True
    ),
    commands.EmptyPallets: Right("emptying the pallets", SAFE),
    commands.SightPlate: Right("a scan of the plate", SAFE, role=Role.ENGINEER),
    commands.UseObservations: Right(
        "a change of the calibration's poses", SAFE, role=Role.ENGINEER
    ),
    commands.ChangeCell: Right("a change of the cell", SAFE, role=Role.ENGINEER),
    commands.UndoCell: Right("an undo", SAFE, role=Role.ENGINEER),
    commands.RedoCell: Right("a redo", SAFE, role=Role.ENGINEER),
    commands.EditPart: Right("a change of grasps", SAFE, role=Role.ENGINEER),
    commands.ImportPart: Right("a new part", SAFE, role=Role.ENGINEER),
    commands.AddTool: Right("a new tool", SAFE, role=Role.ENGINEER),
    # It moves nothing, but it keeps the worker for itself, and is about how the cell is made.
    commands.TryEmptying: Right("emptying piles in simulation", SAFE, role=Role.ENGINEER),
    commands.DropDraft: Right("dropping a draft", SAFE, role=Role.ENGINEER),
    commands.SaveCell: Right("saving the cell", SAFE, role=Role.ENGINEER),
    commands.AskForControl: Right(
        "asking for control", EVERY, beside_job=True, without_control=True
    ),
    commands.TakeControl: Right("taking control", EVERY, beside_job=True, without_control=True),
    commands.GiveControl: Right("handing control over", EVERY, beside_job=True),
    commands.DenyControl: Right("keeping control", EVERY, beside_job=True),
    commands.ReleaseControl: Right(
        "giving control back", EVERY, beside_job=True, also_by=FRONT_DOOR
    ),
    commands.Started: Right("a start", EVERY, beside_job=True, by_machine=True),
    commands.Opened: Right("going on with a session", EVERY, beside_job=True, by_machine=True),
    commands.CellRead: Right("a new cell file", SAFE, by_machine=True),
    commands.PosesRefused: Right("a problem with poses", EVERY, beside_job=True, by_machine=True),
    commands.JobEnded: Right("the end of a task", EVERY, beside_job=True, by_machine=True),
    commands.Sent: Right(
        "a message sent", frozenset({Phase.SENDING}), "nothing is being sent", by_machine=True
    ),
    commands.LinkEnded: Right(
        "the end of sending", frozenset({Phase.SENDING}), "nothing is being sent", by_machine=True
    ),
}
"""Phase, role and control by command: whatever is not here does not happen."""

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


def obstacle(state: State, command: type) -> str:
    """Why a command of this type is not in order now; empty when it is.

    It looks at phase, running task and changes since the start before only, so the page can ask
    it for every button.
    """
    right = RIGHTS[command]
    # What runs while something is sent is of the next cycle, and holds up nothing of this one.
    if state.job is not None and not right.beside_job and state.phase is not Phase.SENDING:
        job = task_message(state.job.name)
        return f"{right.says} has to wait until {job} ends or is cancelled"
    if command is commands.CancelJob and state.job is None and state.ahead is None:
        return "no task is running"
    if command is commands.SendPlan and state.changed:
        return f"sending has to wait until an engineer acknowledges: {changes_said(state)}"
    if command is commands.GoOn and state.ahead is not None:
        return "it is gone on already once the plan lets the scanner see, or has ended"
    missing = what_is_missing(state, command)
    return f"{right.says} is not possible now: {missing}" if missing else ""


def changes_said(state: State) -> str:
    """What has changed since the start before and nobody has acknowledged, in one sentence."""
    first, more = state.changed[:MOST_SAID], len(state.changed) - MOST_SAID
    rest = f"; and {more} more" if more > 0 else ""
    return f"this has changed since {state.changed_since}: {'; '.join(first)}{rest}"


def what_is_missing(state: State, command: type) -> str:
    """What has to be done before a command of this type is in order; empty when nothing."""
    right = RIGHTS[command]
    if state.phase in right.phases:
        return ""
    if command is commands.ReportPick and state.phase is Phase.IDLE and state.unscanned:
        # Its plan is gone, and no scan shows the bin as it is now.
        return ""
    missing = right.otherwise or NEXT[state.phase]
    if state.phase is Phase.FAULT and state.fault:
        missing += f" ({state.fault})"
    return missing


def lacks_right(state: State, command: type, actor: str, role: Role) -> str:
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
    right = RIGHTS[command]
    if problem := lacks_role(command, role):
        return problem
    if state.control in ("", actor) or right.without_control:
        return ""
    return f"{state.control} is in control; ask for control first"


def lacks_role(command: type, role: Role) -> str:
    """Why a command of this type is for people of another role; empty when it is not."""
    right = RIGHTS[command]
    if role.covers(right.role):
        return ""
    return f"{right.says} is for {right.role}s; you are {role.said}"

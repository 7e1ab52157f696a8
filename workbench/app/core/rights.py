"""When each command is in order, and whose it is: one table."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.app.core.commands import (
    AcknowledgeFault,
    Approve,
    AskForControl,
    CancelJob,
    CellRead,
    ChangeCell,
    DenyControl,
    DropDraft,
    EditPart,
    EmptyPallets,
    FindParts,
    ForgetAvoided,
    GiveControl,
    ImportPart,
    JobEnded,
    LinkEnded,
    MakePlan,
    Opened,
    PosesRefused,
    RedoCell,
    ReleaseControl,
    ReportPick,
    SaveCell,
    SendPlan,
    Sent,
    SightPlate,
    Stop,
    TakeControl,
    TakeScan,
    UndoCell,
    UseDetections,
    UseScan,
    UseSightings,
    WantThreshold,
    WatchPlan,
)
from workbench.app.core.people import Role
from workbench.app.core.state import Phase, State

WORKER = "worker"
ROBOT_LINK = "robot link"
CELL_FILE = "cell file"
POSES_FOLDER = "poses folder"
FRONT_DOOR = "front door"
SESSION_START = "session start"
MACHINES = frozenset({WORKER, ROBOT_LINK, CELL_FILE, POSES_FOLDER, FRONT_DOOR, SESSION_START})
"""Actors that are not people; only they report what happened, and they may do nothing else."""

NOBODY = "operator"
"""Who acts in a browser without a login; an approval always has a name of its own."""

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
    TakeScan: Right("a scan", SAFE),
    UseScan: Right("using a scan from a file", SAFE),
    FindParts: Right("finding parts", SAFE - {Phase.IDLE, Phase.DONE}),
    UseDetections: Right("using poses from outside", SAFE, also_by=POSES_FOLDER),
    MakePlan: Right("planning", frozenset({Phase.LOCALIZED, Phase.PLANNED, Phase.APPROVED})),
    WantThreshold: Right("another threshold", SAFE, beside_job=True),
    # Several people may have to approve, each of whom has to see the plan: only one is in control.
    WatchPlan: Right("a preview", frozenset({Phase.PLANNED, Phase.APPROVED}), without_control=True),
    Approve: Right("an approval", frozenset({Phase.PLANNED, Phase.APPROVED}), without_control=True),
    SendPlan: Right("sending", frozenset({Phase.APPROVED})),
    # Nobody who sees that something goes wrong has to ask first.
    Stop: Right(
        "a stop", frozenset({Phase.SENDING}), "nothing is being sent", without_control=True
    ),
    ReportPick: Right(
        "the outcome of a pick",
        frozenset({Phase.SENDING, Phase.DONE, Phase.FAULT}),
        "nothing was sent",
        by_anybody=True,
        without_control=True,
    ),
    ForgetAvoided: Right("forgetting what is avoided", SAFE),
    CancelJob: Right("cancelling", EVERY, beside_job=True),
    AcknowledgeFault: Right("acknowledging", frozenset({Phase.FAULT}), "there is no fault"),
    EmptyPallets: Right("emptying the pallets", SAFE),
    SightPlate: Right("a scan of the plate", SAFE, role=Role.ENGINEER),
    UseSightings: Right("a change of the calibration's poses", SAFE, role=Role.ENGINEER),
    ChangeCell: Right("a change of the cell", SAFE, role=Role.ENGINEER),
    UndoCell: Right("an undo", SAFE, role=Role.ENGINEER),
    RedoCell: Right("a redo", SAFE, role=Role.ENGINEER),
    EditPart: Right("a change of grasps", SAFE, role=Role.ENGINEER),
    ImportPart: Right("a new part", SAFE, role=Role.ENGINEER),
    DropDraft: Right("dropping a draft", SAFE, role=Role.ENGINEER),
    SaveCell: Right("saving the cell", SAFE, role=Role.ENGINEER),
    AskForControl: Right("asking for control", EVERY, beside_job=True, without_control=True),
    TakeControl: Right("taking control", EVERY, beside_job=True, without_control=True),
    GiveControl: Right("handing control over", EVERY, beside_job=True),
    DenyControl: Right("keeping control", EVERY, beside_job=True),
    ReleaseControl: Right("giving control back", EVERY, beside_job=True, also_by=FRONT_DOOR),
    Opened: Right("going on with a session", EVERY, beside_job=True, by_machine=True),
    CellRead: Right("a new cell file", SAFE, by_machine=True),
    PosesRefused: Right("a problem with poses", EVERY, beside_job=True, by_machine=True),
    JobEnded: Right("the end of a task", EVERY, beside_job=True, by_machine=True),
    Sent: Right(
        "a message sent", frozenset({Phase.SENDING}), "nothing is being sent", by_machine=True
    ),
    LinkEnded: Right(
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

    It looks at phase and running task only, so the page can ask it for every button.
    """
    right = RIGHTS[command]
    if state.job is not None and not right.beside_job:
        return f"{right.says} has to wait until the task {state.job.name!r} ends or is cancelled"
    if command is CancelJob and state.job is None:
        return "no task is running"
    missing = what_is_missing(state, command)
    return f"{right.says} is not possible now: {missing}" if missing else ""


def what_is_missing(state: State, command: type) -> str:
    """What has to be done before a command of this type is in order; empty when nothing."""
    right = RIGHTS[command]
    if state.phase in right.phases:
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

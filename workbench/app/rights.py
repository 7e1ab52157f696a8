"""When each command is in order: one table, phase by command."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.app.commands import (
    AcknowledgeFault,
    Approve,
    CancelJob,
    CellRead,
    ChangeCell,
    DropDraft,
    EditPart,
    EmptyPallets,
    FindParts,
    ForgetAvoided,
    JobEnded,
    LinkEnded,
    MakePlan,
    PosesRefused,
    RedoCell,
    ReportPick,
    SaveCell,
    SendPlan,
    Sent,
    SightPlate,
    Stop,
    TakeScan,
    UndoCell,
    UseDetections,
    UseScan,
    UseSightings,
    WantThreshold,
    WatchPlan,
)
from workbench.app.state import Phase, State

WORKER = "worker"
ROBOT_LINK = "robot link"
CELL_FILE = "cell file"
POSES_FOLDER = "poses folder"
MACHINES = frozenset({WORKER, ROBOT_LINK, CELL_FILE, POSES_FOLDER})
"""Actors that are no persons; only they report what happened, and they may do nothing else."""

NOBODY = "operator"
"""Who acts in a browser without a login; an approval always has a name of its own."""

EVERY = frozenset(Phase)
SAFE = EVERY - {Phase.SENDING, Phase.FAULT}


@dataclass(frozen=True, slots=True)
class Right:
    """When a command is in order; `says` names it in refusals, `otherwise` what is missing.

    Commands are people's, but for those `by_machine` alone and those by anybody who knows.
    `also_by` is a machine that may give a command of people.
    """

    says: str
    phases: frozenset[Phase]
    otherwise: str = ""
    beside_job: bool = False
    by_machine: bool = False
    by_anybody: bool = False
    also_by: str | None = None


RIGHTS: Mapping[type, Right] = {
    TakeScan: Right("a scan", SAFE),
    UseScan: Right("using a scan from a file", SAFE),
    FindParts: Right("finding parts", SAFE - {Phase.IDLE, Phase.DONE}),
    UseDetections: Right("using poses from outside", SAFE, also_by=POSES_FOLDER),
    SightPlate: Right("a scan of the plate", SAFE),
    UseSightings: Right("a change of the calibration's poses", SAFE),
    MakePlan: Right("planning", frozenset({Phase.LOCALIZED, Phase.PLANNED, Phase.APPROVED})),
    WantThreshold: Right("another threshold", SAFE, beside_job=True),
    WatchPlan: Right("a preview", frozenset({Phase.PLANNED, Phase.APPROVED})),
    Approve: Right("an approval", frozenset({Phase.PLANNED, Phase.APPROVED})),
    SendPlan: Right("sending", frozenset({Phase.APPROVED})),
    Stop: Right("a stop", frozenset({Phase.SENDING}), "nothing is being sent"),
    ReportPick: Right(
        "the outcome of a pick",
        frozenset({Phase.SENDING, Phase.DONE, Phase.FAULT}),
        "nothing was sent",
        by_anybody=True,
    ),
    ForgetAvoided: Right("forgetting what is avoided", SAFE),
    CancelJob: Right("cancelling", EVERY, beside_job=True),
    AcknowledgeFault: Right("acknowledging", frozenset({Phase.FAULT}), "there is no fault"),
    ChangeCell: Right("a change of the cell", SAFE),
    UndoCell: Right("an undo", SAFE),
    RedoCell: Right("a redo", SAFE),
    EditPart: Right("a change of grasps", SAFE),
    DropDraft: Right("dropping a draft", SAFE),
    EmptyPallets: Right("emptying the pallets", SAFE),
    SaveCell: Right("saving the cell", SAFE),
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
"""Phase by command: whatever is not here does not happen."""

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

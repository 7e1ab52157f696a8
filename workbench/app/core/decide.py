"""What a command does to the state: one pure function, the only one that makes states.

    idle -> scanned -> localized -> planned -> approved -> sending -> done | fault

`rules.allowed` has let the command pass before; given the same state and entry, the outcome is
the same on every machine at any time, so a journal of entries is the history of states.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, assert_never

from workbench.app.core.cell_changes import cell_read, changed_cell, edited_cell, redone, undone
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
    Entry,
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
from workbench.app.core.control import with_control
from workbench.app.core.effects import (
    Effect,
    RemoveDraft,
    Send,
    StartJob,
    StopJob,
    StopSending,
    WriteCell,
)
from workbench.app.core.outcomes import after_one_more_scan, avoided_parts, with_outcome
from workbench.app.core.planned import with_plan
from workbench.app.core.release import (
    has_seen,
    opened_again,
    votes_of_others,
    without_approval,
)
from workbench.app.core.rules import approve
from workbench.app.core.sent import after_sending, with_receipt
from workbench.app.core.state import (
    Job,
    PartsState,
    Phase,
    RunState,
    ScanState,
    State,
    begun,
    counted,
    stale_by,
)
from workbench.model.calibration import PlateSighting
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, JobCancelled, WorkbenchError
from workbench.model.part import Part
from workbench.model.plan import PlanResult
from workbench.model.release import Vote
from workbench.model.scan import Remark, Scan, Search

Outcome = tuple[State, tuple[Effect, ...]]

MOST_SEARCHES, MOST_REMARKS = 6, 30
"""In one scan, that are remembered."""


def decide(state: State, entry: Entry) -> Outcome:
    """The state after an entry, and what has to be set in motion.

    Args:
        state: before.
        entry: a command that `rules.allowed` admits in this state.

    Raises:
        CommandRefused: an approval that `rules.approve` does not give.
    """
    state = replace(state, number=entry.number)
    match entry.command:
        case TakeScan(seed=seed, parts=parts, part=part):
            arguments = {"seed": seed, "parts": parts, "part": part}
            return _begin(state, entry, "scan", arguments, "scanning")
        case UseScan(scan=scan):
            return _with_scan(state, scan, entry.at), ()
        case FindParts() as command:
            return _find_parts(state, entry, command)
        case UseDetections() as command:
            return _with_outside_detections(state, entry, command), ()
        case SightPlate() as command:
            return _sight_plate(state, entry, command)
        case UseSightings(sightings=sightings, says=says):
            return replace(state, sightings=sightings, message=says), ()
        case MakePlan() as command:
            return _make_plan(state, entry, command)
        case WantThreshold(threshold=threshold):
            return replace(state, wanted_threshold=threshold), ()
        case WatchPlan(is_told=is_told):
            return _watched(state, entry.actor, is_told=is_told), ()
        case Approve():
            return _approved(state, entry), ()
        case SendPlan():
            return _send(state, entry)
        case Stop():
            return replace(state, message=f"{entry.actor} stops the sending"), (StopSending(),)
        case CancelJob():
            return _cancel(state, entry)
        case AcknowledgeFault():
            # Nobody knows how the bin looks after a fault: only a new scan can tell.
            message = f"fault acknowledged by {entry.actor}; take a new scan"
            return begun(replace(state, failures=0), ScanState, message=message), ()
        case ReportPick() as command:
            return with_outcome(state, command, entry.actor, entry.at), ()
        case ForgetAvoided():
            return replace(state, avoided=(), message="no part is avoided any more"), ()
        case ChangeCell(cell=cell, says=says):
            return changed_cell(state, cell, says)
        case UndoCell():
            return undone(state)
        case RedoCell():
            return redone(state)
        case EditPart() as edit:
            return edited_cell(state, edit)
        case ImportPart(name=name) as command:
            says = f"making the part {name} of {command.file}"
            return _begin(state, entry, "import", {"command": command}, says)
        case DropDraft(part=part):
            return replace(state, message=f"the draft of {part} is dropped"), (RemoveDraft(part),)
        case EmptyPallets():
            return replace(state, placed=(), message="the pallets are empty"), ()
        case SaveCell(remark=remark):
            write = WriteCell(state.cell, remark, entry.actor, entry.at)
            return replace(state, message=f"{entry.actor} saves the cell"), (write,)
        case (
            AskForControl() | TakeControl() | GiveControl() | DenyControl() | ReleaseControl()
        ) as about:
            return with_control(state, about, entry.actor), ()
        case Opened():
            return opened_again(state), ()
        case CellRead():
            return cell_read(state, entry.command)
        case PosesRefused(problem=problem):
            return replace(state, message=f"poses from outside cannot be used: {problem}"), ()
        case JobEnded(result=Part() as part) as ended:
            return _part_made(state, ended, part)
        case JobEnded():
            return _job_ended(state, entry.command, entry.at), ()
        case Sent(receipt=receipt):
            return with_receipt(state, receipt), ()
        case LinkEnded():
            return after_sending(state, entry.command, entry.at), ()
        case _:
            assert_never(entry.command)


def _begin(
    state: State,
    entry: Entry,
    name: str,
    arguments: Mapping[str, Any],
    message: str,
    **about: Any,
) -> Outcome:
    """A job begins; `about` goes into the `Job`, for when it ends."""
    job = Job(state.number, name, entry.at, **about)
    after = replace(without_approval(state), job=job, message=message)
    return after, (StartJob(job.number, name, arguments),)


def _watched(state: State, actor: str, *, is_told: bool) -> State:
    told, watched = state.told, state.watched
    if actor not in watched:
        watched, told = (*watched, actor), (*told, actor) if is_told else told
    elif not is_told:
        told = tuple(name for name in told if name != actor)
    message = "the plan was played to its end"
    if is_told:
        message = f"a program says that the plan was played to its end before {actor}"
    return replace(state, watched=watched, told=told, message=message)


def _find_parts(state: State, entry: Entry, command: FindParts) -> Outcome:
    if state.scan is None:
        raise CommandRefused("there is no scan to find parts in")
    arguments = {"scan": state.scan, "seed": command.seed, "wishes": command.wishes}
    about = {"seed": command.seed, "wishes": command.wishes}
    return _begin(state, entry, "localize", arguments, "finding parts", **about)


def _sight_plate(state: State, entry: Entry, command: SightPlate) -> Outcome:
    numbers = (one.name.rpartition(" ")[2] for one in state.sightings)
    last = max((int(number) for number in numbers if number.isdecimal()), default=0)
    arguments = {
        "name": f"pose {last + 1}",
        "arm": command.arm,
        "q": command.q,
        "plate": command.plate,
        "seed": command.seed,
    }
    return _begin(state, entry, "sight", arguments, "looking at the plate")


def _make_plan(state: State, entry: Entry, command: MakePlan) -> Outcome:
    if not state.detections:
        raise CommandRefused("there are no parts to plan for")
    arguments = {
        "detections": state.detections,
        "scan_digest": state.scene_digest,
        "scan": state.scan,
        "strategy": command.strategy,
        "threshold": command.threshold,
        "wishes": command.wishes,
        "placed": state.placed,
        "avoided": avoided_parts(state, entry.at),
        "seed": command.seed,
    }
    state = replace(state, wanted_threshold=command.threshold)
    about = {"threshold": command.threshold}
    return _begin(state, entry, "plan", arguments, "planning", **about)


def _approved(state: State, entry: Entry) -> State:
    if state.plan is None or state.proof is None:
        raise CommandRefused("there is no proven plan to approve")
    before = votes_of_others(state, entry.actor, entry.at)
    votes = (*before, Vote(state.plan.digest, entry.actor, entry.at))
    wanted = state.cell.approvers
    if len(votes) < wanted:
        message = f"approved by {_names(votes)}, {len(votes)} of {wanted} people"
        state = replace(state, phase=Phase.PLANNED, approval=None)
    else:
        unseen = [vote.actor for vote in votes if not has_seen(state, vote.actor)]
        approval = approve(
            state.cell,
            state.plan,
            state.proof,
            entry.actor,
            entry.at,
            before,
            is_unwatched=bool(unseen),
        )
        message = f"plan {state.plan.digest[:12]} approved by {_names(votes)}"
        if unseen:
            message += f"; no page has shown it to {' and '.join(unseen)}"
        state = replace(state, phase=Phase.APPROVED, approval=approval)
    return replace(state, votes=votes, message=message)


def _names(votes: tuple[Vote, ...]) -> str:
    return " and ".join(vote.actor for vote in votes)


def _send(state: State, entry: Entry) -> Outcome:
    if state.plan is None or state.approval is None:
        raise CommandRefused("there is no approved plan to send")
    message = f"{entry.actor} sends plan {state.plan.digest[:12]}"
    after = begun(state, RunState, phase=Phase.SENDING, message=message)
    return after, (Send(state.plan, state.approval),)


def _cancel(state: State, entry: Entry) -> Outcome:
    if state.job is None:
        return state, ()
    # The job leaves the state at once; whatever it still brings is recorded and not used.
    message = f"task {state.job.name!r} cancelled by {entry.actor}"
    return replace(state, job=None, message=message), (StopJob(state.job.number),)


def _job_ended(state: State, ended: JobEnded, at: float) -> State:
    job, result = state.job, ended.result
    if job is None or job.number != ended.number:
        return state
    state = replace(state, job=None)
    match (job.name, result):
        case (_, JobCancelled()):
            return replace(state, message=f"task {job.name!r} was cancelled")
        case (_, WorkbenchError()):
            return replace(state, message=f"task {job.name!r} failed: {result}")
        case ("scan", Scan()):
            return _with_scan(state, result, at)
        case ("localize", tuple()):
            search = Search(job.number, job.seed, job.wishes, result, max(0.0, at - job.at))
            return _with_detections(state, search)
        case ("sight", PlateSighting()):
            sightings = (*state.sightings, result)
            message = f"{result.name}: the plate is seen, {len(sightings)} so far"
            return replace(state, sightings=sightings, message=message)
        case ("plan", PlanResult()):
            return with_plan(state, result, job.threshold)
        case _:
            wrong = type(result).__name__
            return replace(state, message=f"task {job.name!r} failed: it brought a {wrong}")


def _part_made(state: State, ended: JobEnded, part: Part) -> Outcome:
    """The cell picks a new part too, as long as it was still wanted."""
    job = state.job
    if job is None or job.number != ended.number or job.name != "import":
        return state, ()
    cell = replace(state.cell, parts=(*state.cell.parts, part))
    return changed_cell(replace(state, job=None), cell, f"the part {part.name} is in the cell")


def _with_scan(state: State, scan: Scan, at: float) -> State:
    return begun(
        replace(state, avoided=after_one_more_scan(state.avoided, at)),
        ScanState,
        phase=Phase.SCANNED,
        scan=scan,
        scene_digest=scan.digest,
        stale="" if state.phase is Phase.DONE else stale_by(state, "there is a newer scan"),
        message=f"scan with {len(scan.points):,} points",
    )


def _with_detections(state: State, search: Search) -> State:
    detections = search.detections
    return begun(
        state,
        PartsState,
        phase=Phase.LOCALIZED if detections else Phase.SCANNED,
        searches=(*state.searches, search)[-MOST_SEARCHES:],
        detections=detections,
        scene_digest=state.scan.digest if state.scan is not None else "",
        stale=stale_by(state, "parts were looked for again"),
        message=f"{counted(len(detections), 'part')} found",
    )


def _with_outside_detections(state: State, entry: Entry, command: UseDetections) -> State:
    detections = command.detections
    says = command.says or f"{counted(len(detections), 'pose')} taken from outside"
    remark = Remark(entry.at, entry.actor, says)
    # Poses from another matcher usually belong to this scan, but never to a picked bin.
    is_picked = state.phase is Phase.DONE
    return begun(
        state,
        ScanState if is_picked else PartsState,
        phase=Phase.LOCALIZED,
        remarks=(*(() if is_picked else state.remarks), remark)[-MOST_REMARKS:],
        detections=detections,
        scene_digest=digest_of(detections),
        stale="" if is_picked else stale_by(state, "the parts are others"),
        message=f"{says}, by {entry.actor}",
    )

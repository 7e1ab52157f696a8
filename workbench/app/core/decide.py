"""What a command does to the state: one pure function, the only one that makes states.

    idle -> scanned -> localized -> planned -> approved -> sending -> done | fault

`rules.allowed` has let the command pass before; given the same state and entry, the outcome is
the same on every machine at any time, so a journal of entries is the history of states.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, assert_never

from workbench.app.core import commands
from workbench.app.core.cell_changes import (
    cell_read,
    changed_cell,
    edited_cell,
    redone,
    undone,
    with_made,
)
from workbench.app.core.control import with_control
from workbench.app.core.effects import (
    Effect,
    LetStep,
    RemoveDraft,
    Send,
    StartJob,
    StopJob,
    StopSending,
    WriteCell,
)
from workbench.app.core.outcomes import (
    after_one_more_scan,
    after_sending,
    avoided_parts,
    with_outcome,
    with_receipt,
    with_step,
)
from workbench.app.core.release import (
    acknowledged,
    has_seen,
    opened_again,
    shortened,
    started,
    votes_of_others,
    with_watched,
    without_approval,
)
from workbench.app.core.results import (
    compared,
    emptying_words,
    with_detections,
    with_outside_detections,
    with_plan,
)
from workbench.app.core.rows import following, row_said, with_next_plan
from workbench.app.core.rules import approve
from workbench.app.core.state import (
    Job,
    Phase,
    RunState,
    ScanState,
    State,
    begun,
    counted,
    stale_by,
)
from workbench.model.calibration import PlateObservation
from workbench.model.cell import Tool
from workbench.model.errors import CommandRefused, JobCancelled, WorkbenchError
from workbench.model.part import Part
from workbench.model.plan import PlanResult
from workbench.model.prediction import Emptying
from workbench.model.release import Vote, manner_words
from workbench.model.scan import Scan, Search

Outcome = tuple[State, tuple[Effect, ...]]


def decide(state: State, entry: commands.Entry) -> Outcome:
    """The state after an entry, and what has to be set in motion.

    Args:
        state: before.
        entry: a command that `rules.allowed` admits in this state.

    Raises:
        CommandRefused: an approval that `rules.approve` does not give.
    """
    state = replace(state, number=entry.number)
    match entry.command:
        case commands.TakeScan() as command:
            return _take_scan(state, entry, command)
        case commands.UseScan(scan=scan):
            return _with_scan(state, scan, entry.at), ()
        case commands.FindParts() as command:
            return _find_parts(state, entry, command)
        case commands.UseDetections() as command:
            return with_outside_detections(state, entry, command), ()
        case commands.SightPlate() as command:
            return _sight_plate(state, entry, command)
        case commands.UseObservations(observations=observations, says=says):
            return replace(state, observations=observations, message=says), ()
        case commands.MakePlan() as command:
            return _make_plan(state, entry, command)
        case commands.GoOn(scan=scan) as command:
            return _take_scan(state, entry, scan, then=command)
        case commands.WantThreshold(threshold=threshold):
            return _wanting(state, threshold), ()
        case commands.ShortenRow(picks=picks):
            return shortened(state, picks, entry.actor), ()
        case commands.WatchPlan(is_told=is_told):
            return with_watched(state, entry.actor, is_told=is_told), ()
        case commands.Approve() as vote:
            return _approved(state, entry, vote), ()
        case commands.SendPlan():
            return _send(state, entry)
        case commands.NextStep(number=number):
            return with_step(state, number, entry.actor, entry.at), (LetStep(number),)
        case commands.Stop():
            says = f"{entry.actor} stops the sending"
            return replace(state, message=says, stopped_by=entry.actor), (StopSending(),)
        case commands.CancelJob():
            return _cancel(state, entry)
        case commands.AcknowledgeFault():
            # Nobody knows how the bin looks after a fault: only a new scan can tell.
            message = f"fault acknowledged by {entry.actor}; take a new scan"
            return begun(replace(state, failures=0), ScanState, message=message), ()
        case commands.ReportPick() as command:
            return with_outcome(state, command, entry.actor, entry.at), ()
        case commands.ForgetAvoided():
            return replace(state, avoided=(), message="no part is avoided any more"), ()
        case commands.ChangeCell(cell=cell, says=says):
            return changed_cell(state, cell, says)
        case commands.UndoCell():
            return undone(state)
        case commands.RedoCell():
            return redone(state)
        case commands.EditPart() as edit:
            return edited_cell(state, edit)
        case commands.ImportPart(name=name) as command:
            says = f"making the part {name} of {command.file}"
            return _begin(state, entry, "import", {"command": command}, says)
        case commands.AddTool(arm=arm, drawn=drawn):
            says = f"making the tool {drawn.name} of {drawn.body.file}"
            return _begin(state, entry, "tool", {"arm": arm, "drawn": drawn}, says, arm=arm)
        case commands.TryEmptying(piles=piles, count=count) as command:
            says = f"emptying {counted(piles, 'pile')} of {counted(count, 'part')} in simulation"
            return _begin(state, entry, "emptying", {"command": command}, says)
        case commands.DropDraft(part=part):
            return replace(state, message=f"the draft of {part} is dropped"), (RemoveDraft(part),)
        case commands.EmptyPallets():
            return replace(state, placed=(), message="the pallets are empty"), ()
        case commands.SaveCell(remark=remark):
            write = WriteCell(state.cell, remark, entry.actor, entry.at)
            return replace(state, message=f"{entry.actor} saves the cell"), (write,)
        case (
            commands.AskForControl()
            | commands.TakeControl()
            | commands.GiveControl()
            | commands.DenyControl()
            | commands.ReleaseControl()
        ) as about:
            return _waiting_for(state, with_control(state, about, entry.actor)), ()
        case commands.AcknowledgeChanges():
            return acknowledged(state, entry.actor), ()
        case commands.Started() as start:
            return started(state, start), ()
        case commands.Opened():
            return opened_again(state), ()
        case commands.CellRead():
            return cell_read(state, entry.command)
        case commands.PosesRefused(problem=problem):
            return replace(state, message=f"poses from outside cannot be used: {problem}"), ()
        case commands.JobEnded(result=Part() | Tool() as made) as ended:
            return with_made(state, ended, made)
        case commands.JobEnded() as ended:
            return _gone_on(state, _job_ended(state, ended, entry.at), entry)
        case commands.Sent(receipt=receipt):
            return with_receipt(state, receipt), ()
        case commands.LinkEnded():
            ended = entry.command
            return with_next_plan(state, after_sending(state, ended, entry.at), ended, entry)
        case _:
            assert_never(entry.command)


def _begin(
    state: State,
    entry: commands.Entry,
    name: str,
    arguments: Mapping[str, Any],
    message: str,
    **about: Any,
) -> Outcome:
    """A job begins; `about` goes into the `Job`, for when it ends."""
    job = Job(state.number, name, entry.at, **about)
    after = replace(without_approval(state), job=job, message=message)
    return after, (StartJob(job.number, name, arguments),)


def _wanting(state: State, threshold: float) -> State:
    """The state in which another threshold is wanted, also of a plan that is gone on to."""
    job = state.job
    if job is not None and job.then is not None:
        then = replace(job.then, plan=replace(job.then.plan, threshold=threshold))
        state = replace(state, job=replace(job, then=then))
    return replace(state, wanted_threshold=threshold)


def _waiting_for(before: State, after: State) -> State:
    """The state after a word about control: nobody goes on in the name of who has given it away."""
    job = after.job
    if job is None or job.then is None or after.control == before.control:
        return after
    message = f"{after.message}; after this task nothing goes on by itself"
    return replace(after, job=replace(job, then=None), message=message)


def _gone_on(before: State, after: State, entry: commands.Entry) -> Outcome:
    """What follows by itself when the task of `before` has ended, where that was asked for."""
    job = before.job
    if job is None or job.then is None or after.job is not None:
        return after, ()
    match job.name, after.phase:
        case "scan", Phase.SCANNED:
            return _find_parts(after, entry, job.then.find, then=job.then)
        case "localize", Phase.LOCALIZED:
            return _make_plan(after, entry, job.then.plan)
        case "scan" | "localize", _:
            return replace(after, message=f"{after.message}; going on ends here"), ()
        case _:
            return after, ()


def _take_scan(
    state: State,
    entry: commands.Entry,
    command: commands.TakeScan,
    then: commands.GoOn | None = None,
) -> Outcome:
    arguments = {"seed": command.seed, "parts": command.parts, "part": command.part}
    return _begin(state, entry, "scan", arguments, "scanning", then=then)


def _find_parts(
    state: State,
    entry: commands.Entry,
    command: commands.FindParts,
    then: commands.GoOn | None = None,
) -> Outcome:
    if state.scan is None:
        raise CommandRefused("there is no scan to find parts in")
    arguments = {"scan": state.scan, "seed": command.seed, "overrides": command.overrides}
    return _begin(
        state,
        entry,
        "localize",
        arguments,
        "finding parts",
        seed=command.seed,
        overrides=command.overrides,
        is_compared=command.is_compared,
        then=then,
    )


def _sight_plate(state: State, entry: commands.Entry, command: commands.SightPlate) -> Outcome:
    numbers = (one.name.rpartition(" ")[2] for one in state.observations)
    last = max((int(number) for number in numbers if number.isdecimal()), default=0)
    arguments = {
        "name": f"pose {last + 1}",
        "arm": command.arm,
        "q": command.q,
        "plate": command.plate,
        "seed": command.seed,
    }
    return _begin(state, entry, "sight", arguments, "looking at the plate")


def _make_plan(state: State, entry: commands.Entry, command: commands.MakePlan) -> Outcome:
    if not state.detections:
        raise CommandRefused("there are no parts to plan for")
    arguments = {
        "detections": state.detections,
        "scan_digest": state.scene_digest,
        "scan": state.scan,
        "strategy": command.strategy,
        "threshold": command.threshold,
        "overrides": command.overrides,
        "placed": state.placed,
        "avoided": avoided_parts(state, entry.at),
        "seed": command.seed,
    }
    state = replace(state, wanted_threshold=command.threshold)
    about = {
        "strategy": command.strategy,
        "threshold": command.threshold,
        "seed": command.seed,
        "planning": command.overrides,
    }
    return _begin(state, entry, "plan", arguments, "planning", **about)


def _approved(state: State, entry: commands.Entry, vote: commands.Approve) -> State:
    if state.plan is None or state.proof is None:
        raise CommandRefused("there is no proven plan to approve")
    manner = vote.speed_share, vote.is_stepped
    before = votes_of_others(state, entry.actor, entry.at, manner)
    votes = (*before, Vote(state.plan.digest, entry.actor, entry.at, *manner))
    wanted, words = state.cell.approvers, manner_words(*manner)
    how = f", to be sent {words}" if words else ""
    if len(votes) < wanted:
        message = f"approved by {_names(votes)}, {len(votes)} of {wanted} people{how}"
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
            ran="" if state.ran is None else state.ran.digest,
            manner=manner,
            row=state.row,
        )
        message = f"{row_said(state)} approved by {_names(votes)}{how}"
        if unseen:
            message += f"; no page has shown it to {' and '.join(unseen)}"
        state = replace(state, phase=Phase.APPROVED, approval=approval)
    return replace(state, votes=votes, message=message)


def _names(votes: tuple[Vote, ...]) -> str:
    return " and ".join(vote.actor for vote in votes)


def _send(state: State, entry: commands.Entry) -> Outcome:
    if state.plan is None or state.approval is None:
        raise CommandRefused("there is no approved plan to send")
    message = f"{entry.actor} sends {row_said(state)}"
    until = state.approval.until
    after = begun(state, RunState, phase=Phase.SENDING, message=message, let_until=until)
    return after, (Send(state.plan, state.approval, following(state)),)


def _cancel(state: State, entry: commands.Entry) -> Outcome:
    if state.job is None:
        return state, ()
    # The job leaves the state at once; whatever it still brings is recorded and not used.
    message = f"task {state.job.name!r} cancelled by {entry.actor}"
    return replace(state, job=None, message=message), (StopJob(state.job.number),)


def _job_ended(state: State, ended: commands.JobEnded, at: float) -> State:
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
            search = Search(job.number, job.seed, job.overrides, result, max(0.0, at - job.at))
            return (compared if job.is_compared else with_detections)(state, search)
        case ("sight", PlateObservation()):
            observations = (*state.observations, result)
            message = f"{result.name}: the plate is seen, {len(observations)} so far"
            return replace(state, observations=observations, message=message)
        case ("emptying", Emptying()):
            return replace(state, emptying=result, message=emptying_words(result))
        case ("plan", PlanResult()):
            return with_plan(state, result, job)
        case _:
            wrong = type(result).__name__
            return replace(state, message=f"task {job.name!r} failed: it brought a {wrong}")


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

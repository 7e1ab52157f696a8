"""What a command does to the state: one pure function, the only one that makes states.

    idle -> scanned -> localized -> planned -> approved -> sending -> done | fault

`rules.allowed` has let the command pass before; given the same state and entry, the outcome is
the same on every machine at any time, so a journal of entries is the history of states.
"""

from dataclasses import replace
from typing import assert_never

from workbench.app.core import commands
from workbench.app.core.ahead import (
    after_the_end,
    asked_ahead,
    begun_ahead,
    brought_ahead,
    given_up,
)
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
    StopJob,
    StopSending,
    WriteCell,
)
from workbench.app.core.outcomes import (
    after_sending,
    before_a_scan,
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
)
from workbench.app.core.results import (
    begin_task,
    find_parts,
    gone_on,
    make_plan,
    sight_plate,
    take_scan,
    with_outside_detections,
    with_result,
    with_scan,
)
from workbench.app.core.rows import following, row_said, with_next_plan
from workbench.app.core.rules import approve
from workbench.app.core.state import (
    Phase,
    RunState,
    ScanState,
    State,
    begun,
    counted,
)
from workbench.model.cell import Tool
from workbench.model.errors import CommandRefused
from workbench.model.messages.message import all_of, as_message, plain
from workbench.model.messages.states import StateText, task_message
from workbench.model.part import Part
from workbench.model.release import Vote, manner_words

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
            return take_scan(state, entry, command)
        case commands.UseScan(scan=scan):
            return with_scan(state, scan, entry.at), ()
        case commands.FindParts() as command:
            return find_parts(state, entry, command)
        case commands.UseDetections() as command:
            return with_outside_detections(state, entry, command), ()
        case commands.SightPlate() as command:
            return sight_plate(state, entry, command)
        case commands.UseObservations(observations=observations, says=says):
            return replace(state, observations=observations, message=says), ()
        case commands.MakePlan() as command:
            return make_plan(state, entry, command)
        case commands.GoOn() as command if state.phase is Phase.SENDING:
            return asked_ahead(state, command, entry)
        case commands.GoOn(scan=scan) as command:
            return take_scan(state, entry, scan, then=command)
        case commands.WantThreshold(threshold=threshold):
            return _wanting(state, threshold), ()
        case commands.ShortenRow(picks=picks):
            return shortened(state, picks, entry.actor), ()
        case commands.WatchPlan(is_told=is_told):
            return with_watched(state, entry.actor, is_told=is_told), ()
        case commands.Approve() as vote:
            return _approve(state, entry, vote), ()
        case commands.SendPlan():
            return _send(state, entry)
        case commands.NextStep(number=number):
            return with_step(state, number, entry.actor, entry.at), (LetStep(number),)
        case commands.Stop():
            says = f"{entry.actor} stops the sending"
            stopped = replace(state, message=says, stopped_by=entry.actor)
            after, effects = given_up(stopped, "the plan is stopped")
            return after, (StopSending(), *effects)
        case commands.CancelJob():
            return _cancel(state, entry)
        case commands.AcknowledgeFault():
            # Nobody knows how the bin looks after a fault: only a new scan can tell.
            message = f"fault acknowledged by {entry.actor}; take a new scan"
            kept = replace(before_a_scan(state), failures=0)
            return begun(kept, ScanState, message=message), ()
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
            return begin_task(state, entry, "import", {"command": command}, says)
        case commands.AddTool(arm=arm, drawn=drawn):
            says = f"making the tool {drawn.name} of {drawn.body.file}"
            return begin_task(state, entry, "tool", {"arm": arm, "drawn": drawn}, says, arm=arm)
        case commands.TryEmptying(piles=piles, count=count) as command:
            says = f"emptying {counted(piles, 'pile')} of {counted(count, 'part')} in simulation"
            return begin_task(state, entry, "emptying", {"command": command}, says)
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
            return _waiting_for(state, with_control(state, about, entry.actor))
        case commands.AcknowledgeChanges():
            return acknowledged(state, entry.actor), ()
        case commands.Started() as start:
            return started(state, start), ()
        case commands.Opened():
            return opened_again(state), ()
        case commands.CellRead():
            return cell_read(state, entry.command)
        case commands.PosesRefused(problem=problem):
            return replace(state, message=StateText.POSES_REFUSED(problem=plain(problem))), ()
        case commands.JobEnded(result=Part() | Tool() as made) as ended:
            return with_made(state, ended, made)
        case commands.JobEnded() as ended if state.phase is Phase.SENDING:
            return brought_ahead(state, ended, entry)
        case commands.JobEnded() as ended:
            return gone_on(state, with_result(state, ended, entry.at), entry)
        case commands.Sent(receipt=receipt):
            return begun_ahead(with_receipt(state, receipt), entry)
        case commands.LinkEnded():
            ended = entry.command
            after = after_sending(state, ended, entry.at)
            after, sends = with_next_plan(state, after, ended, entry)
            after, effects = after_the_end(state, after, entry)
            return after, (*sends, *effects)
        case _:
            assert_never(entry.command)


def _wanting(state: State, threshold: float) -> State:
    """The state in which another threshold is wanted, also of a plan that is gone on to."""
    job = state.job
    if job is not None and job.then is not None:
        then = replace(job.then, plan=replace(job.then.plan, threshold=threshold))
        state = replace(state, job=replace(job, then=then))
    return replace(state, wanted_threshold=threshold)


def _waiting_for(before: State, after: State) -> Outcome:
    """The state after a word about control: nobody goes on in the name of who has given it away."""
    if after.ahead is not None and after.control != before.control:
        return given_up(after, "somebody else is in control, or nobody")
    job = after.job
    if job is None or job.then is None or after.control == before.control:
        return after, ()
    words = StateText.ENDS_AFTER_TASK()
    message = all_of((as_message(after.message), words))
    return replace(after, job=replace(job, then=None), message=message), ()


def _approve(state: State, entry: commands.Entry, vote: commands.Approve) -> State:
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
    if state.ahead is not None:
        return given_up(state, f"cancelled by {entry.actor}")
    if state.job is None:
        return state, ()
    # The job leaves the state at once; whatever it still brings is recorded and not used.
    message = StateText.CANCELLED_BY(task=task_message(state.job.name), person=entry.actor)
    return replace(state, job=None, message=message), (StopJob(state.job.number),)

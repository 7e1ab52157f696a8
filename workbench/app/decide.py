"""What a command does to the state: one pure function, the only one that makes states.

    idle -> scanned -> localized -> planned -> approved -> sending -> done | fault

`rules.allowed` has let the command pass before; given the same state and entry, the outcome is
the same on every machine at any time, so a journal of entries is the history of states.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, assert_never

import numpy as np

from workbench.app.commands import (
    AcknowledgeFault,
    Approve,
    CancelJob,
    CellRead,
    ChangeCell,
    EmptyPallets,
    Entry,
    FindParts,
    JobEnded,
    LinkEnded,
    MakePlan,
    PlanResult,
    RedoCell,
    SaveCell,
    SendPlan,
    Sent,
    Stop,
    TakeScan,
    UndoCell,
    UseDetections,
    UseScan,
)
from workbench.app.effects import Effect, Send, StartJob, StopJob, StopSending, UseCell, WriteCell
from workbench.app.rules import approve
from workbench.app.state import Job, Outline, Phase, State
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, JobCancelled, WorkbenchError
from workbench.model.plan import Plan
from workbench.model.release import Receipt
from workbench.model.scan import Detection, Scan
from workbench.planning.kinematics import Kinematics

Outcome = tuple[State, tuple[Effect, ...]]

MOST_UNDO = 50
"""Changes of the cell that can be undone."""

MOST_OUTLINES = 20
"""Plannings for the same parts that are remembered."""


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
        case TakeScan(seed=seed, parts=parts):
            arguments = {"seed": seed, "parts": parts}
            return _begin(state, "scan", arguments, digest_of(arguments), "scanning")
        case UseScan(scan=scan):
            return _with_scan(state, scan), ()
        case FindParts(seed=seed):
            return _find_parts(state, seed)
        case UseDetections(detections=detections, says=says):
            after = _with_outside_detections(state, detections)
            return replace(after, message=says) if says else after, ()
        case MakePlan() as command:
            return _make_plan(state, command)
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
            return _anew(state, message=message), ()
        case ChangeCell(cell=cell, says=says):
            return _changed_cell(state, cell, says)
        case UndoCell():
            cell, *before = state.before
            after, effects = _with_cell(state, cell, "the last change of the cell is undone")
            undone = (state.cell, *state.undone)[:MOST_UNDO]
            return replace(after, before=tuple(before), undone=undone), effects
        case RedoCell():
            cell, *undone = state.undone
            after, effects = _with_cell(state, cell, "the change of the cell is made again")
            before = (state.cell, *state.before)[:MOST_UNDO]
            return replace(after, before=before, undone=tuple(undone)), effects
        case EmptyPallets():
            return replace(state, placed=(), message="the pallets are empty"), ()
        case SaveCell(remark=remark):
            write = WriteCell(state.cell, remark, entry.actor, entry.at)
            return replace(state, message=f"{entry.actor} saves the cell"), (write,)
        case CellRead():
            return _cell_read(state, entry.command)
        case JobEnded(number=number, result=result):
            return _job_ended(state, number, result), ()
        case Sent(receipt=receipt):
            return _sent(state, receipt), ()
        case LinkEnded(fault=fault, parts_placed=parts_placed):
            return _link_ended(state, fault, parts_placed), ()
        case _:
            assert_never(entry.command)


def _begin(
    state: State, name: str, arguments: Mapping[str, Any], inputs_digest: str, message: str
) -> Outcome:
    job = Job(state.number, name, inputs_digest)
    # Whoever asks for something newer has taken back the word for what is there.
    phase = Phase.PLANNED if state.phase is Phase.APPROVED else state.phase
    after = replace(state, phase=phase, approval=None, job=job, message=message)
    return after, (StartJob(job.number, name, arguments),)


def _find_parts(state: State, seed: int) -> Outcome:
    if state.scan is None:
        raise CommandRefused("there is no scan to find parts in")
    arguments = {"scan": state.scan, "seed": seed}
    return _begin(state, "localize", arguments, state.scan.digest, "finding parts")


def _make_plan(state: State, command: MakePlan) -> Outcome:
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
        "seed": command.seed,
    }
    inputs_digest = digest_of((state.scene_digest, state.detections))
    return _begin(state, "plan", arguments, inputs_digest, "planning")


def _approved(state: State, entry: Entry) -> State:
    if state.plan is None or state.proof is None:
        raise CommandRefused("there is no proven plan to approve")
    approval = approve(state.cell, state.plan, state.proof, entry.actor, entry.at)
    message = f"plan {state.plan.digest[:12]} approved by {entry.actor}"
    return replace(state, phase=Phase.APPROVED, approval=approval, message=message)


def _send(state: State, entry: Entry) -> Outcome:
    if state.plan is None or state.approval is None:
        raise CommandRefused("there is no approved plan to send")
    message = f"{entry.actor} sends plan {state.plan.digest[:12]}"
    after = replace(state, phase=Phase.SENDING, receipts=(), parts_placed=0, message=message)
    return after, (Send(state.plan, state.approval),)


def _cancel(state: State, entry: Entry) -> Outcome:
    if state.job is None:
        return state, ()
    # The job leaves the state at once; whatever it still brings is recorded and not used.
    message = f"task {state.job.name!r} cancelled by {entry.actor}"
    return replace(state, job=None, message=message), (StopJob(state.job.number),)


def _job_ended(
    state: State, number: int, result: Scan | tuple[Detection, ...] | PlanResult | WorkbenchError
) -> State:
    job = state.job
    if job is None or job.number != number:
        return state
    state = replace(state, job=None)
    match (job.name, result):
        case (_, JobCancelled()):
            return replace(state, message=f"task {job.name!r} was cancelled")
        case (_, WorkbenchError()):
            return replace(state, message=f"task {job.name!r} failed: {result}")
        case ("scan", Scan()):
            return _with_scan(state, result)
        case ("localize", tuple()):
            return _with_detections(state, result)
        case ("plan", PlanResult()):
            return _with_plan(state, result)
        case _:
            wrong = type(result).__name__
            return replace(state, message=f"task {job.name!r} failed: it brought a {wrong}")


def _anew(state: State, phase: Phase = Phase.IDLE, **fields: Any) -> State:
    """The state with its cell and all that is about it, and nothing else but what is given."""
    return State(
        state.cell,
        phase,
        state.number,
        before=state.before,
        undone=state.undone,
        saved=state.saved,
        placed=state.placed,
        cell_problem=state.cell_problem,
        **fields,
    )


def _changed_cell(state: State, cell: Cell, says: str) -> Outcome:
    after, effects = _with_cell(state, cell, says)
    return replace(after, before=(state.cell, *state.before)[:MOST_UNDO], undone=()), effects


def _with_cell(state: State, cell: Cell, message: str) -> Outcome:
    """Another cell: a scan stays as long as the scanner does, what was made of it does not."""
    # Where the controller is found is not a matter of the cell file that people write.
    cell = replace(cell, controller=state.cell.controller)
    same_view = digest_of(cell.scanner) == digest_of(state.cell.scanner)
    scan = state.scan if same_view and state.phase is not Phase.DONE else None
    state = replace(state, cell=cell)
    if scan is None:
        return _anew(state, message=message), (UseCell(cell),)
    after = _anew(state, Phase.SCANNED, scan=scan, scene_digest=scan.digest, message=message)
    return after, (UseCell(cell),)


def _cell_read(state: State, command: CellRead) -> Outcome:
    cell, problem = command.cell, command.problem
    if cell is None:
        message = f"the cell file cannot be used, the cell stays as it was: {problem}"
        return replace(state, cell_problem=problem, message=message), ()
    state = replace(state, cell_problem="", saved=cell.digest)
    if cell.digest == state.cell.digest:
        return replace(state, message="the cell is as in its file"), ()
    if command.is_saved:
        # What a file can hold differs from what was shown by less than anybody can see.
        return _with_cell(state, cell, "the cell is saved")
    return _changed_cell(state, cell, "the cell file was changed, and is read again")


def _with_scan(state: State, scan: Scan) -> State:
    return _anew(
        state,
        Phase.SCANNED,
        scan=scan,
        scene_digest=scan.digest,
        message=f"scan with {len(scan.points):,} points",
    )


def _with_detections(state: State, detections: tuple[Detection, ...]) -> State:
    return _anew(
        state,
        Phase.LOCALIZED if detections else Phase.SCANNED,
        scan=state.scan,
        detections=detections,
        scene_digest=state.scan.digest if state.scan is not None else "",
        message=f"{_counted(len(detections), 'part')} found",
    )


def _with_outside_detections(state: State, detections: tuple[Detection, ...]) -> State:
    return _anew(
        state,
        Phase.LOCALIZED,
        # Poses from another matcher usually belong to this scan, but never to a picked bin.
        scan=None if state.phase is Phase.DONE else state.scan,
        detections=detections,
        scene_digest=digest_of(detections),
        message=f"{_counted(len(detections), 'pose')} taken from outside",
    )


def _with_plan(state: State, result: PlanResult) -> State:
    if result.plan is None:
        phase, message = Phase.LOCALIZED, f"no plan: {result.verdict}"
    elif result.proof is None or not result.proof.holds:
        phase = Phase.PLANNED
        finding = result.proof.findings[0] if result.proof is not None else "there is none"
        message = f"a plan was found, but its proof does not hold: {finding}"
    else:
        phase = Phase.PLANNED
        message = (
            f"plan ready: {result.plan.strategy}, {result.plan.cycle_seconds:.1f} s, "
            f"smallest clearance {result.proof.clearance * 1000:.1f} mm"
        )
    return replace(
        state,
        phase=phase,
        candidates=result.candidates,
        plan=result.plan,
        proof=result.proof,
        verdict=result.verdict,
        seconds=tuple(result.seconds.items()),
        obstacles=result.obstacles,
        outlines=(*state.outlines, *map(_outline, (*result.beside, result)))[-MOST_OUTLINES:],
        approval=None,
        receipts=(),
        parts_placed=0,
        message=message,
    )


def _outline(result: PlanResult) -> Outline:
    planning = sum(result.seconds.values())
    plan, proof = result.plan, result.proof
    if plan is None or proof is None:
        return Outline(result.planner, planning, verdict=str(result.verdict))
    distances = [float(d.min()) for _, _, d in proof.apart if len(d)]
    return Outline(
        result.planner,
        planning,
        str(plan.strategy),
        str(plan.guarantee),
        len(plan.arms),
        plan.cycle_seconds,
        proof.clearance,
        min(distances, default=None),
        plan.digest,
        "" if proof.holds else str(proof.findings[0]),
    )


def _sent(state: State, receipt: Receipt) -> State:
    message = f"{receipt.done} of {receipt.total} messages sent"
    return replace(state, receipts=(*state.receipts, receipt), message=message)


def _put_down(cell: Cell, plan: Plan) -> tuple[Detection, ...]:
    """The parts of a plan where its arms put them, for arms whose places keep them."""
    kinematics = Kinematics(cell)
    return tuple(
        Detection(
            plan.detections[one.detection].part,
            kinematics.tcp_pose(cell.arm(one.arm), np.asarray(one.leg("place").q[-1]))
            * one.T_tcp_part,
        )
        for one in plan.arms
        if cell.arm(one.arm).keeps_parts
    )


def _link_ended(state: State, fault: str, parts_placed: int) -> State:
    if state.plan is not None:
        # After a fault nobody knows: where a part may lie, none is put.
        state = replace(state, placed=(*state.placed, *_put_down(state.cell, state.plan)))
    if fault:
        return replace(
            state,
            phase=Phase.FAULT,
            fault=fault,
            parts_placed=parts_placed,
            message=f"fault while sending: {fault}",
        )
    expected = len(state.plan.arms) if state.plan is not None else 0
    message = f"cycle finished, {parts_placed} of {_counted(expected, 'part')} reported placed"
    return replace(state, phase=Phase.DONE, parts_placed=parts_placed, message=message)


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"

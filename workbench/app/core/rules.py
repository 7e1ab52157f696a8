"""What may happen now: pure checks; every refusal says what to do instead."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import assert_never

from workbench.app.core import commands
from workbench.app.core.cell_changes import (
    check_edit,
    check_emptying,
    check_import,
    check_tool,
    part_of,
)
from workbench.app.core.control import control_problem
from workbench.app.core.outcomes import outcome_problem, step_problem
from workbench.app.core.people import MACHINES, NOBODY, Role
from workbench.app.core.release import (
    changes_problem,
    is_same_person,
    lacks_people,
    left_on_station,
    length_problem,
    other_row,
    said_already,
    stale_because,
    unapproved_row,
    untold,
    unwatched,
)
from workbench.app.core.rights import RIGHTS, lacks_right, lacks_role, obstacle
from workbench.app.core.state import State
from workbench.app.core.value_checks import (
    DETAIL,
    MOST_OBSERVATIONS,
    MOST_PARTS,
    SEED_LIMIT,
    check_among,
    check_cell,
    check_configuration,
    check_detections,
    check_integer,
    check_number,
    check_overrides,
    check_person,
    check_text,
    strategies_of,
)
from workbench.model.cell import MOST_PICKS, Cell
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, NotAllowed
from workbench.model.plan import UNSIGNED, Plan, Proof, Proven
from workbench.model.release import AS_PLANNED, SLOWEST, Approval, Manner, Vote
from workbench.model.scan import ALL_KINDS
from workbench.plugins.robot_link import misfit

NOT_REPORTED: Mapping[str, float] = MappingProxyType({})


def allowed(
    state: State,
    command: commands.Command,
    actor: str,
    now: float,
    joints: Mapping[str, float] = NOT_REPORTED,
    role: Role = Role.ENGINEER,
) -> None:
    """Let a command pass, or say why not.

    Args:
        state: as it is.
        command: what is asked for.
        actor: who asks: a person's name, or one of `MACHINES`.
        now: seconds since the epoch.
        joints: how the robot stands by its own report, name -> [rad]; empty when it reports none.
        role: of the person who asks; that of somebody at the machine's own shell is engineer.

    Raises:
        CommandRefused: with a sentence for the one who asked; `NotAllowed` when it is a matter of
            the role alone.
    """
    _check_actor(command, actor)
    if actor not in MACHINES and (problem := lacks_role(type(command), role)):
        raise NotAllowed(problem)
    _refuse(lacks_right(state, type(command), actor, role))
    if problem := obstacle(state, type(command)):
        raise CommandRefused(problem)
    match command:
        case commands.TakeScan() as command:
            _check_scan(state.cell, command)
        case commands.FindParts() as command:
            _check_search(command)
            if state.scan is None:
                raise CommandRefused("finding parts is not possible now: take a scan first")
            if command.is_compared and not state.detections:
                raise CommandRefused("no parts were found yet that another search compares with")
        case commands.UseDetections(detections=detections, says=says):
            check_text("says", says)
            check_detections(state.cell, detections)
        case commands.SightPlate(arm=arm, q=q, seed=seed):
            check_integer("seed", seed, 0, SEED_LIMIT - 1)
            check_configuration(state.cell, arm, q)
            if len(state.observations) >= MOST_OBSERVATIONS:
                raise CommandRefused(
                    f"up to {MOST_OBSERVATIONS} poses are taken; remove one of them first"
                )
        case commands.UseObservations(observations=observations, says=says):
            check_text("says", says)
            if len(observations) > MOST_OBSERVATIONS:
                raise CommandRefused(f"up to {MOST_OBSERVATIONS} poses are taken")
            for observation in observations:
                check_text("name", observation.name)
                check_configuration(state.cell, observation.arm, observation.q)
        case commands.MakePlan() as command:
            _check_planning(state.cell, command)
        case commands.GoOn(scan=scan, find=find, plan=planning):
            _check_scan(state.cell, scan)
            _check_search(find)
            _check_planning(state.cell, planning)
            if find.is_compared:
                raise CommandRefused("going on takes what it finds, so that is not only compared")
        case commands.Approve(digest, speed_share=share, is_stepped=is_stepped, row=row):
            plan = _named_plan(state, digest)
            check_number("speed share", share, SLOWEST, 1.0, "of the planned speed")
            if is_stepped not in (True, False):
                raise CommandRefused(f"step by step is either so or not, {is_stepped!r} is neither")
            _check_scene(state, plan)
            if state.proof is None:
                raise CommandRefused("the plan has no proof, so it cannot be approved")
            whole = [proven_plan.plan for proven_plan in state.whole_row]
            _refuse(other_row(state, row) or untold(state) or left_on_station(whole))
            for observation in state.whole_row:
                check_approvable(
                    state.cell, observation.plan, observation.proof, actor, (share, is_stepped)
                )
            _refuse(stale_because(state, plan, joints))
            _refuse(unwatched(state, actor))
            _refuse(said_already(state, actor, now, (share, is_stepped)))
        case commands.SendPlan(plan_digest=digest):
            plan = _named_plan(state, digest)
            _refuse(staleness(state.approval, plan, state.cell, state.scene_digest, now))
            _refuse(unwalked(state.cell, state.proof))
            if state.approval is not None:
                _refuse(misfit(plan, state.cell, state.approval.manner))
                _refuse(unapproved_row(state, state.approval) or untold(state))
            _refuse(stale_because(state, plan, joints))
            if state.row and not joints:
                raise CommandRefused(
                    "the controller reports no joints, so nobody knows where the robot stands "
                    "between two plans; shorten the row to one plan"
                )
        case commands.NextStep(number=number):
            check_integer("number", number, 1, SEED_LIMIT - 1)
            _refuse(step_problem(state, number, now))
        case commands.AcknowledgeChanges(ran=ran):
            check_text("ran", ran)
            _refuse(changes_problem(state, ran))
        case commands.WatchPlan(plan_digest=digest, row=row):
            _named_plan(state, digest)
            _refuse(other_row(state, row))
        case commands.ShortenRow(plan_digest=digest, picks=picks):
            _named_plan(state, digest)
            check_integer("picks", picks, 1, MOST_PICKS)
            _refuse(length_problem(state, picks))
        case commands.WantThreshold(threshold=threshold):
            check_number("threshold", threshold, 0.0, 1.0, "m")
        case commands.ReportPick():
            check_text("why", command.why)
            _refuse(outcome_problem(state, command))
        case commands.ForgetAvoided():
            if not state.avoided:
                raise CommandRefused("nothing is avoided")
        case commands.ChangeCell(cell=cell, says=says):
            check_text("says", says)
            check_cell(cell)
            if cell.digest == state.cell.digest:
                raise CommandRefused("nothing of the cell was changed")
        case commands.UndoCell():
            if not state.before:
                raise CommandRefused("there is no change of the cell to undo")
        case commands.RedoCell():
            if not state.undone:
                raise CommandRefused("there is no change of the cell to redo")
        case commands.EditPart() as edit:
            check_text("says", edit.says)
            check_edit(state.cell, edit)
        case commands.ImportPart() as command:
            check_import(state.cell, command)
        case commands.AddTool() as command:
            check_tool(state.cell, command)
        case commands.TryEmptying() as command:
            check_emptying(state.cell, command)
        case commands.DropDraft(part=part):
            part_of(state.cell, part)
        case commands.EmptyPallets():
            if not state.placed:
                raise CommandRefused("the pallets are empty already")
        case commands.SaveCell(remark=remark):
            check_text("remark", remark)
            if state.saved == state.cell.digest:
                raise CommandRefused("the cell is saved already")
        case (
            commands.AskForControl()
            | commands.TakeControl()
            | commands.GiveControl()
            | commands.DenyControl()
            | commands.ReleaseControl()
        ) as about:
            _refuse(control_problem(state, about, actor, role))
        case commands.LinkEnded(parts_placed=parts_placed):
            check_integer("parts_placed", parts_placed, 0, SEED_LIMIT - 1)
        case (
            commands.UseScan()
            | commands.Stop()
            | commands.CancelJob()
            | commands.AcknowledgeFault()
            | commands.JobEnded()
            | commands.Sent()
        ):
            pass
        case commands.Started() | commands.Opened() | commands.CellRead() | commands.PosesRefused():
            pass
        case _:
            assert_never(command)


def approve(
    cell: Cell,
    plan: Plan,
    proof: Proof,
    actor: str,
    now: float,
    before: tuple[Vote, ...] = (),
    *,
    is_unwatched: bool = False,
    ran: str = "",
    manner: Manner = AS_PLANNED,
    row: Sequence[Proven] = (),
) -> Approval:
    """A person's vote for exactly this plan, valid as long as the cell's policy says.

    Args:
        cell: the cell as it is now.
        plan: what will be sent.
        proof: of this plan, in this cell.
        actor: the name of the person.
        now: seconds since the epoch.
        before: the votes of others that count along; the first of all votes decides the end.
        is_unwatched: the plan was not played to its end before who approves it; on record.
        ran: digest of the inventory of what runs here; on record.
        manner: at which share of the planned speed it is sent, and whether step by step.
        row: what the vote lets out after the plan, one after the other.

    Raises:
        CommandRefused: nobody is named, a proof does not hold, plan, proof and cell do not
            belong together, or too few people have given a vote.
    """
    check_approvable(cell, plan, proof, actor, manner)
    for proven_plan in row:
        check_approvable(cell, proven_plan.plan, proven_plan.proof, actor, manner)
        if proven_plan.plan.scan_digest != plan.scan_digest:
            raise CommandRefused("plans of a row are made after one scan, these are not")
    approval = Approval(
        plan_digest=plan.digest,
        proof_digest=proof.digest,
        cell_digest=cell.digest,
        scan_digest=plan.scan_digest,
        actor=actor,
        at=now,
        until=min((now, *(vote.at for vote in before))) + cell.policy.approval_minutes * 60.0,
        before=before,
        is_unwatched=is_unwatched,
        ran=ran,
        speed_share=manner[0],
        is_stepped=manner[1],
        row=tuple((proven_plan.plan.digest, proven_plan.proof.digest) for proven_plan in row),
    )
    _refuse(lacks_people(cell, approval))
    return approval


def check_approvable(
    cell: Cell, plan: Plan, proof: Proof, actor: str, manner: Manner = AS_PLANNED
) -> None:
    """Look whether a person may give a vote for a plan in this cell, sent in this manner.

    Raises:
        CommandRefused: see `approve`, which asks this, too.
    """
    check_person(actor)
    if is_same_person(actor, NOBODY):
        raise CommandRefused(
            f"{actor!r} is who acts without a login; a person approves by a name of their own"
        )
    if digest_of(plan, without=UNSIGNED) != plan.digest:
        raise CommandRefused("the plan was changed after it was made; make a new one")
    if plan.cell_digest != cell.digest:
        raise CommandRefused("the cell has changed since the plan was made; make a new plan")
    if proof.plan_digest != plan.digest:
        raise CommandRefused("the proof is that of another plan; make a new plan")
    if proof.cell_digest != cell.digest or proof.scan_digest != plan.scan_digest:
        raise CommandRefused("the proof was made for another cell or scan; make a new plan")
    if not proof.holds:
        raise CommandRefused(f"the proof does not hold: {proof.violations[0]}")
    _refuse(unwalked(cell, proof) or misfit(plan, cell, manner))


def unwalked(cell: Cell, proof: Proof | None) -> str:
    """Why a proof says nothing about the cell's controller; empty when it does.

    The controller is not in the cell's digest: a session may go on with another one.
    """
    if proof is None or cell.zone > proof.zone:
        return (
            f"the controller rounds corners by {cell.zone:g} of the segments, which the proof has "
            "not walked; make a new plan"
        )
    return ""


def staleness(
    approval: Approval | None, plan: Plan, cell: Cell, scan_digest: str, now: float
) -> str:
    """Why an approval does not cover this plan, in this cell, for this scan, now.

    Empty when it does.  A clock that was set back to before the approval ends it too.
    """
    if approval is None:
        return "nobody has approved the plan"
    if digest_of(plan, without=UNSIGNED) != plan.digest:
        return "the plan was changed after it was made; make a new one"
    if approval.plan_digest != plan.digest:
        return "the approval is for another plan; have this one approved"
    if approval.cell_digest != cell.digest or plan.cell_digest != cell.digest:
        return "the cell has changed since the approval; make a new plan"
    if approval.scan_digest != scan_digest or plan.scan_digest != scan_digest:
        return "there is a newer scan than that of the approval; make a new plan"
    if not approval.at <= now < approval.until:
        return (
            f"the approval by {approval.actor} was valid for "
            f"{(approval.until - approval.at) / 60:.0f} minutes and has run out; approve again"
        )
    return lacks_people(cell, approval)


def _refuse(problem: str) -> None:
    if problem:
        raise CommandRefused(problem)


def _check_actor(command: commands.Command, actor: str) -> None:
    right = RIGHTS[type(command)]
    if right.by_machine and actor not in MACHINES:
        raise CommandRefused(f"{right.says} is reported by a machine, not by {actor!r}")
    is_allowed = (right.by_anybody and actor in MACHINES) or actor == right.also_by
    if not right.by_machine and not is_allowed:
        check_person(actor)


def _check_scan(cell: Cell, command: commands.TakeScan) -> None:
    check_among("part", command.part, ("", ALL_KINDS, *(part.name for part in cell.parts)))
    check_integer("seed", command.seed, 0, SEED_LIMIT - 1)
    check_integer("parts", command.parts, 1, MOST_PARTS)


def _check_search(command: commands.FindParts) -> None:
    check_integer("seed", command.seed, 0, SEED_LIMIT - 1)
    check_number("detail", command.overrides.detail, *DETAIL, "of the usual")
    check_number("least score", command.overrides.least_score, 0.0, 1.0, "")


def _check_planning(cell: Cell, command: commands.MakePlan) -> None:
    check_integer("seed", command.seed, 0, SEED_LIMIT - 1)
    check_overrides(cell, command.overrides)
    check_number("threshold", command.threshold, 0.0, 1.0, "m")
    check_among("strategy", command.strategy, strategies_of(cell))


def _named_plan(state: State, digest: str) -> Plan:
    """The current plan, provided that it is the one meant."""
    check_text("plan", digest)
    if state.plan is None:
        raise CommandRefused("there is no plan; make a plan first")
    if state.plan.digest != digest:
        raise CommandRefused(
            f"the current plan is {state.plan.digest[:12]}, not {digest[:12]}: "
            "look at the current one and decide again"
        )
    return state.plan


def _check_scene(state: State, plan: Plan) -> None:
    if plan.scan_digest != state.scene_digest:
        raise CommandRefused("there is a newer scan than that of the plan; make a new plan")

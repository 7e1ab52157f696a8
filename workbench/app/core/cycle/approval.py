"""Approval: votes of people for a plan, and when they are enough."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

from workbench.app.core.command import Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.standing import lacks_reports, left_on_station, stale_because
from workbench.app.core.cycle.watching import explain_unwatched, has_seen, other_row
from workbench.app.core.hands import full_hand_problem
from workbench.app.core.people import NOBODY, fold_name, is_same_person
from workbench.app.core.state import Phase, State, row_message
from workbench.app.core.value_checks import check_number, check_person, named_plan
from workbench.model.cell import Cell
from workbench.model.derived.row_parts import tool_change_in_row
from workbench.model.digest import LATER, digest_of
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText, NameText
from workbench.model.messages.message import Message, all_of
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import StateText
from workbench.model.plan import UNSIGNED, Plan, Proof, Proven
from workbench.model.release import AS_PLANNED, SLOWEST, Approval, Manner, Vote, manner_words
from workbench.plugins.misfit import misfit


@dataclass(frozen=True, slots=True, eq=False)
class Approve(Command):
    """A person's vote for the plan with this digest, sent in this manner; see `Approval`.

    It is for those after it as well, the digests of which are its `row`.
    """

    right: ClassVar[Right] = Right(
        CommandText.APPROVE, frozenset({Phase.PLANNED, Phase.APPROVED}), without_control=True
    )

    plan_digest: str
    speed_share: float = field(default_factory=lambda: 1.0, metadata=LATER)
    is_stepped: bool = field(default_factory=bool, metadata=LATER)
    row: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)

    def check(self, state: State, asked: Asked) -> None:
        plan = named_plan(state, self.plan_digest)
        manner = self.speed_share, self.is_stepped
        check_number(
            NameText.SPEED_SHARE, self.speed_share, SLOWEST, 1.0, NameText.OF_PLANNED_SPEED
        )
        if self.is_stepped not in (True, False):
            raise CommandRefused(Refusal.NO_MANNER(value=repr(self.is_stepped)))
        if plan.scan_digest != state.scene_digest:
            raise CommandRefused(Refusal.NEWER_SCAN())
        if state.proof is None:
            raise CommandRefused(Refusal.NO_PROOF())
        plans = [proven_plan.plan for proven_plan in state.whole_row]
        refuse(other_row(state, self.row) or lacks_reports(state) or left_on_station(plans))
        for proven_plan in state.whole_row:
            check_approvable(state.cell, proven_plan.plan, proven_plan.proof, asked.actor, manner)
        refuse(full_hand_problem(state))
        refuse(stale_because(state, plan, asked.joints))
        refuse(explain_unwatched(state, asked.actor))
        refuse(approved_already(state, asked.actor, asked.now, manner))

    def apply(self, state: State, entry: Entry) -> Decision:
        return _approve(state, entry, self), ()


def approve(
    cell: Cell,
    plan: Plan,
    proof: Proof,
    actor: str,
    now: float,
    before: tuple[Vote, ...] = (),
    *,
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
        manner: at which share of the planned speed it is sent, and whether step by step.
        row: plans that the vote also allows, in order, after the plan.

    Raises:
        CommandRefused: nobody is named, a proof does not hold, plan, proof and cell do not
            belong together, or too few people have given a vote.  Or one of a row changes a tool.
    """
    check_approvable(cell, plan, proof, actor, manner)
    refuse(tool_change_in_row((plan, *(proven_plan.plan for proven_plan in row))))
    for proven_plan in row:
        check_approvable(cell, proven_plan.plan, proven_plan.proof, actor, manner)
        if proven_plan.plan.scan_digest != plan.scan_digest:
            raise CommandRefused(Refusal.OTHER_SCANS())
    began = min((now, *(vote.at for vote in before)))
    approval = replace(
        _approval(cell, plan, proof, actor, now),
        until=began + cell.policy.approval_minutes * 60.0,
        before=before,
        speed_share=manner[0],
        is_stepped=manner[1],
        row=tuple((proven_plan.plan.digest, proven_plan.proof.digest) for proven_plan in row),
    )
    refuse(lacks_people(cell, approval))
    return approval


def let_out(cell: Cell, plan: Plan, proof: Proof, by: str, now: float) -> Approval:
    """The release of a plan without approval: of its poses, and none of its paths.

    Args:
        cell: as it is now; its robot link sends poses alone.
        plan: whose poses are sent.
        proof: of this plan, in this cell.
        by: who has switched approval off (`unapproved`).
        now: seconds since the epoch.

    Raises:
        CommandRefused: see `approve`; or the robot link sends paths.
    """
    check_approvable(cell, plan, proof, by)
    approval = _approval(cell, plan, proof, by, now)
    approval = replace(approval, is_unwatched=True, is_switched_off=True)
    refuse(lacks_people(cell, approval))
    return approval


def _approval(cell: Cell, plan: Plan, proof: Proof, actor: str, now: float) -> Approval:
    """An approval of this plan and proof in this cell, from now on."""
    return Approval(
        plan_digest=plan.digest,
        proof_digest=proof.digest,
        cell_digest=cell.digest,
        scan_digest=plan.scan_digest,
        actor=actor,
        at=now,
        until=now + cell.policy.approval_minutes * 60.0,
    )


def check_approvable(
    cell: Cell, plan: Plan, proof: Proof, actor: str, manner: Manner = AS_PLANNED
) -> None:
    """Check that a person may vote for a plan in this cell, sent in this manner.

    Raises:
        CommandRefused: see `approve`, which asks this, too.
    """
    check_person(actor)
    if is_same_person(actor, NOBODY):
        raise CommandRefused(Refusal.NO_LOGIN(person=repr(actor)))
    if digest_of(plan, without=UNSIGNED) != plan.digest:
        raise CommandRefused(Refusal.PLAN_CHANGED())
    if plan.cell_digest != cell.digest:
        raise CommandRefused(Refusal.CELL_CHANGED())
    if proof.plan_digest != plan.digest:
        raise CommandRefused(Refusal.OTHER_PROOF())
    if proof.cell_digest != cell.digest or proof.scan_digest != plan.scan_digest:
        raise CommandRefused(Refusal.PROOF_OUTDATED())
    if not proof.holds:
        raise CommandRefused(Refusal.PROOF_FAILS(violation=proof.violations[0].message))
    refuse(explain_unwalked(cell, proof))
    if problem := misfit(plan, cell, manner):
        raise CommandRefused(problem)


def explain_unwalked(cell: Cell, proof: Proof | None) -> Message | None:
    """Why a proof says nothing about the cell's controller; None when it does.

    The controller is not in the cell's digest: a session may continue with another one.
    """
    if proof is None or cell.zone > proof.zone:
        return Refusal.CORNERS_UNPROVEN(zone=f"{cell.zone:g}")
    return None


def staleness(
    approval: Approval | None, plan: Plan, cell: Cell, scan_digest: str, now: float
) -> Message | None:
    """Why an approval does not cover this plan, in this cell, for this scan, now.

    None when it does.  A clock that was set back to before the approval ends it too.
    """
    if approval is None:
        return Refusal.NOT_APPROVED()
    if digest_of(plan, without=UNSIGNED) != plan.digest:
        return Refusal.PLAN_CHANGED()
    if approval.plan_digest != plan.digest:
        return Refusal.OTHER_APPROVED()
    if approval.cell_digest != cell.digest or plan.cell_digest != cell.digest:
        return Refusal.CELL_CHANGED_SINCE()
    if approval.scan_digest != scan_digest or plan.scan_digest != scan_digest:
        return Refusal.SCAN_SINCE()
    if not approval.at <= now < approval.until:
        minutes = round((approval.until - approval.at) / 60)
        return Refusal.APPROVAL_LAPSED(person=approval.actor, minutes=minutes)
    return lacks_people(cell, approval)


def lacks_people(cell: Cell, approval: Approval) -> Message | None:
    """Why an approval is by too few people for the cell; None when it is not."""
    if approval.is_switched_off:
        if not cell.controller.motion.sends_poses:
            return Refusal.NOT_APPROVED()
        return None
    different = {fold_name(name) for name in approval.people}
    if len(different) >= cell.approvers:
        return None
    return Refusal.TOO_FEW_PEOPLE(count=cell.approvers, people=approval.people)


def approved_already(state: State, actor: str, now: float, manner: Manner) -> Message | None:
    """Why a person need not approve again while somebody else's vote is missing; else None."""
    wanted = state.cell.approvers
    mine = any(
        is_same_person(vote.actor, actor) and vote.manner == manner
        for vote in standing_votes(state, now)
    )
    if not mine or len(votes_of_others(state, actor, now, manner)) + 1 >= wanted:
        return None
    return Refusal.APPROVED_ALREADY(person=actor, count=wanted)


def standing_votes(state: State, now: float) -> tuple[Vote, ...]:
    """The votes for the current plan that have not lapsed at `now` [s since the epoch]."""
    valid = state.cell.policy.approval_minutes * 60.0
    digest = state.plan.digest if state.plan is not None else ""
    return tuple(
        vote
        for vote in state.votes
        if vote.plan_digest == digest and vote.at <= now < vote.at + valid
    )


def votes_of_others(state: State, actor: str, now: float, manner: Manner) -> tuple[Vote, ...]:
    """The standing votes of others that count together with the vote of `actor`, the latest last.

    Votes for another manner of sending (speed share, whether step by step) do not.
    """
    others = [
        vote
        for vote in standing_votes(state, now)
        if not is_same_person(vote.actor, actor) and vote.manner == manner
    ]
    wanted = state.cell.approvers - 1
    return tuple(others[-wanted:]) if wanted else ()


def _approve(state: State, entry: Entry, vote: Approve) -> State:
    if state.plan is None or state.proof is None:
        raise CommandRefused(Refusal.NO_PROVEN_PLAN())
    manner = vote.speed_share, vote.is_stepped
    before = votes_of_others(state, entry.actor, entry.at, manner)
    votes = (*before, Vote(state.plan.digest, entry.actor, entry.at, *manner))
    wanted, words = state.cell.approvers, manner_words(*manner)
    unseen: list[str] = []
    if len(votes) < wanted:
        message = StateText.VOTED(people=_names(votes), count=len(votes), total=wanted)
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
            manner=manner,
            row=state.row,
        )
        ran = "" if state.ran is None else state.ran.digest
        approval = replace(approval, is_unwatched=bool(unseen), ran=ran)
        message = StateText.APPROVED(plan=row_message(state), people=_names(votes))
        state = replace(state, phase=Phase.APPROVED, approval=approval)
    if words:
        message = StateText.TO_BE_SENT(what=message, manner=words)
    shown = StateText.UNSEEN(people=unseen) if unseen else None
    return replace(state, votes=votes, message=all_of((message, shown)))


def _names(votes: tuple[Vote, ...]) -> tuple[str, ...]:
    return tuple(vote.actor for vote in votes)

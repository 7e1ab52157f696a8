"""A row of plans on its way: after each whether the next one follows, and why it does not."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.command import Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.approval import explain_unwalked, staleness
from workbench.app.core.cycle.standing import left_on_station, stale_because
from workbench.app.core.effects import Send
from workbench.app.core.picks import SendingEnd
from workbench.app.core.state import Phase, State, without_approval
from workbench.app.core.value_checks import check_integer, named_plan
from workbench.model.cell import MOST_PICKS
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import FoundPart, Message, Others, all_of, as_message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import RowStop, StateText
from workbench.model.plan import Plan, Proven
from workbench.model.release import Approval, PickResult

Followed = tuple[State, tuple[Send, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class ShortenRow(Command):
    """Carry out only the first `picks` plans of the row that begins with the plan of this digest.

    What was left out so comes back with a larger number.
    """

    right: ClassVar[Right] = Right(
        CommandText.SHORTEN_ROW, frozenset({Phase.PLANNED, Phase.APPROVED})
    )

    plan_digest: str
    picks: int

    def check(self, state: State, asked: Asked) -> None:
        named_plan(state, self.plan_digest)
        check_integer("picks", self.picks, 1, MOST_PICKS)
        refuse(length_problem(state, self.picks))

    def apply(self, state: State, entry: Entry) -> Decision:
        return shorten_row(state, self.picks, entry.actor), ()


def length_problem(state: State, picks: int) -> Message | None:
    """Why a row cannot have this length; None when it can."""
    most = 1 + len(state.row) + len(state.left_out)
    if not 1 <= picks <= most:
        return Refusal.ROW_LENGTH(most=most, count=picks)
    if picks == 1 + len(state.row):
        return Refusal.ROW_IS_SO_LONG(count=picks)
    every = (state.plan, *(proven_plan.plan for proven_plan in (*state.row, *state.left_out)))
    return left_on_station([plan for plan in every[:picks] if plan is not None])


def shorten_row(state: State, picks: int, actor: str) -> State:
    """Set the number of plans in the row; this cancels the approval.

    Whoever has watched the whole row has also watched a shorter one.
    """
    every = (*state.row, *state.left_out)
    is_shorter = picks <= len(state.row)
    return replace(
        without_approval(state),
        row=every[: picks - 1],
        left_out=every[picks - 1 :],
        watched=state.watched if is_shorter else (),
        watched_elsewhere=state.watched_elsewhere if is_shorter else (),
        message=StateText.ROW_LENGTH(person=actor, count=picks, total=1 + len(every)),
    )


def unapproved_row(state: State, approval: Approval) -> Message | None:
    """Why an approval does not cover exactly the plans that follow; None when it does."""
    if approval.row == tuple(
        (proven_plan.plan.digest, proven_plan.proof.digest) for proven_plan in state.row
    ):
        return None
    return Refusal.OTHER_ROW_APPROVED()


def following(state: State) -> Plan | None:
    """The plan after the one that is sent; None where it is the last."""
    return state.row[0].plan if state.row else None


def plans_sent(state: State) -> int:
    """The number of plans of the row that were sent, including the current one."""
    is_out = state.plan is not None and state.phase in (Phase.SENDING, Phase.DONE, Phase.FAULT)
    return len(state.sent_before) + is_out


def with_next_plan(state: State, after: State, ended: SendingEnd, entry: Entry) -> Followed:
    """The state in which the next plan of the row is sent, or in which the row has ended.

    No person has to act: the next plan was approved with the first.  Any doubt ends the row and
    the approval of its remaining plans.

    Args:
        state: the state while the plan was sent.
        after: the state after the end of this sending.
        ended: the link's report of the end.
        entry: states the time and the reported joints.
    """
    if not state.row or state.plan is None or state.proof is None:
        return after, ()
    proven_plan = state.row[0]
    approval = None if state.approval is None else state.approval.onward()
    problem = _ends_because(after, ended, entry, proven_plan, approval)
    done = (*state.sent_before, Proven(state.plan, state.proof))
    if problem or approval is None:
        why = RowStop.ENDED(
            count=len(done), total=len(done) + len(state.row), why=problem or RowStop.NOT_APPROVED()
        )
        if state.plan.stations:
            look = RowStop.LOOK_AT_STATION(station=state.plan.stations[0])
            why = Others.ALSO(first=why, last=look)
        message = after.message if ended.fault else all_of((as_message(after.message), why))
        # What was spent stays to be seen; nothing follows a row that is not there any more.
        return replace(after, row=(), row_ends=why, message=message), ()
    opening = {arm.arm for arm in proven_plan.plan.picks}
    after = replace(
        after,
        phase=Phase.SENDING,
        plan=proven_plan.plan,
        proof=proven_plan.proof,
        row=state.row[1:],
        # What was asked for the first one.
        bound=0.0,
        sent_before=done,
        approval=approval,
        receipts=(),
        part_reports=(),
        waits=0,
        let=0,
        let_until=approval.until,
        is_over=False,
        hands_open=tuple(arm for arm in after.hands_open if arm not in opening),
        message=StateText.NEXT_PLAN(number=len(done) + 1, total=len(done) + len(state.row)),
    )
    return after, (Send(proven_plan.plan, approval, following(after)),)


def _ends_because(
    after: State, ended: SendingEnd, entry: Entry, proven_plan: Proven, approval: Approval | None
) -> Message | None:
    """Why the next plan must not follow; None when it may."""
    if ended.fault:
        return as_message(ended.fault)
    if after.stopped_by:
        return RowStop.STOPPED_BY(person=after.stopped_by)
    if ended.row_ends:
        return as_message(ended.row_ends)
    if after.plan is None or len(ended.parts) < len(after.plan.picks):
        return RowStop.NO_REPORT()
    for part in ended.parts:
        if part.is_picked is not True:
            if part.why:
                return RowStop.NOT_PICKED_SINCE(arm=part.arm, why=part.why)
            return RowStop.NOT_PICKED(arm=part.arm)
    for said in after.outcomes:
        # A person has seen more than the gripper felt.
        if said.became is PickResult.DOUBLE:
            return RowStop.TWO_PARTS(part=FoundPart(said.detection), person=said.by)
        if not said.is_picked:
            return RowStop.PERSON_SAYS(part=FoundPart(said.detection), person=said.by)
    if approval is None or approval.proof_digest != proven_plan.proof.digest:
        return RowStop.NOT_APPROVED()
    if not entry.joints:
        return RowStop.NO_JOINTS()
    return (
        staleness(approval, proven_plan.plan, after.cell, after.scene_digest, entry.at)
        or explain_unwalked(after.cell, proven_plan.proof)
        or stale_because(after, proven_plan.plan, entry.joints)
    )

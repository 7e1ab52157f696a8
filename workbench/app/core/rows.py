"""A row of plans on its way: after each whether the next one follows, and why it does not."""

from dataclasses import replace

from workbench.app.core.commands import Entry, LinkEnded
from workbench.app.core.effects import Send
from workbench.app.core.release import stale_because
from workbench.app.core.rules import staleness, unwalked
from workbench.app.core.state import Phase, State, counted
from workbench.model.messages.message import all_of, as_message, plain
from workbench.model.plan import Plan, Proven
from workbench.model.release import Approval

Followed = tuple[State, tuple[Send, ...]]


def following(state: State) -> Plan | None:
    """The plan after the one that is sent; None where it is the last."""
    return state.row[0].plan if state.row else None


def plans_sent(state: State) -> int:
    """How many plans of the row have gone out, the one on its way among them."""
    is_out = state.plan is not None and state.phase in (Phase.SENDING, Phase.DONE, Phase.FAULT)
    return len(state.sent_before) + is_out


def row_said(state: State) -> str:
    """The plan and those after it, for people."""
    plan = "" if state.plan is None else state.plan.digest[:12]
    return f"plan {plan}" + (f" and {len(state.row)} after it" if state.row else "")


def with_next_plan(state: State, after: State, ended: LinkEnded, entry: Entry) -> Followed:
    """The state in which the next plan of the row is on its way, or in which the row has ended.

    Nothing is asked of a person: the next plan was approved with the first one.  Whatever is in
    doubt ends the row, and what would have let the rest of it out.

    Args:
        state: while the plan was sent that has ended.
        after: that, as the end of this one sending leaves it.
        ended: what the link says of the end.
        entry: says when, and how the robot stood by its own report.
    """
    if not state.row or state.plan is None or state.proof is None:
        return after, ()
    proven_plan = state.row[0]
    approval = None if state.approval is None else state.approval.onward()
    problem = _ends_because(after, ended, entry, proven_plan, approval)
    done = (*state.sent_before, Proven(state.plan, state.proof))
    if problem or approval is None:
        count = f"{len(done)} of {counted(len(done) + len(state.row), 'plan')}"
        words = f"the row has ended after {count}: {problem}"
        if state.plan.stations:
            words += (
                f"; look whether a part is on station {state.plan.stations[0]}, and take it away"
            )
        why = plain(words)
        message = after.message if ended.fault else all_of((as_message(after.message), why))
        # What was spent stays to be seen; nothing follows a row that is not there any more.
        return replace(after, row=(), row_ends=why, message=message), ()
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
        message=f"plan {len(done) + 1} of {len(done) + len(state.row)} follows",
    )
    return after, (Send(proven_plan.plan, approval, following(after)),)


def _ends_because(
    after: State, ended: LinkEnded, entry: Entry, proven_plan: Proven, approval: Approval | None
) -> str:
    """Why the next plan must not follow; empty when it may."""
    if ended.fault:
        return ended.fault
    if after.stopped_by:
        return f"stopped by {after.stopped_by}"
    if ended.row_ends:
        return ended.row_ends
    if after.plan is None or len(ended.parts) < len(after.plan.arms):
        return "the robot link has not told what became of each part"
    for part in ended.parts:
        if part.is_picked is not True:
            why = f": {part.why}" if part.why else ""
            return f"the {part.arm} arm has not reported its part as picked{why}"
    for said in after.outcomes:
        # A person has seen more than the gripper felt.
        if not said.is_picked:
            return f"part-{said.detection + 1} was not picked, says {said.by}"
    if approval is None or approval.proof_digest != proven_plan.proof.digest:
        return "nobody has approved what would follow"
    if not entry.joints:
        return "the controller does not report where the robot stands"
    return (
        staleness(approval, proven_plan.plan, after.cell, after.scene_digest, entry.at)
        or unwalked(after.cell, proven_plan.proof)
        or stale_because(after, proven_plan.plan, entry.joints)
    )

"""Sending: the plan goes out, step by step where that was approved, and ends or is stopped."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.after_a_miss import with_end
from workbench.app.core.command import Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.ahead import discard_ahead, finish_ahead, scan_ahead
from workbench.app.core.cycle.approval import explain_unwalked, staleness
from workbench.app.core.cycle.empty_hand import with_new_tool
from workbench.app.core.cycle.outcomes import after_sending
from workbench.app.core.cycle.rows import following, unapproved_row, with_next_plan
from workbench.app.core.cycle.standing import lacks_reports, stale_because
from workbench.app.core.effects import LetStep, Send, StopSending
from workbench.app.core.hands import arms_that_may_hold
from workbench.app.core.picks import SendingEnd
from workbench.app.core.rights import changes_said
from workbench.app.core.state import Phase, RunState, State, begin_stage, row_message
from workbench.app.core.value_checks import SEED_LIMIT, check_integer, named_plan
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import AheadText, NextText, PosesText, StateText
from workbench.model.plan import Plan
from workbench.model.release import Receipt
from workbench.model.tools.held_body import largest_part
from workbench.plugins.misfit import misfit


@dataclass(frozen=True, slots=True, eq=False)
class SendPlan(Command):
    """Send the approved plan with this digest to the robot, and its row as far as all is well."""

    right: ClassVar[Right] = Right(CommandText.SEND_PLAN, frozenset({Phase.APPROVED}))

    plan_digest: str

    @classmethod
    def obstacle(cls, state: State) -> Message | None:
        if not state.changed:
            return None
        return Refusal.ACKNOWLEDGE_FIRST(changes=changes_said(state))

    def check(self, state: State, asked: Asked) -> None:
        plan = named_plan(state, self.plan_digest)
        refuse(staleness(state.approval, plan, state.cell, state.scene_digest, asked.now))
        refuse(explain_unwalked(state.cell, state.proof))
        if state.approval is not None:
            if problem := misfit(plan, state.cell, state.approval.manner):
                raise CommandRefused(problem)
            refuse(unapproved_row(state, state.approval) or lacks_reports(state))
        refuse(stale_because(state, plan, asked.joints))
        if state.row and not asked.joints:
            raise CommandRefused(Refusal.ROW_NEEDS_JOINTS())

    def apply(self, state: State, entry: Entry) -> Decision:
        if state.plan is None or state.approval is None:
            raise CommandRefused(Refusal.NO_APPROVED_PLAN())
        message: Message = StateText.SENDS(person=entry.actor, plan=row_message(state))
        if state.cell.controller.motion.sends_poses:
            message = PosesText.SENDS(person=entry.actor, plan=row_message(state))
        begun = begin_stage(
            state,
            RunState,
            phase=Phase.SENDING,
            message=message,
            let_until=state.approval.until,
            # What a plan takes is no longer where a scan has shown it.
            earlier=state.earlier if state.plan.is_view_plan else None,
            hands_emptied=() if state.plan.picks else state.hands_emptied,
            hands_open=tuple(arm for arm in state.hands_open if arm not in _picking(state)),
            largest_sent=_largest_sent(state),
        )
        return begun, (Send(state.plan, state.approval, following(state)),)


@dataclass(frozen=True, slots=True, eq=False)
class NextStep(Command):
    """Let the step of the plan run that the robot waits before, which is `number`, from 1 on."""

    right: ClassVar[Right] = Right(
        CommandText.NEXT_STEP, frozenset({Phase.SENDING}), NextText.NOTHING_SENDING
    )

    number: int

    def check(self, state: State, asked: Asked) -> None:
        check_integer("number", self.number, 1, SEED_LIMIT - 1)
        refuse(step_problem(state, self.number, asked.now))

    def apply(self, state: State, entry: Entry) -> Decision:
        return with_step(state, self.number, entry.actor, entry.at), (LetStep(self.number),)


@dataclass(frozen=True, slots=True, eq=False)
class Stop(Command):
    """Stop sending and close the link."""

    # Nobody who sees that something goes wrong has to ask first.
    right: ClassVar[Right] = Right(
        CommandText.STOP, frozenset({Phase.SENDING}), NextText.NOTHING_SENDING, without_control=True
    )

    def apply(self, state: State, entry: Entry) -> Decision:
        says = StateText.STOPS_SENDING(person=entry.actor)
        stopped = replace(state, message=says, stopped_by=entry.actor)
        after, effects = discard_ahead(stopped, AheadText.PLAN_STOPPED())
        return after, (StopSending(), *effects)


@dataclass(frozen=True, slots=True, eq=False)
class Sent(Command):
    """The robot link reports one message that went out."""

    right: ClassVar[Right] = Right(
        CommandText.SENT, frozenset({Phase.SENDING}), NextText.NOTHING_SENDING, by_machine=True
    )

    receipt: Receipt

    def apply(self, state: State, entry: Entry) -> Decision:
        return scan_ahead(with_receipt(state, self.receipt), entry)


@dataclass(frozen=True, slots=True, eq=False)
class LinkEnded(SendingEnd, Command):
    """The robot link is closed."""

    right: ClassVar[Right] = Right(
        CommandText.LINK_ENDED,
        frozenset({Phase.SENDING}),
        NextText.NOTHING_SENDING,
        by_machine=True,
    )

    def check(self, state: State, asked: Asked) -> None:
        check_integer("parts_placed", self.parts_placed, 0, SEED_LIMIT - 1)

    def apply(self, state: State, entry: Entry) -> Decision:
        after = after_sending(state, self, entry.at)
        after, sends = with_next_plan(state, after, self, entry)
        after = with_end(state, after, self)
        after, effects = finish_ahead(state, after, entry)
        after, changes = with_new_tool(state, after, self)
        return after, (*sends, *effects, *changes)


def _largest_sent(state: State) -> tuple[float, float]:
    """The longest and heaviest part that a hand can hold from now on.

    A hand that may hold a part still does so until it opens in this plan.
    """
    if not _picking(state):
        return state.largest_sent
    now, before = largest_part(state.whole or state.cell), state.largest_sent
    is_any_full = bool(arms_that_may_hold(state))
    return (max(now[0], before[0]), max(now[1], before[1])) if is_any_full else now


def _picking(state: State) -> set[str]:
    """The arms that open their hands and take a part in the current plan."""
    return set() if state.plan is None else {arm.arm for arm in state.plan.picks}


def with_receipt(state: State, receipt: Receipt) -> State:
    """The state after one more message was sent."""
    state = replace(state, receipts=(*state.receipts, receipt))
    steps = () if state.plan is None else state.plan.sequence
    if state.plan is not None and 0 < receipt.waits == state.let + 1 <= len(steps):
        message = StateText.ROBOT_WAITS(step=step_message(state.plan, receipt.waits))
        return replace(state, waits=receipt.waits, message=message)
    if state.let:
        # The message of a step names who has let it run.
        return state
    step = step_reported(state)
    if state.plan is not None and 0 < step <= len(steps):
        return replace(state, message=StateText.ROBOT_RUNS(step=step_message(state.plan, step)))
    return replace(state, message=StateText.MESSAGES_SENT(count=receipt.done, total=receipt.total))


def step_reported(state: State) -> int:
    """The last step that the robot reported, as running or waiting, counted from 1.

    0: no report, as with links that have no steps.
    """
    return max((receipt.step or receipt.waits for receipt in state.receipts), default=0)


def placed_by_now(state: State) -> int:
    """How many parts are placed, by the ends of plans and by the steps of the plan on its way.

    The hand is open once a step comes after the last one with the part in it.  A pick that the
    gripper reports as failed places none, nor does a plan that puts its parts onto a station.
    """
    step, plan = step_reported(state), state.plan
    if state.phase is not Phase.SENDING or plan is None or plan.stations or not step:
        return state.parts_placed
    last = {
        name: number
        for number, each in enumerate(plan.sequence, 1)
        for name, leg in each.runs
        if plan.arm(name).leg(leg).holding
    }
    parts = (receipt.part for receipt in state.receipts)
    failed = {part.arm for part in parts if part is not None and part.is_picked is False}
    return state.parts_placed + sum(
        last.get(pick.arm, step) < step for pick in plan.picks if pick.arm not in failed
    )


def step_message(plan: Plan, number: int) -> Message:
    """A step of a plan, counted from 1, for people."""
    legs = plan.sequence[number - 1].words
    return StateText.STEP(number=number, total=len(plan.sequence), legs=legs)


def step_problem(state: State, number: int, now: float) -> Message | None:
    """Why a step may not run now; None when it may."""
    if state.approval is None or not state.approval.is_stepped:
        return Refusal.NOT_STEPPED()
    if not state.waits:
        return Refusal.WAITS_NOWHERE()
    if number != state.waits:
        return Refusal.OTHER_STEP(step=state.waits, named=number)
    if not state.approval.at <= now < state.let_until:
        return Refusal.STEPS_LAPSED(minutes=f"{state.cell.policy.approval_minutes:g}")
    return None


def with_step(state: State, number: int, actor: str, at: float) -> State:
    """The state after a person has allowed a step, at a time [s since the epoch]."""
    if state.plan is None:
        return state
    message = StateText.STEP_LET(step=step_message(state.plan, number), person=actor)
    until = at + state.cell.policy.approval_minutes * 60.0
    return replace(state, waits=0, let=number, let_until=until, message=message)
